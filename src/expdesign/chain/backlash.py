"""What play of a leg and of a joint have in common, as effects.

Play of an actuator, the same in a leg and in a joint.
"""

from typing import ClassVar

import casadi as ca

from expdesign.chain.component import reference_force, turning
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.row import Row

SLACK = 1e-3
"""N or N·m; an actuator with less force than this rests where it rested unloaded."""


def with_play(elongation: ca.SX, force: ca.SX, row: Row, actuator: int, gap: ca.SX, ends: tuple[float, float]) -> ca.SX:
    """Elongations (n_p,) with the way from where the unloaded actuator rests to the end at which its force holds it.

    Args:
        elongation: of all actuators (n_p,), m or rad.
        force: by which the load changes the actuators' forces (n_p,), N or N·m.
        row: of the recordings; its reference state may be loaded.
        actuator: which one has play.
        gap: its size, m or rad.
        ends: places in gaps, relative to where it rests unloaded, to which a positive and a negative force push it.
    """

    def place(total: ca.SX) -> ca.SX:
        return ca.if_else(total > SLACK, ends[0], ca.if_else(total < -SLACK, ends[1], 0.0))

    before = reference_force(row)[actuator]
    gained = ca.SX.zeros(elongation.shape[0])
    gained[actuator] = gap * (place(before + force[actuator]) - place(before))
    return elongation + gained


_ENDS = ((0.5, -0.5), (1.0, 0.0), (0.0, -1.0))
"""Upper and lower end of the gap, in gaps, relative to where the unloaded actuator rests, for each of the variants."""


class Backlash(Effect):
    """Δq gains the way from where the unloaded actuator rests to the end of the gap at which its force holds it.

    Variants, in this order: it rests in the middle of the gap, at its lower and at its upper end.

    Attributes:
        gap: typical and largest size (m or rad).
    """

    gap: ClassVar[tuple[float, float]]

    def describe(self) -> tuple[Parameter, ...]:
        typical, largest = self.gap
        name = "gap_rad" if turning(self.robot, self.actuators) else "gap_m"
        return (Parameter(name, typical, low=0.0, high=largest),)

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        ends = _ENDS[self.forms.index(self.variant)]
        return with_play(elongation, force, row, self.component.index, theta[0], ends), state

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        name, value = next(iter(values.items()))
        size = f"{1e6 * value[0]:.3g} ({1e6 * value[1]:.3g} to {1e6 * value[2]:.3g})"
        return f"{self.subject} has {size} {'µrad' if name == 'gap_rad' else 'µm'} of play."

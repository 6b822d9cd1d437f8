"""Play of an actuator, the same in a leg and in a joint."""

import casadi as ca

from expdesign.chain.components import reference_force
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

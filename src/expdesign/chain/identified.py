"""The chain beside what a calibration has identified, about which it is linear.

A calibrated geometry has dozens of parameters that hardly move when further physics is fitted beside them, while
derivatives through a geometry of symbols cost ten times those through numbers. So further effects act on the geometry
as it was identified, and the readings follow its parameters to first order about that. They follow the frames of
instrument and markers to first order as well: if these turned exactly and the joints did not, a joint's zero and the
instrument's turn would together stretch the readings by half the square of the angle, which no machine does.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.chain import Chain
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.models.drawn import Drawn
from expdesign.chain.models.estimable import Estimable
from expdesign.chain.row import Row, RowData
from expdesign.mechanics.minimal_set import MinimalSet
from expdesign.mechanics.robots.robot import Robot

_MOST_KEPT = 8
"""Sets of rows whose derivatives are kept."""


@dataclass(frozen=True, eq=False)
class Identified:
    """What a calibration has identified.

    Attributes:
        chain: with the effects that belong to the base model from now on.
        values: its parameters, shape (p,).
        deviations: of all parameters before anything was measured, as the calibration sized them, shape (p,).
        minimal: parameters of the chain that its rows tell apart, and combinations of them which the others are.
        drawn: what no reading shows and the drawing alone says; None for nothing.
    """

    chain: Chain
    values: FloatArray
    deviations: FloatArray
    minimal: MinimalSet | None = None
    drawn: Drawn | None = None
    _known: list[tuple[RowData, FloatArray]] = field(default_factory=list, init=False, repr=False)

    @property
    def physics(self) -> frozenset[str]:
        """Identifiers of the physics of the effects."""
        return frozenset(effect.physics for effect in self.chain.effects)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Those of the chain, compliances and effects as well known beforehand as the calibration says."""
        read = slice(self.chain.compliances, self.chain.base)
        sized = [replace(p, spread=float(s)) for p, s in zip(self.chain.parameters, self.deviations, strict=True)]
        sized[read] = self.chain.parameters[read]
        return tuple(sized)

    def beside(self, effects: Sequence[Effect] = ()) -> "ChainBeside":
        """The chain with further effects."""
        return ChainBeside(self.chain.robot, effects, self)

    def slopes(self, rows: RowData) -> FloatArray:
        """Derivatives of the readings with respect to all parameters but the compliances, (N, k, p − `compliances`)."""
        for known, slopes in self._known:
            if known is rows:
                return slopes
        found = self.chain.predict_with_sensitivities(rows, self.values)[1][..., self.chain.compliances :]
        self._known.append((rows, found))
        del self._known[:-_MOST_KEPT]
        return found


class ChainBeside(Chain):
    """`Chain` whose base model includes what was identified: its parameters come after those of the reading.

    Args:
        robot: the robot.
        effects: physics beside it.
        identified: what was identified, about which readings follow geometry and frames to first order.
    """

    def __init__(self, robot: Robot, effects: Sequence[Effect], identified: Identified) -> None:
        super().__init__(robot, tuple(effects), reading=identified.chain.reading)
        own, known = self.base, identified.parameters
        further = known[own:]
        self.identified = identified
        self.held = _ChainOn(robot, tuple(effects), identified)
        self.parameters = (*known, *self.parameters[own:])
        self.slices = [slice(part.start + len(further), part.stop + len(further)) for part in self.slices]
        self.base = own + len(further)
        self._part = slice(own, self.base)

    @property
    def exact(self) -> Chain:
        """The chain that is not linear in what was identified, with the same parameters."""
        return Chain(self.robot, (*self.identified.chain.effects, *self.effects), reading=self.reading)

    @property
    def drawn(self) -> Drawn | None:
        """What the drawing alone says of parameters that `in_frames` leaves as found; the others are free."""
        minimal, drawn = self.identified.minimal, self.identified.drawn
        if minimal is None or drawn is None:
            return None
        held = minimal.standing_in(slice(self.compliances, self._part.start))
        return replace(drawn, steps=drawn.steps[:, drawn.steps[held].any(axis=0)])

    def about(self, values: FloatArray) -> "ChainBeside":
        """The same chain, linear about other values of its parameters (p,)."""
        return replace(self.identified, values=values[: self.base]).beside(self.effects)

    def start(self) -> FloatArray:
        return np.concatenate([self.identified.values, *(effect.neutral() for effect in self.effects)])

    def expression(self, row: Row, state: ca.SX, theta: ca.SX) -> tuple[ca.SX, ca.SX]:
        return self.exact.expression(row, state, theta)

    def without_identified(self, values: FloatArray) -> FloatArray:
        """The parameters of `held` among those of the chain (p,)."""
        return np.delete(values, self._part)

    def in_frames(self, known: Estimable) -> Estimable:
        """What is known of the parameters where those that stand for the frames of instrument and markers are as found.

        It names the frame that positions of the tip are in: where no row tells joint 1's zero from the instrument's
        turn, that of the joint at its zero. What instrument and markers are known by is the readings, not a prior, so
        that predictions of readings are as uncertain as before.
        """
        minimal = self.identified.minimal
        if minimal is None:
            return known
        return known.given(minimal.standing_in(slice(self.compliances, self._part.start)))

    def _run(self, rows: RowData, values: FloatArray, *, derivatives: bool) -> tuple[FloatArray, FloatArray | None]:
        followed = slice(self.compliances, self.base)
        there = values.copy()
        there[followed] = self.identified.values[followed]
        readings, others = self.held._run(rows, self.without_identified(there), derivatives=derivatives)
        slopes = self.identified.slopes(rows)
        readings = readings + slopes @ (values - there)[followed]
        if others is None:
            return readings, None
        before, after = others[..., : self.compliances], others[..., self._part.start :]
        return readings, np.concatenate([before, slopes, after], axis=-1)


class _ChainOn(Chain):
    """The chain in which what was identified has its values, and no parameters."""

    def __init__(self, robot: Robot, effects: tuple[Effect, ...], identified: Identified) -> None:
        super().__init__(robot, effects, reading=identified.chain.reading)
        self._identified = identified

    def expression(self, row: Row, state: ca.SX, theta: ca.SX) -> tuple[ca.SX, ca.SX]:
        known = ca.SX(self._identified.values[self.base :])
        exact = Chain(self.robot, (*self._identified.chain.effects, *self.effects), reading=self.reading)
        return exact.expression(row, state, ca.vertcat(theta[: self.base], known, theta[self.base :]))

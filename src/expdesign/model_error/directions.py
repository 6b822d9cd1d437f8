"""How left-out physics moves the readings and the targets, to first order, as functions of pose and load.

All effects are put on one measurement chain, which at their neutral parameters is the base model: one Jacobian of its
reading then holds the directions of every effect. As functions of the configuration and of the load's own parameters
they have exact derivatives with respect to what a plan chooses.

Each row is taken to be a series of its own: what depends on history starts relaxed.
"""

from functools import cached_property

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.chain.chain import Chain
from expdesign.chain.effect import Effect
from expdesign.chain.linearised import KnownChain, row_at_rest
from expdesign.chain.row import Row
from expdesign.loads.load import Load
from expdesign.model_error.left_out import LeftOut
from expdesign.robots.robot import Robot
from expdesign.symbolic import BatchFunction


def row_expression(robot: Robot, load: Load, configuration: ca.SX, parameters: ca.SX) -> Row:
    """One row of a plan as expressions of the configuration (n_q,) and of the load's parameters (k,)."""
    forward, pose_map, _ = robot.jacobian_expressions(configuration)
    none = ca.SX.zeros(robot.coordinates.n)
    return row_at_rest(robot, load, configuration, parameters, forward, pose_map, none)


class Directions:
    """Derivatives of what a robot does with respect to the parameters of left-out physics.

    Args:
        robot: the robot.
        load: the kind of load.
        physics: what is left out.
        instrument: whether the instrument's reading is meant, or the motion of the platform.
        known: the chain that the robot was found to have; what is left out acts beside it.

    Attributes:
        base: number of compliances, whose columns come first (in units of 1/apK: the observation matrix A·diag(1/apK));
            then follow those of the physics in their order, one for every parameter that is not a shape.
        columns: number of all columns.
    """

    def __init__(
        self,
        robot: Robot,
        load: Load,
        physics: tuple[LeftOut, ...],
        *,
        instrument: bool = True,
        known: KnownChain | None = None,
    ) -> None:
        self.load, self.physics, self.instrument = load, physics, instrument
        self.robot = robot if known is None else known.chain.robot
        self._effects = () if known is None else known.chain.effects
        self._values = np.ones(len(robot.stiffness)) if known is None else known.values
        self.base = len(robot.stiffness)
        self.columns = self.base + sum(entry.columns for entry in physics)

    @cached_property
    def _expression(self) -> tuple[ca.SX, ca.SX, ca.SX]:
        """Configuration, load parameters and the directions (n, D)."""
        configuration = ca.SX.sym("q", len(self.robot.configuration))
        parameters = ca.SX.sym("load", len(self.load.columns))
        row = row_expression(self.robot, self.load, configuration, parameters)
        # An effect with memory has kinks where its force is zero, at which it would disturb the derivatives of others.
        blocks = ca.SX.zeros(self.robot.coordinates.n, self.columns)
        start = self.base + offsets(self.physics)
        for memory in (False, True):
            chosen = [i for i, e in enumerate(self.physics) if not e.step and (e.effect.states > 0) == memory]
            jacobian = self._jacobian(row, [self.physics[i] for i in chosen])
            blocks[:, [int(start[i]) + c for i in chosen for c in range(self.physics[i].columns)]] = jacobian[
                :, self.base :
            ]
            if not memory:
                blocks[:, : self.base] = jacobian[:, : self.base]
        for entry, column in zip(self.physics, start, strict=False):
            if entry.step:
                blocks[:, int(column)] = self._mean(row, entry)
        return configuration, parameters, ca.densify(blocks)

    def _chain(self, physics: list[LeftOut]) -> Chain:
        effects: tuple[Effect, ...] = (*self._effects, *(entry.effect for entry in physics))
        return Chain(self.robot, effects, instrument=self.instrument)

    def _jacobian(self, row: Row, physics: list[LeftOut]) -> ca.SX:
        """Derivatives of one row with respect to the compliances and to the physics, (n, base + columns)."""
        chain = self._chain(physics)
        theta = ca.SX.sym("theta", len(chain.parameters))
        reading, _ = chain.expression(row, ca.SX.zeros(chain.states), theta)
        values = np.concatenate([self._values, *(entry.start for entry in physics)])
        known = range(self.base, len(self._values))
        free = [i for i, parameter in enumerate(chain.parameters) if i not in known and not parameter.shape]
        return ca.substitute(ca.jacobian(reading, theta)[:, free], theta, ca.SX(values))

    def _mean(self, row: Row, entry: LeftOut) -> ca.SX:
        """Mean derivative of one row with respect to the one parameter of an entry, from its start on, (n,)."""
        chain = self._chain([entry])
        ends = [
            chain.expression(row, ca.SX.zeros(chain.states), ca.SX(np.concatenate([self._values, values])))[0]
            for values in (entry.stepped, entry.start)
        ]
        return (ends[0] - ends[1]) / entry.step

    @cached_property
    def _function(self) -> BatchFunction:
        configuration, parameters, directions = self._expression
        # The targets are looked at once, which does not pay for taking common terms together.
        outputs = [ca.cse(directions) if self.instrument else directions]
        return BatchFunction("directions", [configuration, parameters], outputs)

    def at(self, configurations: FloatArray, loads: FloatArray) -> FloatArray:
        """Directions at configurations (..., n_q) under loads (..., k), shape (..., n, D); recorded where these are."""
        (directions,) = self._function(configurations, loads)
        return directions.reshape(*directions.shape[: configurations.ndim - 1], -1, self.columns)


def offsets(physics: tuple[LeftOut, ...]) -> IntArray:
    """First column of every entry, and the number of all columns, shape (E + 1,)."""
    return np.cumsum([0, *(entry.columns for entry in physics)], dtype=np.int64)

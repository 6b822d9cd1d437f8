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
from expdesign.chain.row import Row
from expdesign.loads.load import Load
from expdesign.model_error.left_out import LeftOut
from expdesign.robots.robot import Robot
from expdesign.symbolic import BatchFunction


def row_expression(robot: Robot, load: Load, configuration: ca.SX, parameters: ca.SX) -> Row:
    """One row of a plan as expressions of the configuration (n_q,) and of the load's parameters (k,).

    The counterpart of `chain.row.row_data`: nothing was carried in the reference state, and no time passes.
    """
    forward, pose_map, rotation = robot.jacobian_expressions(configuration)
    n, n_p, dimension = robot.coordinates.n, len(robot.stiffness), len(robot.gravity)
    payload = load.kind == "payload"
    gravity = parameters[-dimension:] if payload else ca.SX(robot.gravity)
    lever = ca.SX.zeros(dimension)
    if payload and robot.coordinates.centre_of_mass:
        lever = rotation @ parameters[1:4]
    position, rates, lengths, own = robot.commanded_state(configuration, gravity)
    wrench = load.wrench(parameters, rotation)
    return Row(
        pose=configuration, wrench=wrench, absolute=wrench, own=own, carried=ca.SX.zeros(n_p), weight=ca.SX.zeros(n),
        marker=ca.SX.zeros(0), gravity=gravity, position=position, lever=lever, payload=ca.SX(float(payload)),
        rotation=rotation, rates=rates, forward=forward, pose_map=pose_map, lengths=lengths,
        warming=ca.SX.zeros(max(n_p, 1)), elapsed=ca.SX(0.0), clock=ca.SX(0.0), interval=ca.SX(0.0), first=ca.SX(1.0),
        number=ca.SX(0.0), reference=ca.SX(0.0),
    )  # fmt: skip


class Directions:
    """Derivatives of what a robot does with respect to the parameters of left-out physics.

    Args:
        robot: the robot.
        load: the kind of load.
        physics: what is left out.
        instrument: whether the instrument's reading is meant, or the motion of the platform.

    Attributes:
        base: number of compliances, whose columns come first (in units of 1/apK: the observation matrix A·diag(1/apK));
            then follow those of the physics in their order, one for every parameter that is not a shape.
        columns: number of all columns.
    """

    def __init__(self, robot: Robot, load: Load, physics: tuple[LeftOut, ...], *, instrument: bool = True) -> None:
        self.robot, self.load, self.physics, self.instrument = robot, load, physics, instrument
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
            jacobian = _jacobian(self.robot, row, [self.physics[i] for i in chosen], instrument=self.instrument)
            blocks[:, [int(start[i]) + c for i in chosen for c in range(self.physics[i].columns)]] = jacobian[
                :, self.base :
            ]
            if not memory:
                blocks[:, : self.base] = jacobian[:, : self.base]
        for entry, column in zip(self.physics, start, strict=False):
            if entry.step:
                blocks[:, int(column)] = _mean(self.robot, row, entry, instrument=self.instrument)
        return configuration, parameters, ca.densify(blocks)

    @cached_property
    def _function(self) -> BatchFunction:
        configuration, parameters, directions = self._expression
        # The targets are looked at once, which does not pay for taking common terms together.
        outputs = [self._compact if self.instrument else directions]
        return BatchFunction("directions", [configuration, parameters], outputs)

    @cached_property
    def _compact(self) -> ca.SX:
        return ca.cse(self._expression[2])

    @cached_property
    def _adjoint(self) -> BatchFunction:
        configuration, parameters, _ = self._expression
        seed = ca.SX.sym("seed", self._compact.numel())
        scalar = ca.dot(ca.vec(self._compact), seed)
        outputs = [ca.gradient(scalar, configuration), ca.gradient(scalar, parameters)]
        return BatchFunction("directions_adjoint", [configuration, parameters, seed], ca.cse(outputs))

    def at(self, configurations: FloatArray, loads: FloatArray) -> FloatArray:
        """Directions at configurations (..., n_q) under loads (..., k), shape (..., n, D)."""
        (directions,) = self._function(configurations, loads)
        return directions.reshape(*directions.shape[: configurations.ndim - 1], -1, self.columns)

    def pull(self, configurations: FloatArray, loads: FloatArray, seed: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Adjoint of `at`: derivatives of Σ seed∘directions with respect to configurations and loads.

        Args:
            configurations: (..., n_q).
            loads: (..., k).
            seed: shape (..., n, D).
        """
        # CasADi's vec stacks columns.
        flat = np.ascontiguousarray(seed.swapaxes(-1, -2)).reshape(*seed.shape[:-2], -1)
        configuration, load = self._adjoint(configurations, loads, flat)
        return configuration.reshape(configurations.shape), load.reshape(loads.shape)


def _jacobian(robot: Robot, row: Row, physics: list[LeftOut], *, instrument: bool) -> ca.SX:
    """Derivatives of one row with respect to the compliances and to the physics, (n, base + columns)."""
    effects: tuple[Effect, ...] = tuple(entry.effect for entry in physics)
    chain = Chain(robot, effects, instrument=instrument)
    theta = ca.SX.sym("theta", len(chain.parameters))
    reading, _ = chain.expression(row, ca.SX.zeros(chain.states), theta)
    values = np.concatenate([np.ones(chain.compliances), *(entry.start for entry in physics)])
    free = [i for i, parameter in enumerate(chain.parameters) if not parameter.shape]
    return ca.substitute(ca.jacobian(reading, theta)[:, free], theta, ca.SX(values))


def _mean(robot: Robot, row: Row, entry: LeftOut, *, instrument: bool) -> ca.SX:
    """Mean derivative of one row with respect to the one parameter of an entry, from its start on, (n,)."""
    chain = Chain(robot, (entry.effect,), instrument=instrument)
    ends = [
        chain.expression(row, ca.SX.zeros(chain.states), ca.SX(np.concatenate([np.ones(chain.compliances), values])))[0]
        for values in (entry.stepped, entry.start)
    ]
    return (ends[0] - ends[1]) / entry.step


def offsets(physics: tuple[LeftOut, ...]) -> IntArray:
    """First column of every entry, and the number of all columns, shape (E + 1,)."""
    return np.cumsum([0, *(entry.columns for entry in physics)], dtype=np.int64)

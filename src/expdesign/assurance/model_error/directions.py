"""How left-out physics moves the readings and the targets, to first order, as functions of pose and load.

The effects of one class are put on one measurement chain, which at their neutral parameters is the base model: one
Jacobian of its reading then holds the directions of all of them.

Each row is taken to be a series of its own: what depends on history starts relaxed.
"""

from functools import cached_property

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.assurance.model_error.left_out import Omitted, offsets
from expdesign.chain.chain import Chain
from expdesign.chain.effect import Effect
from expdesign.chain.linearised import KnownChain, row_at_rest
from expdesign.chain.row import row_symbols
from expdesign.mechanics.loads.load import Load
from expdesign.mechanics.robots.robot import Jacobians, Robot
from expdesign.mechanics.symbolic import BatchFunction


class Directions:
    """Derivatives of what a robot does in one row with respect to the parameters of left-out physics.

    Args:
        robot: the robot.
        physics: what is left out.
        known: the chain that the robot was found to have; what is left out acts beside it.

    Attributes:
        columns: number of columns, one for every parameter that is not a shape, in the order of `physics`.
    """

    def __init__(self, robot: Robot, physics: tuple[Omitted, ...], known: KnownChain | None = None) -> None:
        self.robot = robot if known is None else known.chain.robot
        self.physics = physics
        self.columns = int(offsets(physics)[-1])
        self._effects = () if known is None else known.chain.effects
        self._values = np.ones(len(robot.stiffness)) if known is None else known.values
        self._row = row_symbols(self.robot)
        self._blocks: dict[tuple[type[Effect], bool, bool], ca.SX] = {}
        self._functions: dict[str, BatchFunction] = {}

    def at(self, load: Load, configurations: FloatArray, loads: FloatArray, maps: Jacobians) -> FloatArray:
        """Directions in readings at configurations (..., n_q) under loads (..., k), shape (..., n, D).

        Args:
            load: the kind of load.
            configurations: of the rows.
            loads: parameters of their loads.
            maps: the kinematic maps there, which the base model has computed.
        """
        (found,) = self._function(load)(configurations, loads, _flat(maps.forward), _flat(maps.pose))
        return found.reshape(*found.shape[: configurations.ndim - 1], -1, self.columns)

    def at_target(self, load: Load, configuration: FloatArray, parameters: FloatArray) -> FloatArray:
        """How the platform moves at a configuration (n_q,) under a load with parameters (k,), shape (n, D)."""
        maps = self.robot.jacobians(configuration[None])
        row = ca.Function("row", *self._row_of(load))(
            configuration, parameters, maps.forward.ravel(), maps.pose.ravel()
        )
        return np.array(self._motions(row))

    @cached_property
    def _motions(self) -> ca.Function:
        """How the platform moves, (n, D), of a row as `Row.flat` has it."""
        return self._expression(instrument=False)

    @cached_property
    def _readings(self) -> ca.Function:
        """What the instrument reads, (n, D), of such a row."""
        return self._expression(instrument=True)

    def _row_of(self, load: Load) -> tuple[list[ca.SX], list[ca.SX]]:
        """A configuration (n_q,), a load's parameters (k,), J and J̌ row by row; and their row (`Row.flat`)."""
        n, count = self.robot.coordinates.n, len(self.robot.stiffness)
        inputs = [ca.SX.sym("q", len(self.robot.configuration)), ca.SX.sym("load", len(load.columns))]
        maps = [ca.SX.sym("J", n * count), ca.SX.sym("Jx", n * count)]
        # NumPy flattens rows first, CasADi columns first.
        forward, pose_map = (ca.reshape(each, count, n).T for each in maps)
        row = row_at_rest(self.robot, load, inputs[0], inputs[1], forward, pose_map, ca.SX.zeros(n))
        return [*inputs, *maps], [row.flat()]

    def _function(self, load: Load) -> BatchFunction:
        if load.kind not in self._functions:
            inputs, (row,) = self._row_of(load)
            self._functions[load.kind] = BatchFunction("directions", inputs, [self._readings(row)])
        return self._functions[load.kind]

    def _expression(self, *, instrument: bool) -> ca.Function:
        classes: dict[tuple[type[Effect], bool], list[int]] = {}
        for index, entry in enumerate(self.physics):
            classes.setdefault((type(entry.effect), entry.effect.changes_geometry), []).append(index)
        start = offsets(self.physics)
        whole = ca.SX.zeros(self.robot.coordinates.n, self.columns)
        for (kind, geometry), chosen in classes.items():
            entries = [self.physics[i] for i in chosen]
            # Where nothing acts on the reading it is the motion of the platform.
            reads = any(effect.changes_reading for effect in (*self._effects, entries[0].effect))
            key = (kind, geometry, instrument and reads)
            if key not in self._blocks:
                self._blocks[key] = self._block(entries, instrument=key[2])
            whole[:, [int(start[i]) + c for i in chosen for c in range(self.physics[i].columns)]] = self._blocks[key]
        return ca.Function("directions_of_row", [self._row.flat()], [ca.densify(whole)])

    def _block(self, entries: list[Omitted], *, instrument: bool) -> ca.SX:
        """Directions of entries of one class, (n, columns)."""
        if all(entry.step for entry in entries):
            return ca.horzcat(*(self._mean(entry, instrument=instrument) for entry in entries))
        chain = Chain(self.robot, (*self._effects, *(entry.effect for entry in entries)), instrument=instrument)
        theta = ca.SX.sym("theta", len(chain.parameters))
        reading, _ = chain.expression(self._row, ca.SX.zeros(chain.states), theta)
        values = np.concatenate([self._values, *(entry.start for entry in entries)])
        free = [i for i, p in enumerate(chain.parameters) if i >= len(self._values) and not p.shape]
        if entries[0].effect.changes_geometry:
            derivatives = ca.jacobian(reading, theta)[:, free]
        else:
            # Forward, most of every direction is zero: the expressions are shorter than those of the adjoint.
            derivatives = ca.jtimes(reading, theta, ca.SX.eye(len(chain.parameters))[:, free])
        return ca.substitute(derivatives, theta, ca.SX(values))

    def _mean(self, entry: Omitted, *, instrument: bool) -> ca.SX:
        """Mean derivative of one row with respect to the one parameter of an entry, from its start on, (n,)."""
        chain = Chain(self.robot, (*self._effects, entry.effect), instrument=instrument)
        ends = [
            chain.expression(self._row, ca.SX.zeros(chain.states), ca.SX(np.concatenate([self._values, values])))[0]
            for values in (entry.stepped, entry.start)
        ]
        return (ends[0] - ends[1]) / entry.step


def _flat(matrices: FloatArray) -> FloatArray:
    return matrices.reshape(*matrices.shape[:-2], matrices.shape[-2] * matrices.shape[-1])

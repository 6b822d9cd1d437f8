"""How left-out physics moves the readings and the targets, to first order, as functions of pose and load.

The effects of one class are put on one measurement chain, which at their neutral parameters is the base model: one
Jacobian of its reading then holds the directions of all of them. They are derived as functions of what the chain may
use of a row, so that kinematics and load are put in once, for the effects that are wanted; and as functions of the
configuration and of the load's own parameters they have exact derivatives with respect to what a plan chooses.

Each row is taken to be a series of its own: what depends on history starts relaxed.
"""

from functools import cached_property

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.chain.chain import Chain
from expdesign.chain.effect import Effect
from expdesign.chain.linearised import KnownChain, row_at_rest
from expdesign.chain.row import row_symbols
from expdesign.loads.load import Load
from expdesign.model_error.left_out import LeftOut
from expdesign.robots.robot import Jacobians, Robot
from expdesign.symbolic import BatchFunction


class RowDirections:
    """Derivatives of what a robot does in one row with respect to the parameters of left-out physics, as expressions.

    Args:
        robot: the robot.
        physics: what is left out.
        known: the chain that the robot was found to have; what is left out acts beside it.

    Attributes:
        columns: number of columns, one for every parameter that is not a shape, in the order of `physics`.
    """

    def __init__(self, robot: Robot, physics: tuple[LeftOut, ...], known: KnownChain | None = None) -> None:
        self.robot = robot if known is None else known.chain.robot
        self.physics = physics
        self._effects = () if known is None else known.chain.effects
        self._values = np.ones(len(robot.stiffness)) if known is None else known.values
        self.columns = int(offsets(physics)[-1])
        self._row = row_symbols(self.robot)
        self._blocks: dict[tuple[type[Effect], bool, bool], ca.SX] = {}
        self._rows: dict[str, ca.Function] = {}

    @cached_property
    def readings(self) -> ca.Function:
        """What the instrument reads, (n, D), of a row as `Row.flat` has it."""
        return self._function(instrument=True)

    @cached_property
    def motions(self) -> ca.Function:
        """How the platform moves, (n, D), of a row as `Row.flat` has it."""
        return self._function(instrument=False)

    def row(self, load: Load) -> ca.Function:
        """A row (`Row.flat`) of a configuration (n_q,), a load's parameters (k,), and J and J̌ row by row."""
        if load.kind not in self._rows:
            n, count = self.robot.coordinates.n, len(self.robot.stiffness)
            configuration = ca.SX.sym("q", len(self.robot.configuration))
            parameters = ca.SX.sym("load", len(load.columns))
            maps = [ca.SX.sym("J", n * count), ca.SX.sym("Jx", n * count)]
            # NumPy flattens rows first, CasADi columns first.
            forward, pose_map = (ca.reshape(each, count, n).T for each in maps)
            row = row_at_rest(self.robot, load, configuration, parameters, forward, pose_map, ca.SX.zeros(n))
            self._rows[load.kind] = ca.Function("row", [configuration, parameters, *maps], [row.flat()])
        return self._rows[load.kind]

    def at_target(self, load: Load, configuration: FloatArray, parameters: FloatArray) -> FloatArray:
        """How the platform moves at a configuration (n_q,) under a load with parameters (k,), shape (n, D)."""
        jacobians = self.robot.jacobians(configuration[None])
        row = self.row(load)(configuration, parameters, jacobians.forward.ravel(), jacobians.pose.ravel())
        return np.array(self.motions(row))

    def _function(self, *, instrument: bool) -> ca.Function:
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

    def _block(self, entries: list[LeftOut], *, instrument: bool) -> ca.SX:
        """Directions of entries of one class, (n, columns)."""
        stepped = [entry for entry in entries if entry.step]
        if len(stepped) == len(entries):
            return ca.horzcat(*(self._mean(entry, instrument=instrument) for entry in entries))
        chain = Chain(self.robot, (*self._effects, *(entry.effect for entry in entries)), instrument=instrument)
        theta = ca.SX.sym("theta", len(chain.parameters))
        reading, _ = chain.expression(self._row, ca.SX.zeros(chain.states), theta)
        values = np.concatenate([self._values, *(entry.start for entry in entries)])
        known = len(self._values)
        free = [i for i, parameter in enumerate(chain.parameters) if i >= known and not parameter.shape]
        if entries[0].effect.changes_geometry:
            derivatives = ca.jacobian(reading, theta)[:, free]
        else:
            # Forward, most of every direction is zero: the expressions are shorter than those of the adjoint.
            derivatives = ca.jtimes(reading, theta, ca.SX.eye(len(chain.parameters))[:, free])
        return ca.substitute(derivatives, theta, ca.SX(values))

    def _mean(self, entry: LeftOut, *, instrument: bool) -> ca.SX:
        """Mean derivative of one row with respect to the one parameter of an entry, from its start on, (n,)."""
        chain = Chain(self.robot, (*self._effects, entry.effect), instrument=instrument)
        ends = [
            chain.expression(self._row, ca.SX.zeros(chain.states), ca.SX(np.concatenate([self._values, values])))[0]
            for values in (entry.stepped, entry.start)
        ]
        return (ends[0] - ends[1]) / entry.step


class Directions:
    """Directions in the readings of plans, or some of their columns.

    Args:
        rows: the directions of a row.
        load: the kind of load of the plans.
        columns: indices of the columns wanted; all where left out.
    """

    def __init__(self, rows: RowDirections, load: Load, columns: IntArray | None = None) -> None:
        self.rows, self.load = rows, load
        self.columns = np.arange(rows.columns) if columns is None else columns

    def part(self, columns: IntArray) -> "Directions":
        """Some of these columns."""
        return Directions(self.rows, self.load, self.columns[columns])

    @cached_property
    def _function(self) -> BatchFunction:
        row = self.rows.row(self.load)
        inputs = row.sx_in()
        directions = self.rows.readings(row(*inputs))[:, self.columns.tolist()]
        # All columns are looked at a few times in a search, which does not pay for taking common terms together.
        few = len(self.columns) < self.rows.columns
        return BatchFunction("directions", inputs, [ca.cse(directions) if few else directions])

    def at(self, configurations: FloatArray, loads: FloatArray, jacobians: Jacobians) -> FloatArray:
        """Directions at configurations (..., n_q) under loads (..., k), shape (..., n, D); recorded where these are.

        Args:
            configurations: of the rows.
            loads: parameters of their loads.
            jacobians: the kinematic maps there, which the base model has computed.
        """
        (directions,) = self._function(configurations, loads, _flat(jacobians.forward), _flat(jacobians.pose))
        return directions.reshape(*directions.shape[: configurations.ndim - 1], -1, len(self.columns))


def _flat(matrices: FloatArray) -> FloatArray:
    return matrices.reshape(*matrices.shape[:-2], matrices.shape[-2] * matrices.shape[-1])


def offsets(physics: tuple[LeftOut, ...]) -> IntArray:
    """First column of every entry, and the number of all columns, shape (E + 1,)."""
    return np.cumsum([0, *(entry.columns for entry in physics)], dtype=np.int64)

"""One row of recordings as symbols, and many rows as the numbers that stand for them."""

from dataclasses import dataclass, fields
from functools import cached_property, lru_cache

import casadi as ca
import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.chain.recordings.recordings import LoadedPoints, indicators
from expdesign.mechanics.robots.robot import Robot

LAGS = (300.0, 900.0, 2700.0, 8100.0)
"""Time constants (s) with which parts may follow the temperature: of a gauge, a leg, a column and a wall."""
_AT_ONCE = 1e-6
"""s; what is nearer in time has one temperature."""
_MOVES = 1e-9
"""m, rad; less is no move of an actuator."""


@dataclass(frozen=True, eq=False)
class Row:
    """What the links of the chain may use of one row (n coordinates, n_p actuators, d = 2 or 3).

    Attributes:
        pose: commanded configuration (n_q,).
        wrench: assumed change of the load (n,) at the origin of P along the axes of O.
        absolute: assumed whole load (n,).
        own: actuator forces by the robot's own weight (n_p,); 0 where the masses of its parts are not known.
        carried: actuator forces by own weight that positions show, and deflections do not (n_p,).
        weight: wrench of the robot's own weight about the origin of P along the axes of O where positions show it (n,).
        marker: 1 for the marker whose position was measured, 0 for the others (number of markers,).
        gravity: in O (d,).
        position: origin of P in O (d,), m.
        lever: R·(centre of mass) of a payload (d,), m; 0 where only the wrench is known.
        payload: 1 where the load is a payload, 0 where it is a free wrench (1,).
        rotation: R of the platform (d, d).
        rates: T with Ẋ = T·η (n, n).
        forward: J (n, n_p).
        pose_map: J̌ (n, n_p).
        lengths: commanded actuator lengths (n_p,), m or rad.
        warming: temperature above that of the series' first row, per actuator (n_p,), K; one for a body.
        warmth: temperature of that first row, likewise, °C.
        lagged: temperature that follows the recorded one to first order, for each of `LAGS`, °C.
        lagged_first: the same at the series' first row, °C.
        approach: sign of the last move of every actuator's command, 0 where it is not known (n_p,).
        unseen: 1 where rows are missing in which the robot may have moved, until it moves again (1,).
        elapsed: time since the series' first row (1,), s.
        clock: time as recorded, since the first row of the recordings that the model is from (1,), s.
        interval: time since the row before in the series (1,), s.
        first: 1 for the first row of a series (1,).
        number: place in the order of recording, `sequence` − 1 (1,).
        reference: the same of the row to which deflections are relative, the first of the series; 0 for positions (1,).
        point: 1 for the fixed point or gauge that was read, 0 for the others (number of them,).
        along: unit vector along a gauge in O (3,); nothing (0,) without such.
        aim: orientation from which rotations of targets are counted, columns first (9,); nothing (0,) without such.
    """

    pose: ca.SX
    wrench: ca.SX
    absolute: ca.SX
    own: ca.SX
    carried: ca.SX
    weight: ca.SX
    marker: ca.SX
    gravity: ca.SX
    position: ca.SX
    lever: ca.SX
    payload: ca.SX
    rotation: ca.SX
    rates: ca.SX
    forward: ca.SX
    pose_map: ca.SX
    lengths: ca.SX
    warming: ca.SX
    warmth: ca.SX
    lagged: ca.SX
    lagged_first: ca.SX
    approach: ca.SX
    unseen: ca.SX
    elapsed: ca.SX
    clock: ca.SX
    interval: ca.SX
    first: ca.SX
    number: ca.SX
    reference: ca.SX
    point: ca.SX
    along: ca.SX
    aim: ca.SX

    @cached_property
    def inverse(self) -> ca.SX:
        """J⁻¹ (n_p, n) of a robot with as many actuators as coordinates: one expression for all effects that use it."""
        return ca.solve(self.forward, ca.SX.eye(self.forward.shape[0]))

    @cached_property
    def reference_force(self) -> ca.SX:
        """Actuator forces (N or N·m) in the reference state: by own weight and by what was carried there, (n_p,)."""
        return self.own + self.forward.T @ (self.absolute - self.wrench)

    def flat(self) -> ca.SX:
        """All symbols as one column vector, columns of matrices first."""
        return self._flat

    def columns(self, name: str) -> slice:
        """Where the numbers of one of its symbols are in rows (`RowData.values`)."""
        start = 0
        for item in fields(self):
            width = getattr(self, item.name).numel()
            if item.name == name:
                return slice(start, start + width)
            start += width
        raise KeyError(name)

    @cached_property
    def _flat(self) -> ca.SX:
        return ca.vertcat(*(ca.vec(getattr(self, item.name)) for item in fields(self)))


@lru_cache(maxsize=32)
def row_symbols(robot: Robot, markers: int = 0, fixed: int = 0, *, oriented: bool = False) -> Row:
    """Symbols of one row of a robot's recordings, in which positions of `markers` were measured, and orientations.

    `fixed` is the number of fixed points and gauges. All chains of a robot share them, and with them what they have in
    common.
    """
    n, n_p, d, n_q = robot.coordinates.n, len(robot.stiffness), len(robot.gravity), len(robot.configuration)
    shapes = {
        "pose": (n_q, 1), "wrench": (n, 1), "absolute": (n, 1), "own": (n_p, 1), "carried": (n_p, 1),
        "weight": (n, 1), "marker": (markers, 1), "gravity": (d, 1),
        "position": (d, 1), "lever": (d, 1), "payload": (1, 1), "rotation": (d, d),
        "rates": (n, n), "forward": (n, n_p), "pose_map": (n, n_p), "lengths": (n_p, 1), "warming": (max(n_p, 1), 1),
        "warmth": (max(n_p, 1), 1), "lagged": (len(LAGS), 1), "lagged_first": (len(LAGS), 1), "approach": (n_p, 1),
        "unseen": (1, 1),
        "elapsed": (1, 1), "clock": (1, 1), "interval": (1, 1), "first": (1, 1),
        "number": (1, 1), "reference": (1, 1), "point": (fixed, 1),
        "along": (3 * (fixed > 0), 1), "aim": (9 * oriented, 1),
    }  # fmt: skip
    return Row(**{name: ca.SX.sym(name, *shape) for name, shape in shapes.items()})


@dataclass(frozen=True)
class RowData:
    """Numbers of N rows in the order of `Row.flat`, and how the rows follow each other.

    Attributes:
        values: shape (N, width).
        series: index of the series of each row, shape (N,).
        position: place of each row in its series, from 0, shape (N,).
    """

    values: FloatArray
    series: IntArray
    position: IntArray

    def __len__(self) -> int:
        return len(self.values)


def row_data(points: LoadedPoints, robot: Robot) -> RowData:
    """The numbers of loaded points.

    The reference state of a position is the weightless robot: own weight acts like a load, and is not in `own`.

    Temperatures of the legs are those of their sensors where there are some, else the one of the row; without time,
    a number of the sequence counts as one second (the tool then has no time constants to offer, see `Effect.when`).
    """
    count = len(points)
    n_p = len(robot.stiffness)
    jacobians = robot.jacobians(points.configurations)
    lever = np.zeros((count, len(robot.gravity)))
    if points.payload is not None and points.payload.shape[1] > 1:
        lever = (jacobians.rotation @ points.payload[:, 1:, None])[..., 0]
    series, first_row, position = _series_structure(points.series)
    number = points.sequence - 1.0
    time = points.time if points.time is not None else number
    previous = np.arange(count)
    later = position > 0
    order = np.lexsort((position, series))
    previous[order[1:]] = order[:-1]
    previous = np.where(later, previous, np.arange(count))
    temperature: FloatArray = np.zeros((count, max(n_p, 1)))
    if points.leg_temperature is not None and n_p:
        temperature = points.leg_temperature
    elif points.temperature is not None:
        temperature = np.repeat(points.temperature[:, None], max(n_p, 1), axis=1)

    lagged = _lagged(temperature.mean(axis=1), time)
    lengths = robot.actuator_coordinates(points.configurations)

    def columns_first(matrices: FloatArray) -> FloatArray:
        return matrices.swapaxes(-1, -2).reshape(count, -1)

    own = robot.own_weight(points.configurations, points.gravity)
    values = np.concatenate(
        [
            points.configurations,
            points.wrenches,
            points.absolute,
            points.measurand.reference(own),
            points.measurand.shown(own),
            points.measurand.shown(robot.weight_wrench(points.configurations, points.gravity)),
            points.marker_indicators,
            points.gravity,
            robot.position(points.configurations),
            lever,
            np.full((count, 1), float(points.payload is not None)),
            columns_first(jacobians.rotation),
            columns_first(robot.pose_rates(points.configurations)),
            columns_first(jacobians.forward),
            columns_first(jacobians.pose),
            lengths,
            temperature - temperature[first_row],
            temperature[first_row],
            lagged,
            lagged[first_row],
            *_approach(lengths, number),
            (time - time[first_row])[:, None],
            time[:, None],
            (time - time[previous])[:, None],
            (position == 0).astype(float)[:, None],
            number[:, None],
            points.measurand.reference(number[first_row][:, None]),
            indicators(points.point, len(points.fixed), count),
            np.zeros((count, 0)) if points.along is None else points.along,
            np.zeros((count, 0)) if points.aim is None else columns_first(points.aim),
        ],
        axis=1,
    )
    return RowData(values, series, position)


def _lagged(temperature: FloatArray, time: FloatArray) -> FloatArray:
    """Temperatures (N, lags) that follow one (N,) at times (N,): τ·dy/dt = T − y, in equilibrium at the first row.

    Between rows T is a straight line, behind which y is late by its slope times τ.
    """
    found = np.tile(temperature[:1, None], (len(temperature), len(LAGS)))
    if not np.any(temperature != temperature[:1]):  # most recordings have none
        return found
    for row, passed in enumerate(np.diff(time), start=1):
        found[row] = found[row - 1]
        if passed > _AT_ONCE:
            late = (temperature[row] - temperature[row - 1]) / passed * np.array(LAGS)
            off = found[row - 1] - temperature[row - 1] + late
            found[row] = temperature[row] - late + off * np.exp(-passed / np.array(LAGS))
    return found


def _approach(lengths: FloatArray, number: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Sign of the last move of every actuator (N, n_p), 0 before one is known, and where moves may be missing (N, 1).

    Rows are in their order. Where some are missing before one, nobody knows how it was reached; before the first of a
    campaign nothing is missing.
    """
    moves = np.diff(lengths, axis=0, prepend=lengths[:1])
    signs = np.where(np.abs(moves) > _MOVES, np.sign(moves), 0.0)
    missing = np.diff(number, prepend=-1.0) != 1.0
    signs[missing] = 0.0
    found = _last(signs, (signs != 0.0) | missing[:, None])
    unseen = _last(missing[:, None].astype(float), signs.any(axis=1, keepdims=True) | missing[:, None])
    return found, unseen


def _last(values: FloatArray, changed: BoolArray) -> FloatArray:
    """Values (N, k) as they were where they changed last; those of the first row before they did."""
    rows = np.where(changed, np.arange(len(values))[:, None], 0)
    found: FloatArray = np.take_along_axis(values, np.maximum.accumulate(rows, axis=0), axis=0)
    return found


def _series_structure(numbers: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Index of the series, row at which it starts, and place in it, of every row (rows in order of time)."""
    _, start, index = np.unique(numbers, return_index=True, return_inverse=True)
    position = np.empty(len(numbers), dtype=np.int64)
    order = np.argsort(index, kind="stable")
    sizes = np.bincount(index)
    position[order] = np.arange(len(numbers)) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    return index, start[index], position

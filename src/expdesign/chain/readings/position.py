"""The reading of an instrument that measures where markers are: a laser tracker, a total station, motion capture.

The chain ends with the position of a marker in the instrument's axes,

    y = R_Iᵀ·(p(q; geometry) + δp + Rot(δφ)·R(q; geometry)·m − t_I),

p and R being the tip's pose as geometry alone has it, (δp, δφ) its deflection, m the marker's place on the tip and
(t_I, R_I) the instrument's pose in O. Marker and instrument are parameters of every model, the base model included,
unless the robot file gives them. An instrument that is moved has one pose for each station, a marker that is seated
anew one place for each session (`names` are then markers as one station sees them in one session).
Where an instrument reads orientations as well (a camera, a T-Mac), the marker is a
target with a frame R_m on the tip, and the last three components are the rotation vector, in the instrument's axes, of

    R_Iᵀ·Rot(δφ)·R(q; geometry)·R_m·Aᵀ

with the measured orientation A: 0 is what was measured. Distances from fixed points c and readings of gauges along n,

    d = ‖p + R·m − c‖,   g = nᵀ·(p + R·m) − g₀,

follow as two more components; c and the zeros g₀ are estimated.

A tool that keeps one orientation shows only p + R·m − t_I: the marker's place along an axis of the tip that never turns
is confounded with the instrument's. Orientations that vary by less than geometry is uncertain by anyway tell nothing
either, however small the noise; such coordinates are `held` at the tip's origin, and what depends on them is not known.

Where the tip of an arm is: what commands are found with, in the place of an instrument's reading.

The chain ends with the tip's position and the rotation vector of R·Aᵀ, A being the orientation that it shall have
(`Row.aim`), along the axes of O or of the instrument. Unknowns are those of the reading that the model was identified
with, so that its values and covariance serve as they are.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import casadi as ca
import numpy as np

from expdesign.arrays import BoolArray, FloatArray
from expdesign.chain.declaration import Parameter
from expdesign.chain.readings.reading import Reading
from expdesign.chain.recordings.recordings import LoadedPoints, Recordings, Remark
from expdesign.chain.row import Row
from expdesign.coordinates import SPATIAL
from expdesign.errors import InputError
from expdesign.mechanics.robots.orientation import (
    arrays_in_space,
    in_space,
    rotation_matrix,
    rotation_vector,
    rotations_of,
)
from expdesign.mechanics.robots.robot import Robot

SMALLEST_TURN = 0.02
"""rad (RMS); a tip that turns by less, as links may be misaligned, leaves marker and instrument confounded."""
_HELD = 1e-6
"""m; standard deviation of a coordinate that is held."""
MARKER_SPREAD = 1.0
"""m; standard deviation of a marker's place on the tip before anything is measured."""
FIXED_SPREAD = 10.0
"""m; standard deviation of the place of a fixed point, and of the zero of a gauge, before anything is measured."""
_ROUNDING = 1e-9
"""m; keeps the derivative of a distance of 0 finite."""
INSTRUMENT, PLACE, TURN, FIXED = "instrument", "place", "turn", "fixed"
"""Kinds of blocks of unknown parameters."""
LISTED = ("oriented", "sites", "stations", "fixed", "gauges")
"""Attributes that are lists of names in a model file, which leaves empty ones out."""
_AXES = SPATIAL.pose


@dataclass(frozen=True)
class HeldMarker(Remark):
    """A marker whose place is confounded with the instrument's, because the tip keeps one orientation.

    Attributes:
        marker: its name.
        axes: of the tip along which its place is taken to be the tip's origin.
    """

    marker: str
    axes: tuple[str, ...]


@dataclass(frozen=True)
class MarkerPosition(Reading):
    """The position of a marker in the instrument's axes, and what of markers and instrument is unknown.

    Attributes:
        names: the markers, in the order of `Row.marker`.
        places: known places on the tip (m), shape (3,) each, by site.
        instrument: the instrument's known pose in O (m, rad), shape (6,), or None.
        start: of the unknown parameters, in the order of `parameters`.
        held: coordinates of markers that are held at the tip's origin, e.g. `("prism", "x")`.
        oriented: sites of targets with a frame, whose orientation on the tip is estimated.
        fixed: fixed points and gauges, in the order of `Row.point`.
        gauges: which of these are gauges.
        unplaced: whether no position was read, so that positions are those in O.
        sites: of `names`, in their order; empty where every marker has its own.
        stations: of `names`; empty where the instrument stood still.
    """

    names: tuple[str, ...]
    places: dict[str, FloatArray]
    instrument: FloatArray | None
    start: FloatArray
    held: tuple[tuple[str, str], ...] = ()
    oriented: tuple[str, ...] = ()
    fixed: tuple[str, ...] = ()
    gauges: tuple[str, ...] = ()
    unplaced: bool = False
    sites: tuple[str, ...] = ()
    stations: tuple[str, ...] = ()
    absolute = True
    linear = False
    compliance_spread = 3.0

    @property
    def sited(self) -> tuple[str, ...]:
        """Site of every marker."""
        return self.sites or self.names

    @property
    def unknown(self) -> tuple[str, ...]:
        """Sites whose places are estimated."""
        return tuple(site for site in dict.fromkeys(self.sited) if site not in self.places)

    @property
    def standing(self) -> tuple[str, ...]:
        """Names of the stations, one of which is empty where the instrument stood still."""
        return tuple(dict.fromkeys(self.stations)) or ("",)

    @cached_property
    def blocks(self) -> dict[tuple[str, str], tuple[Parameter, ...]]:
        """Unknown parameters in their order: the instrument by station, places and orientations of markers by site,
        fixed points and gauges.
        """
        stations = self.standing if self.instrument is None else ()
        blocks = {
            (INSTRUMENT, station): tuple(Parameter(" ".join((INSTRUMENT, *station.split(), a)), 1e-2) for a in _AXES)
            for station in stations
        }
        for name in self.unknown:
            spreads = [_HELD if (name, axis) in self.held else MARKER_SPREAD for axis in "xyz"]
            blocks[PLACE, name] = tuple(
                Parameter(f"marker {name} {axis}", 1e-2, spread=spread)
                for axis, spread in zip(_AXES[:3], spreads, strict=True)
            )
        for name in self.oriented:
            blocks[TURN, name] = tuple(Parameter(f"marker {name} {axis}", 1e-2) for axis in _AXES[3:])
        for name in self.fixed:
            columns = [f"gauge {name} zero_m"] if name in self.gauges else [f"point {name} {a}" for a in _AXES[:3]]
            blocks[FIXED, name] = tuple(Parameter(column, 1e-2, spread=FIXED_SPREAD) for column in columns)
        return blocks

    @cached_property
    def parts(self) -> dict[tuple[str, str], slice]:
        """Where the parameters of every block are."""
        ends = np.cumsum([len(block) for block in self.blocks.values()]).tolist()
        return {key: slice(end - len(block), end) for (key, block), end in zip(self.blocks.items(), ends, strict=True)}

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return tuple(parameter for block in self.blocks.values() for parameter in block)

    @property
    def seen_from(self) -> tuple[str, ...]:
        """Station of every marker."""
        return self.stations or ("",) * len(self.names)

    def frames(self, theta: FloatArray) -> FloatArray:
        """The instrument's pose in O for every marker, from values of `parameters`, shape (number of markers, 6)."""
        if self.instrument is not None:
            return np.tile(self.instrument, (len(self.names), 1))
        return np.array([theta[self.parts[INSTRUMENT, station]] for station in self.seen_from])

    def marked(self, theta: FloatArray) -> FloatArray:
        """Place of every marker on the tip (m), from values of `parameters`, shape (number of markers, 3)."""
        known = self.places
        return np.array([known[site] if site in known else theta[self.parts[PLACE, site]] for site in self.sited])

    @property
    def degeneracies(self) -> list[Remark]:
        held = {name: tuple(axis for marker, axis in self.held if marker == name) for name in self.unknown}
        return [HeldMarker(name, axes) for name, axes in held.items() if axes]

    @property
    def record(self) -> dict[str, object]:
        record: dict[str, object] = {"markers": list(self.names), "held": [list(pair) for pair in self.held]}
        always = {"fixed", "gauges"} if self.fixed else set()
        record |= {name: list(getattr(self, name)) for name in LISTED if getattr(self, name) or name in always}
        return record | ({"unplaced": self.unplaced} if self.fixed else {})

    def width(self, robot: Robot) -> int:
        return 8 if self.fixed else 6 if self.oriented else 3

    def released(self, spreads: FloatArray) -> FloatArray:
        return np.where(np.isfinite(spreads), MARKER_SPREAD, spreads)

    def at_points(self, points: LoadedPoints) -> LoadedPoints | None:
        if points.marker is None:
            return None
        for name in points.markers:
            if name not in self.names:
                row = int(np.flatnonzero(points.marker == points.markers.index(name))[0])
                what = f"the model knows no marker `{name}`"
                raise InputError(what, where=points.where(row, "marker"), remedy=f"It knows {', '.join(self.names)}.")
        numbers = np.array([self.names.index(name) for name in points.markers])
        seen = replace(
            points, marker=numbers[points.marker], markers=self.names, sites=self.sites, stations=self.stations
        )
        if not self.fixed:
            return replace(seen, point=None, fixed=(), along=None)
        if points.point is None or not set(points.fixed) <= set(self.fixed):
            where = points.where(0, "point")
            known = f"It knows {', '.join(self.fixed)}; positions need no point."
            if points.point is not None and np.any(points.along):
                raise InputError("the model does not know this point or gauge", where=where, remedy=known)
            return replace(
                seen, point=np.zeros(len(points), dtype=np.int64), fixed=self.fixed, along=np.zeros((len(points), 3))
            )
        places = np.array([self.fixed.index(name) for name in points.fixed])
        return replace(seen, point=places[points.point], fixed=self.fixed)

    def orientations(self, robot: Robot, points: LoadedPoints, theta: FloatArray) -> FloatArray:
        """Orientations of the targets in the instrument's axes with the nominal robot and values of `parameters`.

        Shape (N, 3, 3); that of the tip for markers without orientation.
        """
        targets = np.array(
            [rotations_of(theta[self.parts[TURN, s]]) if s in self.oriented else np.eye(3) for s in self.sited]
        )
        frames = rotations_of(self.frames(theta)[:, 3:]).swapaxes(-1, -2)
        turned: FloatArray = frames[points.marker] @ robot.jacobians(points.configurations).rotation
        return turned @ targets[points.marker]

    def predictable(self, robot: Robot, recordings: Recordings) -> BoolArray:
        """Rows in which nothing that is held shows: the tip is turned as in the fitted rows, shape (N,)."""
        if not self.held:
            return np.ones(len(recordings), dtype=bool)
        within = np.zeros(len(recordings), dtype=bool)
        for rows in self.by_station(recordings):
            turned, _ = turns(robot, recordings.rows(rows))
            fitted = turned[~recordings.test[rows]]
            within[rows] = turned <= max(2.0 * float(fitted.max(initial=0.0)), 1e-9)
        return within

    def by_station(self, recordings: Recordings) -> list[BoolArray]:
        """Rows (N,) that each station sees, of those that see any."""
        stations = np.array(self.seen_from)[recordings.marker]
        return [stations == station for station in self.standing if np.any(stations == station)]

    def expression(self, robot: Robot, deflection: ca.SX, row: Row, theta: ca.SX, geometry: ca.SX | None) -> ca.SX:
        """Position of the row's marker in the instrument's axes, and its turn from `row.aim` where orientations are
        read; `geometry` holds a serial robot's errors.
        """
        frame = self._frame(row, theta)
        known = self.places
        places = (ca.SX(known[site]) if site in known else theta[self.parts[PLACE, site]] for site in self.sited)
        place = ca.horzcat(*places) @ row.marker
        position, rotation = in_space(*robot.frame(row.pose, deflection, geometry))
        instrument = rotation_matrix(frame[3:6], "fixed-xyz")
        seen = instrument.T @ (position + rotation @ place - frame[:3])
        spans = self._spans(row, position + rotation @ place, theta) if self.fixed else ca.SX(0, 1)
        if not self.oriented:
            return ca.vertcat(seen, ca.SX.zeros(3 * bool(self.fixed)), spans)
        target = ca.SX.eye(3)
        for name in self.oriented:
            own = rotation_matrix(theta[self.parts[TURN, name]], "fixed-xyz")
            shown = sum((row.marker[i] for i, site in enumerate(self.sited) if site == name), ca.SX(0.0))
            target += shown * (own - ca.SX.eye(3))
        turn = rotation_vector(instrument.T @ rotation @ target @ ca.reshape(row.aim, 3, 3).T)
        return ca.vertcat(seen, turn, spans)

    def _frame(self, row: Row, theta: ca.SX) -> ca.SX:
        """The instrument's pose (6,) in the row."""
        if self.instrument is not None:
            return ca.SX(self.instrument)
        if not self.stations:
            return theta[:6]
        return ca.horzcat(*(theta[self.parts[INSTRUMENT, station]] for station in self.stations)) @ row.marker

    def _spans(self, row: Row, marker: ca.SX, theta: ca.SX) -> ca.SX:
        """Distance of a marker in O from the row's fixed point, and along the row's gauge from its zero (2,)."""
        centre, zero = ca.SX.zeros(3), ca.SX(0.0)
        for index, name in enumerate(self.fixed):
            own = row.point[index] * theta[self.parts[FIXED, name]]
            if name in self.gauges:
                zero += own
            else:
                centre += own
        return ca.vertcat(ca.sqrt(ca.sumsqr(marker - centre) + _ROUNDING**2), ca.dot(row.along, marker) - zero)


def turns(robot: Robot, recordings: Recordings) -> tuple[FloatArray, FloatArray]:
    """By how much every row turns what the fitted rows do not turn (N,), and which axes of the tip these leave fixed.

    The second is a projector (3, 3) onto directions of the first row's tip that are turned by less than
    `SMALLEST_TURN`. Of several tips all have to leave a direction of the base fixed, since any other shows where the
    instrument is.
    """
    _, rotations = arrays_in_space(
        robot.position(recordings.configurations), robot.jacobians(recordings.configurations).rotation
    )
    kept, tips = ~recordings.test, robot.tip_numbers(recordings.configurations)
    means = np.empty_like(rotations)
    for tip in np.unique(tips):
        mine = tips == tip
        means[mine] = rotations[mine & kept].mean(axis=0) if (mine & kept).any() else rotations[mine].mean(axis=0)
    differences = rotations - means
    scaled = differences[kept].swapaxes(1, 2).reshape(-1, 3) / np.sqrt(int(kept.sum()))
    _, sizes, axes = np.linalg.svd(scaled, full_matrices=False)
    directions = axes[sizes < SMALLEST_TURN] @ means
    fixed = directions.swapaxes(1, 2) @ directions
    return np.linalg.norm(differences @ fixed, axis=(1, 2)), fixed[0]


Frame = Literal["base", "instrument"]


@dataclass(eq=False)
class TipPose(Reading):
    """The tip's pose.

    Attributes:
        identified: the reading of the model.
        frame: along whose axes.
    """

    identified: Reading
    frame: Frame = "base"
    oriented = ("tip",)
    by_instrument = False
    linear = False

    def __post_init__(self) -> None:
        known = self.identified
        self.names, self.start = known.names, known.start
        self.absolute, self.compliance_spread = known.absolute, known.compliance_spread

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return self.identified.parameters

    def width(self, robot: Robot) -> int:
        return 6

    def with_own_weight(self, row: Row, change: ca.SX) -> Row:
        return self.identified.with_own_weight(row, change)

    def at_points(self, points: LoadedPoints) -> LoadedPoints | None:
        return points

    def expression(self, robot: Robot, deflection: ca.SX, row: Row, theta: ca.SX, geometry: ca.SX | None) -> ca.SX:
        position, rotation = in_space(*robot.frame(row.pose, deflection, geometry))
        if self.frame == "instrument":
            assert isinstance(self.identified, MarkerPosition)
            known = self.identified.instrument
            frame = theta[:6] if known is None else ca.SX(known)
            instrument = rotation_matrix(frame[3:6], "fixed-xyz")
            position, rotation = instrument.T @ (position - frame[:3]), instrument.T @ rotation
        return ca.vertcat(position, rotation_vector(rotation @ ca.reshape(row.aim, 3, 3).T))

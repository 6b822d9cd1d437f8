"""Recordings and points as arrays (file-formats.md, Recordings).

What a file of recordings measured, by its columns: deflections of the platform, its poses, or markers on it.

What a computation has to say of recordings, as data; `report/remark_texts.py` puts it into words.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np
import pandas as pd

from expdesign.arrays import BoolArray, FloatArray, IntArray, TextArray
from expdesign.coordinates import Coordinates
from expdesign.errors import InputError
from expdesign.io.table import Table

POSITION = ("px_m", "py_m", "pz_m")
POSITION_DEVIATION = ("spx_m", "spy_m", "spz_m")
SPANS = ("distance_m", "gauge_m")
SPAN_DEVIATIONS = ("sdistance_m", "sgauge_m")
ALONG = ("along_x", "along_y", "along_z")
POINT = "point"
STATION, SESSION = "station", "session"
"""Columns of groups of rows with one place of the instrument, and with one place of every marker."""


@dataclass(frozen=True)
class Measurand:
    """One kind of measured quantity.

    Attributes:
        name: in words.
        absolute: whether it says where something is, so that geometry, own weight and the instrument's place show, or
            by how much a load moved it, in which they cancel.
    """

    name: str
    absolute: bool

    def columns(self, coordinates: Coordinates) -> tuple[str, ...]:
        """Columns of what the instrument reads."""
        if self.name == "poses":
            return measured_names(coordinates)
        return POSITION if self.absolute else coordinates.deflection

    def deviation_columns(self, coordinates: Coordinates) -> tuple[str, ...]:
        """Columns of their standard deviations."""
        return POSITION_DEVIATION if self.columns(coordinates) == POSITION else coordinates.deviation

    def reference(self, weight: FloatArray) -> FloatArray:
        """What own weight does in the reference state: that of a position is the weightless robot."""
        return np.zeros_like(weight) if self.absolute else weight

    def shown(self, weight: FloatArray) -> FloatArray:
        """What own weight adds to what is read."""
        return weight if self.absolute else np.zeros_like(weight)


DEFLECTIONS = Measurand("deflections", absolute=False)
POSITIONS = Measurand("positions of markers", absolute=True)
POSES = Measurand("poses", absolute=True)


def measured_names(coordinates: Coordinates) -> tuple[str, ...]:
    """Columns of a pose as it was measured, in the coordinates of the commanded one."""
    return tuple(f"measured_{name}" for name in coordinates.pose)


def reading_names(coordinates: Coordinates) -> tuple[str, ...]:
    """Columns of what an instrument shows of the platform's pose, from any zero."""
    return tuple(f"reading_{name}" for name in coordinates.pose)


@dataclass(frozen=True, repr=False)
class LoadedPoints:
    """Rows of commands and loads in the order of their sequence; what `predict` and `compensate` need.

    Attributes:
        source: name of the file, for messages.
        lines: line of the file on which each row stands, shape (N,).
        sequence: order in time, shape (N,).
        series: number of the series of each row, shape (N,).
        time: s since the first row, shape (N,), or None.
        configurations: commanded poses or joint coordinates, shape (N, n_q).
        wrenches: assumed change of the load, at the origin of P along the axes of O (N, N·m), shape (N, n).
        absolute: assumed whole load, shape (N, n); differs where the reference state was loaded itself.
        payload: mass (kg) and centre of mass (m, platform frame), shape (N, 1 or 4), or None where only wrenches are
            known.
        gravity: in O (m/s²), shape (N, d).
        temperature: °C, shape (N,), or None.
        leg_temperature: °C, shape (N, n_p), or None.
        extra: columns that have no meaning here; a diagnosis compares residuals with those of numbers (`further`).
        marker: index in `markers` of every row, shape (N,), where positions of markers are measured; else None.
        markers: names of the markers; with sessions and stations each marker is one in each of them.
        sites: place on a tip that each of `markers` has (one for a marker in each session); empty for `markers`.
        stations: from where each of `markers` is seen: one pose of the instrument each; empty where it stood still.
        aim: orientation of the target of each row in the instrument's axes, from which rotations are counted, shape
            (N, 3, 3): the measured one. None where no orientations of targets are measured.
        angles: the three numbers from which `aim` was made as Rz·Ry·Rx (rad), shape (N, 3), as they were written.
        point: index in `fixed` of every row, shape (N,), where distances or gauges are read; else None.
        fixed: names of fixed points and gauges.
        along: unit vectors along gauges in O, shape (N, 3), 0 for rows without; None as `point`.
        poses: whether poses of the platform are measured.
        files: name of the file of every row, shape (N,), where they come from several; else None.
        references: name of the unloaded reading from which a row is counted, shape (N,): rows of one name share its
            noise, half of each row's variance. Empty for one of the row's own; None where every row has one.
        errors: declared standard deviations of errors of the load, in the order of `load_errors.error_columns`, NaN in
            columns that are not declared and 0 in rows without load, shape (N, q); None where none is declared.
        weight: name of the weights of every row, which share one error, shape (N,); None where all rows do.
        written: names in the file of columns that were converted to SI, by their SI names.
    """

    source: str
    lines: IntArray
    sequence: IntArray
    series: IntArray
    time: FloatArray | None
    configurations: FloatArray
    wrenches: FloatArray
    absolute: FloatArray
    payload: FloatArray | None
    gravity: FloatArray
    temperature: FloatArray | None
    leg_temperature: FloatArray | None
    extra: pd.DataFrame
    marker: IntArray | None = field(default=None, kw_only=True)
    markers: tuple[str, ...] = field(default=(), kw_only=True)
    sites: tuple[str, ...] = field(default=(), kw_only=True)
    stations: tuple[str, ...] = field(default=(), kw_only=True)
    aim: FloatArray | None = field(default=None, kw_only=True)
    angles: FloatArray | None = field(default=None, kw_only=True)
    point: IntArray | None = field(default=None, kw_only=True)
    fixed: tuple[str, ...] = field(default=(), kw_only=True)
    along: FloatArray | None = field(default=None, kw_only=True)
    poses: bool = field(default=False, kw_only=True)
    files: TextArray | None = field(default=None, kw_only=True)
    references: TextArray | None = field(default=None, kw_only=True)
    errors: FloatArray | None = field(default=None, kw_only=True)
    weight: TextArray | None = field(default=None, kw_only=True)
    written: Mapping[str, str] = field(default_factory=dict, kw_only=True)

    def components(self, coordinates: Coordinates) -> tuple[str, ...]:
        """Columns of what an instrument reads; rotations of targets are named as those of deflections."""
        return self._with_turns(
            self.measurand.columns(coordinates), coordinates.deflection[coordinates.translations :], SPANS
        )

    def _with_turns(self, own: tuple[str, ...], turns: tuple[str, ...], spans: tuple[str, ...]) -> tuple[str, ...]:
        turned = self.aim is not None or self.point is not None
        return (*own, *(turns if turned else ()), *(spans if self.point is not None else ()))

    @property
    def measurand(self) -> Measurand:
        """What is read at these points."""
        if self.poses:
            return POSES
        return DEFLECTIONS if self.marker is None else POSITIONS

    @property
    def seen(self) -> list[tuple[str, str, str]]:
        """Every marker with its site and its station, which is empty where the instrument stood still."""
        stations = self.stations or ("",) * len(self.markers)
        return list(zip(self.markers, self.sites or self.markers, stations, strict=True))

    @property
    def timed(self) -> bool:
        """Whether time was recorded and passes."""
        return self.time is not None and bool(np.any(np.diff(self.time) > 0.0))

    @property
    def further(self) -> dict[str, FloatArray]:
        """Columns without a meaning that hold a number in every row and vary, shape (N,) each, by name."""
        numbers = self.extra.apply(pd.to_numeric, errors="coerce")
        values = {str(name): numbers[name].to_numpy(dtype=float) for name in numbers.columns}
        return {name: each for name, each in values.items() if np.isfinite(each).all() and np.ptp(each) > 0.0}

    @property
    def marker_indicators(self) -> FloatArray:
        """1 for the marker of each row, 0 for the others, shape (N, number of markers); no columns for deflections."""
        return indicators(self.marker, len(self.markers), len(self))

    def where(self, row: int, column: str = "") -> str:
        """File, line and column of a row, as a person would look them up."""
        source = self.source if self.files is None else self.files[row]
        return f"{source}, row {self.lines[row]}" + (f", column {column}" if column else "")

    def __len__(self) -> int:
        return len(self.sequence)

    def __repr__(self) -> str:
        series = len(np.unique(self.series))
        return f"<{type(self).__name__}: {len(self)} rows in {series} series ({self.source})>"


def indicators(index: IntArray | None, count: int, rows: int) -> FloatArray:
    """1 where a row (of N) has an index, 0 elsewhere, shape (N, count)."""
    return np.zeros((rows, count)) if index is None else np.eye(count)[index]


def order_in_time(table: Table) -> IntArray:
    """Rows in the order of their sequence numbers, or of the file where there are none, shape (N,)."""
    if not table.has("sequence"):
        return np.arange(len(table))
    order: IntArray = np.argsort(table.integers("sequence"), kind="stable")
    return order


def in_order(table: Table) -> Table:
    """The table with its rows in the order of their sequence."""
    return table.rows(order_in_time(table))


def markers_in(
    names: TextArray, sessions: TextArray, stations: TextArray
) -> tuple[IntArray, tuple[str, ...], tuple[str, ...], tuple[str, ...]]:
    """Index of every row's marker (N,), the markers' names, their sites and their stations, from texts of rows (N,).

    A marker is one in every session and from every station; where there are none, sites and stations are empty.
    """

    def within(of: TextArray, groups: TextArray, word: str) -> TextArray:
        return np.array([f"{n} {word} {g}" if g else n for n, g in zip(of, groups, strict=True)], dtype=object)

    sites = within(names, sessions, "in session")
    seen = within(sites, stations, "from station").astype(str)
    markers, first, index = np.unique(seen, return_index=True, return_inverse=True)
    moved = bool(np.any(stations != ""))
    return (
        index.astype(np.int64),
        tuple(str(name) for name in markers),
        tuple(str(name) for name in sites[first]) if moved or np.any(sessions != "") else (),
        tuple(str(name) for name in stations[first]) if moved else (),
    )


def regrouped(recordings: "Recordings", column: str, groups: TextArray) -> "Recordings":
    """The recordings as if a `column` (`station` or `session`) had said these groups of rows (N,)."""
    sites, stations = (np.array([each[i] for each in recordings.seen], dtype=object) for i in (1, 2))
    none = np.full(len(recordings), "")
    own = (none, groups) if column == STATION else (groups, stations[recordings.marker])
    marker, markers, site, station = markers_in(sites[recordings.marker], *own)
    return replace(recordings, marker=marker, markers=markers, sites=site, stations=station)


def complete_positions(recordings: "Recordings") -> "Recordings":
    """Rows of which all coordinates of a position were read, without orientations; other recordings as they are."""
    if recordings.marker is None:
        return recordings
    if 0 not in recordings.axes:
        what = "there are distances or gauges, and no positions"
        raise InputError(what, where=recordings.source, remedy="`expdesign identify` fits them; add positions.")
    deviations = None if recordings.deviations is None else recordings.deviations[:, :3]
    places = replace(
        recordings,
        aim=None,
        angles=None,
        point=None,
        fixed=(),
        along=None,
        axes=recordings.axes[:3],
        deflections=recordings.deflections[:, :3],
        deviations=deviations,
    )
    return places.rows(np.flatnonzero(np.isfinite(places.deflections).all(axis=1)))


@dataclass(frozen=True, repr=False)
class Recordings(LoadedPoints):
    """Loaded points with measured deflections.

    Attributes:
        axes: indices of the measured components, shape (k,).
        deflections: the readings: deflections or poses (m, rad), or positions of markers (m), shape (N, k). Positions
            have NaN where nothing was read, and with `aim` rotation vectors from it (rad), which are 0.
        deviations: their standard deviations, shape (N, k), or None where they are not known.
        test: rows that must not be fitted, shape (N,).
        within: inverse root of the correlation matrix of the readings of every row, symmetric, shape (N, k, k); None
            where these are independent of each other.
    """

    axes: IntArray
    deflections: FloatArray
    deviations: FloatArray | None
    test: BoolArray = field(default_factory=lambda: np.zeros(0, dtype=bool))
    within: FloatArray | None = None

    def deviation_columns(self, coordinates: Coordinates) -> tuple[str, ...]:
        """Columns of the standard deviations of the measured components, in the order of `axes`."""
        own = self.measurand.deviation_columns(coordinates)
        names = self._with_turns(own, coordinates.deviation[coordinates.translations :], SPAN_DEVIATIONS)
        return tuple(names[axis] for axis in self.axes)

    def rows(self, chosen: BoolArray | IntArray) -> "Recordings":
        """The recordings of some rows; effects with memory need whole series."""
        per_row: dict[str, Any] = {
            item.name: value[chosen]
            for item in fields(self)
            if isinstance(value := getattr(self, item.name), np.ndarray) and item.name != "axes"
        }
        return replace(self, **per_row, extra=self.extra.iloc[np.arange(len(self))[chosen]])


def measured_axes(points: LoadedPoints) -> set[int]:
    """Indices of the pose coordinates that were measured; all of them for points without readings."""
    return {int(axis) for axis in points.axes} if isinstance(points, Recordings) else set(range(6))


class Remark:
    """One thing that a user must know: a frozen dataclass with the figures that a sentence needs."""

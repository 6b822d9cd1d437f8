"""The columns of recordings, declared once: name with unit, meaning, and what people call them.

`RECORDED` is what readers take as known, `file-formats.md` shows, and messages ask after. A new column is an entry
here, a field of `LoadedPoints` (`recordings.py`) and a line in `points_of` (`points.py`), where it is read and checked;
tables that are filled in list it in `filled_in.py`. A column of numbers that nothing knows needs none of this: a
diagnosis compares it with what is left over as it is.
`io/units.py` has what names without their unit measure, for columns in other units than SI.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

from expdesign.chain.recordings.load_errors import WEIGHT, error_columns
from expdesign.chain.recordings.recordings import POSITION, POSITION_DEVIATION, measured_names, reading_names
from expdesign.coordinates import PLANE, SPATIAL, Coordinates
from expdesign.io.known_columns import KnownColumns
from expdesign.io.table import Table
from expdesign.mechanics.robots.robot import Robot

REFERENCE = "reference"
"""Column that names the unloaded reading of a row; empty where nothing is known of it."""


@dataclass(frozen=True)
class ColumnGroup:
    """Columns that are written down together.

    Attributes:
        shown: their names on the page of file formats, those of a hexapod where they depend on the robot.
        meaning: with what holds where they are left out.
        of: their names for a robot.
        spelt: names, of any robot, that are recognised in other letters, with other marks or without their unit.
        words: what people call them, for the hints of messages (`KnownColumns.words`).
        asked: what is said where the column is missing.
    """

    shown: str
    meaning: str
    of: Callable[[Robot], tuple[str, ...]]
    spelt: tuple[str, ...] = ()
    words: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    asked: str = ""


def _listed(names: tuple[str, ...]) -> str:
    return ", ".join(f"`{name}`" for name in names)


def _named(*names: str) -> Callable[[Robot], tuple[str, ...]]:
    return lambda robot: names


def _of(group: str, meaning: str, words: Mapping[str, tuple[str, ...]] | None = None) -> ColumnGroup:
    """A group of the robot's coordinates."""
    names = getattr(SPATIAL, group)
    return ColumnGroup(_listed(names), meaning, lambda robot: getattr(robot.coordinates, group), names, words or {})


def whole_load(coordinates: Coordinates) -> tuple[str, ...]:
    """Columns of the whole load, where the reference state was loaded itself."""
    return tuple(f"abs_{name}" for name in coordinates.wrench)


def leg_temperatures(robot: Robot) -> tuple[str, ...]:
    """Columns of sensors in the legs or joints."""
    return tuple(f"leg{i + 1}_degC" for i in range(len(robot.stiffness)))


def _along(names: tuple[str, ...], *words: str) -> dict[str, tuple[str, ...]]:
    """Words of three components, in which `{}` is the axis."""
    return {name: tuple(word.format(axis) for word in words) for name, axis in zip(names, "xyz", strict=True)}


def _one(name: str, meaning: str, *words: str, asked: str = "") -> ColumnGroup:
    """A column that every robot has."""
    return ColumnGroup(f"`{name}`", meaning, _named(name), (name,), {name: words}, asked)


RECORDED = (
    _one(
        "sequence",
        "whole number, unique: the order in time",
        *("seq", "seqno", "no", "nr", "nummer", "number", "row", "zeile", "messung", "measurement", "reihenfolge"),
        *("folge", "index", "lfdnr"),
        asked="whole numbers, the order in which the rows were recorded",
    ),
    _one(
        "series",
        "whole number; rows of one series have one command, and deflections from the unloaded state at its start",
        *("serie", "ser", "gruppe", "group", "posenr", "messreihe", "reihe", "pose"),
        asked="a whole number for each series, which rows share between which nothing was set anew",
    ),
    _one(
        "time_s",
        "time since the first row of the recordings, also in points; optional, required for creep and drift with time",
        *("zeit", "t", "times", "zeits"),
    ),
    ColumnGroup(
        _listed(SPATIAL.pose),
        "commanded pose; `x_m`, `y_m` of a bipod; `q1_rad` or `q1_m`, … of an arm (or a joint by name, `elbow_rad`), "
        "and `NAME_rad` or `NAME_m` of its `branch_joints`",
        lambda robot: robot.configuration,
        SPATIAL.pose,
        {"rx_rad": ("roll",), "ry_rad": ("pitch",), "rz_rad": ("yaw",)},
    ),
    ColumnGroup("`tip`", "name of the row's tip, where an arm has several", _named()),
    ColumnGroup(
        "`NAME_mass_kg`, `NAME_com_x_m`, `NAME_com_y_m`, `NAME_com_z_m`",
        "payloads of an arm's `payload_links`, in their frames",
        _named(),
    ),
    _of(
        "wrench",
        "assumed wrench; or a payload",
        _along(SPATIAL.wrench[:3], "force{}", "kraft{}") | _along(SPATIAL.wrench[3:], "moment{}", "torque{}", "t{}"),
    ),
    ColumnGroup(
        _listed(("mass_kg", *SPATIAL.centre_of_mass)),
        "assumed payload in P; or a wrench",
        lambda robot: ("mass_kg", *robot.coordinates.centre_of_mass),
        ("mass_kg", *SPATIAL.centre_of_mass),
        {"mass_kg": ("masse", "gewicht", "weight", "payload", "load", "last", "nutzlast", "massekg", "m")}
        | _along(SPATIAL.centre_of_mass, "cog{}", "sp{}", "schwerpunkt{}", "c{}", "com{}m"),
    ),
    _of(
        "deflection",
        "measured deflection; at least one component",
        _along(SPATIAL.deflection[:3], "delta{}", "deflection{}", "verschiebung{}", "u{}")
        | _along(SPATIAL.deflection[3:], "deltar{}", "rotation{}", "verdrehung{}"),
    ),
    _of(
        "deviation", "standard deviation of each measured component; optional: else it is estimated, and χ² is no test"
    ),
    ColumnGroup(
        "`abs_fx_N`, …, `abs_mz_Nm`",
        "whole load, where the reference state was loaded and the wrench is a change; optional, default 0",
        lambda robot: whole_load(robot.coordinates),
    ),
    _of("gravity", "gravity of this row in O, where the base turns; optional"),
    replace(_of("tilt", "tilt, in place of gravity; optional"), spelt=(*SPATIAL.tilt, *PLANE.tilt)),
    ColumnGroup(
        "`temperature_degC`; `leg1_degC`, …",
        "temperature, or that of each leg; optional",
        lambda robot: ("temperature_degC", *leg_temperatures(robot)),
        ("temperature_degC",),
        {"temperature_degC": ("temperatur", "temp", "tempc", "temperaturc")},
    ),
    _one(
        REFERENCE,
        "name of the unloaded reading; rows of one name share its noise, half of each row's variance; optional",
    ),
    ColumnGroup(
        "`error_mass_kg`, `error_com_x_m`, …, `error_fx_N`, …, `error_mz_Nm`",
        "standard deviations of the errors of the load, which `identify` weighs; rows of one `weight` share them; "
        "optional: else as the configuration of the targets says",
        lambda robot: error_columns(robot.coordinates),
    ),
    ColumnGroup(
        f"`{WEIGHT}`",
        "name of the weights of the row, which have one error; else all rows carry the same; optional",
        _named(WEIGHT),
    ),
    _one("split", "`train` or `test`; rows marked `test` are never fitted; optional"),
    ColumnGroup(
        "`station`",
        "place of the instrument: positions of each station have a pose of the instrument of their own; `diagnose` "
        "leaves out such groups of rows (at least five; else series, else consecutive rows); optional",
        _named(),
    ),
    ColumnGroup(
        "`session`",
        "rows between which no marker was taken off: every session has places of the markers of its own; optional",
        _named(),
    ),
    _one(
        "marker",
        "name of the marker whose position was measured",
        *("reflector", "reflektor", "smr", "punkt", "point", "target"),
    ),
    ColumnGroup(_listed(POSITION), "its position in the instrument's frame", _named(*POSITION), POSITION),
    ColumnGroup(
        _listed(POSITION_DEVIATION), "standard deviations; optional", _named(*POSITION_DEVIATION), POSITION_DEVIATION
    ),
    ColumnGroup(
        "`measured_x_m` … `measured_rz_rad`",
        "measured pose, in place of deflections, with the same standard deviations",
        lambda robot: measured_names(robot.coordinates),
        measured_names(SPATIAL),
    ),
)
"""Every column; `tip` and what links carry are read with the joints, `station` is kept for a diagnosis."""
_BEFORE = ("kind", "points", "reference_points", *reading_names(SPATIAL))
"""Columns of sheets and lists of points, from which recordings are made."""
_JOINT = re.compile(r"q([1-9]\d*)(?:rad)?|(?:j|joint|axis|achse|gelenk)([1-9]\d*)")
"""Joints as controllers call them, from 1."""
SPELT = tuple(name for group in RECORDED for name in group.spelt)
"""Columns of recordings in space that are recognised in other letters."""
COLUMNS = KnownColumns(
    names=(*SPELT, *_BEFORE),
    words={name: words for group in RECORDED for name, words in group.words.items()},
    numbered={"q{}_rad": _JOINT},
    asked={name: group.asked for group in RECORDED if group.asked for name in group.spelt},
)
"""What a reader of a table is handed, so that it recognises columns of recordings, points and targets."""


def known_columns(robot: Robot) -> set[str]:
    """Columns that mean something in recordings of a robot; others are kept and reported."""
    return {name for columns in RECORDED for name in columns.of(robot)}


def require_mass(table: Table, column: str) -> None:
    """Raise an `InputError` where a column holds a negative mass (kg)."""
    masses = table.numbers((column,))[:, 0]
    table.refuse(masses < 0.0, (column,), "a mass cannot be negative", "Correct it.")

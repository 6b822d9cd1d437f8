"""The columns of recordings, declared once, and how each is read; every fault is named with file, row and column.

`RECORDED` says what every column means, which a reader takes as known and `file-formats.md` shows. What a column must
fulfil stands in the function that reads it.
"""

from collections.abc import Callable
from dataclasses import dataclass

from expdesign.chain.recordings.load_errors import WEIGHT, error_columns
from expdesign.chain.recordings.recordings import POSITION, POSITION_DEVIATION, measured_names
from expdesign.coordinates import SPATIAL, Coordinates
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
    """

    shown: str
    meaning: str
    of: Callable[[Robot], tuple[str, ...]]


def _listed(names: tuple[str, ...]) -> str:
    return ", ".join(f"`{name}`" for name in names)


def _named(*names: str) -> Callable[[Robot], tuple[str, ...]]:
    return lambda robot: names


def _of(group: str) -> Callable[[Robot], tuple[str, ...]]:
    return lambda robot: getattr(robot.coordinates, group)


def whole_load(coordinates: Coordinates) -> tuple[str, ...]:
    """Columns of the whole load, where the reference state was loaded itself."""
    return tuple(f"abs_{name}" for name in coordinates.wrench)


def leg_temperatures(robot: Robot) -> tuple[str, ...]:
    """Columns of sensors in the legs or joints."""
    return tuple(f"leg{i + 1}_degC" for i in range(len(robot.stiffness)))


RECORDED = (
    ColumnGroup("`sequence`", "whole number, unique: the order in time", _named("sequence")),
    ColumnGroup(
        "`series`",
        "whole number; rows of one series have one command, and deflections from the unloaded state at its start",
        _named("series"),
    ),
    ColumnGroup(
        "`time_s`",
        "time since the first row of the recordings, also in points; optional, required for creep and drift with time",
        _named("time_s"),
    ),
    ColumnGroup(
        _listed(SPATIAL.pose),
        "commanded pose; `x_m`, `y_m` of a bipod; `q1_rad` or `q1_m`, … of an arm (or a joint by name, `elbow_rad`), "
        "and `NAME_rad` or `NAME_m` of its `branch_joints`",
        lambda robot: robot.configuration,
    ),
    ColumnGroup("`tip`", "name of the row's tip, where an arm has several", _named()),
    ColumnGroup(
        "`NAME_mass_kg`, `NAME_com_x_m`, `NAME_com_y_m`, `NAME_com_z_m`",
        "payloads of an arm's `payload_links`, in their frames",
        _named(),
    ),
    ColumnGroup(_listed(SPATIAL.wrench), "assumed wrench; or a payload", _of("wrench")),
    ColumnGroup(
        _listed(("mass_kg", *SPATIAL.centre_of_mass)),
        "assumed payload in P; or a wrench",
        lambda robot: ("mass_kg", *robot.coordinates.centre_of_mass),
    ),
    ColumnGroup(
        _listed(SPATIAL.deflection),
        "measured deflection; at least one component",
        _of("deflection"),
    ),
    ColumnGroup(
        _listed(SPATIAL.deviation),
        "standard deviation of each measured component; optional: else it is estimated, and χ² is no test",
        _of("deviation"),
    ),
    ColumnGroup(
        "`abs_fx_N`, …, `abs_mz_Nm`",
        "whole load, where the reference state was loaded and the wrench is a change; optional, default 0",
        lambda robot: whole_load(robot.coordinates),
    ),
    ColumnGroup(_listed(SPATIAL.gravity), "gravity of this row in O, where the base turns; optional", _of("gravity")),
    ColumnGroup(
        "`temperature_degC`; `leg1_degC`, …",
        "temperature, or that of each leg; optional",
        lambda robot: ("temperature_degC", *leg_temperatures(robot)),
    ),
    ColumnGroup(
        "`reference`",
        "name of the unloaded reading; rows of one name share its noise, half of each row's variance; optional",
        _named(REFERENCE),
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
    ColumnGroup("`split`", "`train` or `test`; rows marked `test` are never fitted; optional", _named("split")),
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
    ColumnGroup("`marker`", "name of the marker whose position was measured", _named("marker")),
    ColumnGroup(_listed(POSITION), "its position in the instrument's frame", _named(*POSITION)),
    ColumnGroup(_listed(POSITION_DEVIATION), "standard deviations; optional", _named(*POSITION_DEVIATION)),
    ColumnGroup(
        "`measured_x_m` … `measured_rz_rad`",
        "measured pose, in place of deflections, with the same standard deviations",
        lambda robot: measured_names(robot.coordinates),
    ),
)
"""Every column; `tip` and what links carry are read with the joints, `station` is kept for a diagnosis."""


def known_columns(robot: Robot) -> set[str]:
    """Columns that mean something in recordings of a robot; others are kept and reported."""
    return {name for columns in RECORDED for name in columns.of(robot)}


def require_mass(table: Table, column: str) -> None:
    """Raise an `InputError` where a column holds a negative mass (kg)."""
    masses = table.numbers((column,))[:, 0]
    table.refuse(masses < 0.0, (column,), "a mass cannot be negative", "Correct it.")

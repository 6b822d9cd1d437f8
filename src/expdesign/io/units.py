"""Units of measurement: what a column or a key measures, and how a number in another unit becomes one in SI.

A column's name ends with its unit (`dx_m`, `fx_kN`, `rz_deg`), and what stands before it says what is measured. The
table of units is kept here instead of in a library such as pint: a few dozen linear factors are needed, and reading a
table must neither wait for a library nor guess (`m` is a metre, never a minute; `mN` is a force, `Nm` a moment).

A new unit is an entry of `_SCALED`, a sign that stands for one an entry of `_ALIASES`. Words in headers of trackers'
lists (`inches`) are in `estimation/preparation/point_lists.py`.
"""

import difflib
import math
import re
from dataclasses import dataclass
from decimal import Decimal
from typing import Literal

from expdesign.errors import ArgumentError, InputError
from expdesign.io.nearest import nearest

Dimension = Literal[
    "length", "angle", "force", "moment", "mass", "time", "temperature", "acceleration", "stiffness",
    "torsional stiffness",
]  # fmt: skip

NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
"""A finite number as it stands in a cell."""


@dataclass(frozen=True)
class Unit:
    """SI value = number × factor + offset.

    Attributes:
        name: as it stands at the end of a column's name.
        dimension: what it measures.
        factor: exact where it is a power of ten.
        offset: of temperatures.
    """

    name: str
    dimension: Dimension
    factor: Decimal
    offset: Decimal = Decimal(0)

    def to_si(self, number: str | float) -> float:
        """The SI value of a number, rounded once (`12.3` µm are `1.23e-05` m to the last digit)."""
        return float(_decimal(number) * self.factor + self.offset)

    def from_si(self, number: str | float) -> float:
        """The number in this unit of an SI value."""
        return float((_decimal(number) - self.offset) / self.factor)


def _decimal(number: str | float) -> Decimal:
    return Decimal(number.strip() if isinstance(number, str) else repr(float(number)))


_DEGREE = Decimal(repr(math.pi)) / 180
_SCALED: dict[Dimension, dict[str, str | Decimal]] = {
    "length": {"m": "1", "dm": "1e-1", "cm": "1e-2", "mm": "1e-3", "um": "1e-6", "nm": "1e-9", "in": "0.0254"},
    "angle": {
        "rad": "1", "mrad": "1e-3", "urad": "1e-6", "nrad": "1e-9",
        "deg": _DEGREE, "mdeg": _DEGREE / 1000, "arcmin": _DEGREE / 60, "arcsec": _DEGREE / 3600,
    },
    "force": {"N": "1", "mN": "1e-3", "daN": "1e1", "kN": "1e3", "MN": "1e6"},
    "moment": {"Nm": "1", "Nmm": "1e-3", "mNm": "1e-3", "Ncm": "1e-2", "kNm": "1e3"},
    "mass": {"kg": "1", "g": "1e-3", "mg": "1e-6", "t": "1e3"},
    "time": {"s": "1", "ms": "1e-3", "min": "60", "h": "3600"},
    "temperature": {"degC": "1"},
    "acceleration": {"m_s2": "1", "mm_s2": "1e-3"},
    "stiffness": {"N_m": "1", "N_mm": "1e3", "N_um": "1e6", "kN_mm": "1e6", "kN_m": "1e3", "MN_m": "1e6"},
    "torsional stiffness": {"Nm_rad": "1", "kNm_rad": "1e3", "Nm_mrad": "1e3", "Nm_deg": 1 / _DEGREE},
}  # fmt: skip

UNITS: dict[str, Unit] = {
    name: Unit(name, dimension, Decimal(factor)) for dimension, row in _SCALED.items() for name, factor in row.items()
}
UNITS["K"] = Unit("K", "temperature", Decimal(1), Decimal("-273.15"))
UNITS["degF"] = Unit("degF", "temperature", Decimal(5) / 9, Decimal(-160) / 9)

SI: dict[Dimension, str] = {dimension: next(iter(row)) for dimension, row in _SCALED.items()}
"""The unit in which each quantity is computed."""

_ALIASES = {"µ": "u", "μ": "u", "°C": "degC", "°F": "degF", "°": "deg", "m/s²": "m_s2", "m/s^2": "m_s2", "m/s2": "m_s2"}

_BEFORE = r"(?:measured_|target_|corrected_|controller_|reading_|correction_|U_)?"
_PATTERNS: tuple[tuple[str, tuple[Dimension, ...]], ...] = (
    (_BEFORE + "[xyz]|[ds][xyz]|s?p[xyz]|com_[xyz]", ("length",)),
    (_BEFORE + "r[xyz]|[ds]r[xyz]|tilt(_[xy])?", ("angle",)),
    ("(abs_)?f[xyz]", ("force",)),
    ("(abs_)?m[xyz]", ("moment",)),
    ("g[xyz]", ("acceleration",)),
    ("mass", ("mass",)),
    ("time", ("time",)),
    ("temperature", ("temperature",)),
    (r"leg\d+", ("length", "temperature")),
    (r"(target_|correction_)?q\d+", ("angle", "length")),
    ("correction", ("length", "angle")),
)
_MEASURED = tuple((re.compile(pattern), dimensions) for pattern, dimensions in _PATTERNS)


def unit_of(text: str) -> Unit | None:
    """The unit that a text names (`mm`, `µm`, `N·m`, `N/um`), or None."""
    name = text.strip()
    for written, known in _ALIASES.items():
        name = name.replace(written, known)
    for mark in ("·", "*", " "):
        name = name.replace(mark, "")
    return UNITS.get(name.replace("/", "_"))


@dataclass(frozen=True)
class MeasuredColumn:
    """What a column's name says: `base` (`dx`) and its unit."""

    base: str
    unit: Unit

    @property
    def si_name(self) -> str:
        """The same column in SI."""
        return f"{self.base}_{SI[self.unit.dimension]}"

    @property
    def is_si(self) -> bool:
        """Whether the column is in SI already."""
        return self.unit.name == SI[self.unit.dimension]


QUANTITY = re.compile(rf"(?!{NUMBER.pattern}$)({NUMBER.pattern})\s*([^\d\s.,:;+\-][^\d,:;]*\d?)")
"""A number with its unit, such as `0.5 mm`."""


def quantity(text: str, where: str = "") -> tuple[float, Unit]:
    """A text of number and unit as the number in SI and its unit.

    Raises:
        InputError: it is none, or the unit is unknown.
    """
    if NUMBER.fullmatch(text.strip()):
        value = float(text)
        remedy = (
            f"Write e.g. `{value * 1e6:g} um`, if metres are meant." if abs(value) < 1e-3 else "Write e.g. `15 um`."
        )
        raise InputError(f"`{text.strip()}` has no unit", where=where, remedy=remedy)
    found = QUANTITY.fullmatch(text.strip())
    if found is None:
        what = f"`{text.strip()}` is not a number with its unit"
        raise InputError(what, where=where, remedy="Write e.g. `0.5 mm`.")
    unit = unit_of(found.group(2))
    if unit is None:
        what = f"unknown unit `{found.group(2).strip()}`"
        near = difflib.get_close_matches(found.group(2).strip(), UNITS, n=1, cutoff=0.5)
        remedy = f"Did you mean `{near[0]}`?" if near else "Known are e.g. mm, um, rad, mrad, deg, N, Nm, kg and s."
        raise InputError(what, where=where, remedy=remedy)
    return unit.to_si(found.group(1)), unit


_FORMS = (
    re.compile(r"(?P<base>\w[\w ]*?)[\s_]*[\[(]\s*(?P<unit>[^\[\]()]+?)\s*[\])]"),
    re.compile(r"(?P<base>\w+)\s+(?P<unit>\S+)"),
    re.compile(r"(?P<base>\w+?)_(?P<unit>[^_\s]+(?:_s2)?)"),
)


def measured_column(name: str, where: str = "") -> MeasuredColumn | None:
    """Quantity and unit of a column (`dx_mm`, `DX [mm]`, `dz mm`), or None where its name does not say both.

    Raises:
        InputError: the unit is that of another quantity (`dx_mrad`), or may be one of two (`MN` in capitals).
    """
    for form in _FORMS:
        found = form.fullmatch(name.strip())
        if found is None:
            continue
        written = re.sub(r"\s+", "_", found["base"].strip())
        base = written if quantities(written) else written.lower()
        dimensions, unit = quantities(base), unit_of(found["unit"])
        capitals = name.isupper() and found["unit"].isalpha()  # `MN` may then be mN
        if dimensions and (unit is None or unit.dimension not in dimensions or capitals):
            text = found["unit"].replace(" ", "")
            units = [one for one in UNITS.values() if one.name.lower() == text.lower() and one.dimension in dimensions]
            if len(units) > 1:
                what = f"the unit {found['unit']} may be {' or '.join(one.name for one in units)}"
                raise InputError(what, where=where, remedy="Write it in its own letters.")
            unit = units[0] if units else unit
        if dimensions and unit is not None:
            require_dimension(unit, dimensions, base, where)
            return MeasuredColumn(base, unit)
    return None


def quantities(base: str) -> tuple[Dimension, ...]:
    """What a column or key may measure, by its name without the unit; empty where that is not known."""
    return next((dimensions for pattern, dimensions in _MEASURED if pattern.fullmatch(base)), ())


def require_dimension(unit: Unit, dimensions: tuple[Dimension, ...], what: str, where: str = "") -> None:
    """Raise an `InputError` where a unit is not one of `dimensions`."""
    if unit.dimension in dimensions:
        return
    known = ", ".join(f"{name}" for d in dimensions for name in known_units(d))
    text = f"the unit contradicts the quantity: `{what}` is {_article(' or '.join(dimensions))}"
    raise InputError(f"{text}, and {unit.name} is a unit of {unit.dimension}", where=where, remedy=f"Known: {known}.")


def known_units(dimension: Dimension) -> list[str]:
    """Names of the units of a quantity."""
    return [unit.name for unit in UNITS.values() if unit.dimension == dimension]


@dataclass(frozen=True)
class WantedUnits:
    """The units that a table is to be written in, by what they measure.

    Attributes:
        poses: of poses and loads, and of all else where one unit of a quantity is asked for.
        readings: of readings, corrections and uncertainties.
    """

    poses: dict[Dimension, Unit]
    readings: dict[Dimension, Unit]

    def of(self, column: MeasuredColumn) -> Unit | None:
        """The unit that a column is to be written in, or None to leave it as it is."""
        units = self.readings if _OF_A_READING.fullmatch(column.base) else self.poses
        return units.get(column.unit.dimension)


_OF_A_READING = re.compile(r"(reading_|correction|U_).*|[ds]r?[xyz]|sp[xyz]")


def wanted_units(text: str) -> WantedUnits:
    """The units that a list such as `mm,deg,um,urad` asks for: of two that measure the same the first is that of poses
    and loads, the second that of readings, corrections and uncertainties.

    Raises:
        ArgumentError: a unit is unknown, or three measure the same.
    """
    poses: dict[Dimension, Unit] = {}
    readings: dict[Dimension, Unit] = {}
    for part in text.split(","):
        unit = unit_of(part)
        if unit is None:
            raise ArgumentError(f"unknown unit `{part.strip()}`", argument="units", remedy=nearest(part.strip(), UNITS))
        if unit.dimension in readings or poses.get(unit.dimension) == unit:
            what = f"{poses[unit.dimension].name} and {unit.name} both measure {_article(unit.dimension)}"
            remedy = "At most two: the first for poses and loads, the second for readings and uncertainties."
            raise ArgumentError(what, argument="units", remedy=remedy)
        (readings if unit.dimension in poses else poses)[unit.dimension] = unit
    return WantedUnits(poses, poses | readings)


def _article(noun: str) -> str:
    return f"{'an' if noun[0] in 'aeiou' else 'a'} {noun}"

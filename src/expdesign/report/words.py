"""How numbers, units and names are written in reports."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

_NEGLIGIBLE = 1e-6
"""Part of a column's scale below which a number is shown as 0: rounding, not a finding."""


_RAISED = "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"
_SUPERSCRIPT, _LOWERED = str.maketrans("-0123456789", _RAISED), str.maketrans(_RAISED, "-0123456789")
_SMALL_NUMBERS = (
    "no one two three four five six seven eight nine ten eleven twelve".split()  # noqa: SIM905 (easier to read)
)

_UNITS = {
    "_rad_per_Nm": "rad/(N·m)", "_m_per_N": "m/N", "_per_s": "1/s", "_Nm_per_rad": "N·m/rad", "_N_per_m": "N/m",
    "_per_K": "1/K", "_per_N": "1/N", "_m_s2": "m/s²", "_Nm": "N·m", "_kg": "kg", "_N": "N", "_s": "s",
}  # fmt: skip
"""How the unit at the end of a name is written; lengths and angles have a prefix besides."""
_JOINT_ANGLE = re.compile(r"q\d+_rad")
_NAMES = {"com": "centre of mass", "sequence": "no."}


def source(name: str) -> str:
    """What a source of load error is called."""
    return _NAMES.get(name, name)


UNDETERMINED = "not determined"


@dataclass(frozen=True)
class Column:
    """How a column of a plan is shown: `value · factor` in `unit`."""

    title: str
    unit: str
    factor: float

    @property
    def heading(self) -> str:
        """The title with its unit, as a heading or an axis has it."""
        return f"{self.title} ({self.unit})" if self.unit else self.title


def number(value: float, digits: int = 3, scale: float = 0.0) -> str:
    """`value` with `digits` significant digits; powers of ten only below 0.001 and from 100 000 on.

    Beside numbers as large as `scale`, one below a millionth of it is 0.
    """
    if not math.isfinite(value):
        return UNDETERMINED if math.isnan(value) else ("∞" if value > 0 else "−∞")
    if value == 0.0 or abs(value) < _NEGLIGIBLE * scale:
        return "0"
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    power = int(exponent)
    if -3 <= power < 5:
        text = f"{value:.{max(0, digits - 1 - power)}f}"
    else:
        text = f"{mantissa}\u202f·\u202f10{str(power).translate(_SUPERSCRIPT)}"
    return text.replace("-", "−")


def in_ascii_powers(text: str) -> str:
    """A text with powers of ten as `1e-7`, for a terminal that may not know raised digits."""
    return re.sub(f"\u202f·\u202f10([{_RAISED}]+)", lambda found: f"e{found[1].translate(_LOWERED)}", text)


def with_error(value: float, standard_error: float) -> str:
    """`value ± standard_error`, both to the second digit of the latter."""
    if not (math.isfinite(value) and 0.0 < standard_error < math.inf):
        return number(value)
    decimals = max(0, 1 - math.floor(math.log10(standard_error)))
    return f"{fixed(value, decimals)} ± {fixed(standard_error, decimals)}"


def given(value: float) -> str:
    """`value` as a person gave it, without trailing zeros."""
    return f"{value:.6g}".replace("-", "−")


def fixed(value: float, decimals: int) -> str:
    """`value` with `decimals` decimals, as a person sets it on an instrument; never a negative zero."""
    return f"{round(value, decimals) + 0.0:.{decimals}f}".replace("-", "−")


def size(value: float, unit: str) -> str:
    """A length (`m`) or an angle (`rad`) in µm or µrad, from a thousand of them on in mm or mrad, and so on."""
    if not math.isfinite(value):
        return UNDETERMINED
    if abs(value) >= 1.0:
        return f"{value:.3g} {unit}"
    prefix, factor = ("m", 1e3) if abs(value) >= 1e-3 else ("µ", 1e6)
    return f"{factor * value:.3g} {prefix}{unit}"


def count(value: int, singular: str) -> str:
    """A number of things: `six measurements`, `one target`, `120 designs`."""
    number = _SMALL_NUMBERS[value] if value < len(_SMALL_NUMBERS) else value
    return f"{number} {singular}{'' if value == 1 else 's'}"


def listed(parts: Sequence[str]) -> str:
    """Parts of a sentence in a row: `a`, `a and b`, `a, b and c`."""
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])} and {parts[-1]}"


def stiffness(unit: str) -> tuple[str, str, float]:
    """How a stiffness in `unit` is shown: its unit, that of a compliance, and the factor of the stiffness."""
    return ("N/µm", "µm/N", 1e-6) if unit == "N/m" else (unit, f"1/({unit})", 1.0)


def plan_column(name: str) -> Column:
    """How the column `name` of a plan is shown (lengths in mm, angles in mrad, those of joints in degrees)."""
    if _JOINT_ANGLE.fullmatch(name):
        return Column(name.removesuffix("_rad"), "°", 180.0 / math.pi)
    return _with_unit(name, "m", 1e3) or Column(_spoken(name), "", 1.0)


def parameter(name: str, size: float) -> Column:
    """How a parameter of an effect is shown whose values are about as large as `size` (SI units)."""
    prefix, factor = ("µ", 1e6) if abs(size) < 5e-4 else ("m", 1e3)
    return _with_unit(name, prefix, factor) or Column(name.replace("_", " "), "", 1.0)


def _with_unit(name: str, prefix: str, factor: float) -> Column | None:
    for suffix, unit in _UNITS.items():
        if name.endswith(suffix):
            return Column(_spoken(name.removesuffix(suffix)), unit, 1.0)
    stem, _, unit = name.rpartition("_")
    return Column(_spoken(stem), prefix + unit, factor) if stem and unit in ("m", "rad") else None


def _spoken(stem: str) -> str:
    head, *rest = stem.split("_")
    return " ".join((_NAMES.get(head, head), *rest))


def sentence(text: str) -> str:
    """A text with a capital at its beginning."""
    return text[:1].upper() + text[1:]


def axis(deflection: str) -> str:
    """Short name of a deflection column: `dz` for `dz_m`."""
    return deflection.rsplit("_", 1)[0]


def micro_unit(deflection: str) -> str:
    """Unit in which errors along a deflection column are shown; the value in SI units times 1e6."""
    return "µm" if deflection.endswith("_m") else "µrad"


def criterion(name: str) -> str:
    """Short name of a criterion: `DUIR`, `O_TP`, `total`."""
    return name if name == "total" else name.upper()


def criterion_with_unit(name: str, unit: str) -> str:
    """Heading of a column of criterion values; tolerances and pure numbers go without saying."""
    return criterion(name) if unit in ("1", "tolerances") else f"{criterion(name)} ({unit})"

"""Names of columns as people write them: in capitals, with a blank before the unit, without a unit, in other words.

What can mean one thing only is read so (`DX (mm)`, `dz mm`, `SEQUENCE`); what is nearly a known name is refused with
that name, because a column that is dropped changes what is identified from the others.
"""

import re
from functools import cache

from expdesign.coordinates import PLANAR, PLANE, SPATIAL
from expdesign.errors import InputError
from expdesign.io.units import UNITS, MeasuredColumn, Unit, quantities, unit_of

PLAIN = ("sequence", "series", "marker", "split", "reference", "kind", "points", "reference_points")
"""Columns without a unit."""

_FORMS = (
    re.compile(r"(?P<base>\w[\w ]*?)[\s_]*[\[(]\s*(?P<unit>[^\[\]()]+?)\s*[\])]"),
    re.compile(r"(?P<base>\w+)\s+(?P<unit>\S+)"),
    re.compile(r"(?P<base>\w+)_(?P<unit>[^_\s]+(?:_s2)?)"),
)

_SYNONYMS = {
    "sequence": ("seq", "seqno", "no", "nr", "nummer", "number", "row", "zeile", "messung", "measurement",
                 "reihenfolge", "folge", "index", "lfdnr"),
    "series": ("serie", "ser", "gruppe", "group", "posenr", "messreihe", "reihe", "pose"),
    "mass_kg": ("masse", "gewicht", "weight", "payload", "load", "last", "nutzlast", "massekg", "m"),
    "time_s": ("zeit", "t", "times", "zeits"),
    "temperature_degC": ("temperatur", "temp", "tempc", "temperaturc"),
    "marker": ("reflector", "reflektor", "smr", "punkt", "point", "target"),
    **{f"com_{axis}_m": (f"cog{axis}", f"sp{axis}", f"schwerpunkt{axis}", f"c{axis}", f"com{axis}m") for axis in "xyz"},
    **{f"d{axis}_m": (f"delta{axis}", f"deflection{axis}", f"verschiebung{axis}", f"u{axis}") for axis in "xyz"},
    **{f"dr{axis}_rad": (f"deltar{axis}", f"rotation{axis}", f"verdrehung{axis}") for axis in "xyz"},
    **{f"f{axis}_N": (f"force{axis}", f"kraft{axis}") for axis in "xyz"},
    **{f"m{axis}_Nm": (f"moment{axis}", f"torque{axis}", f"t{axis}") for axis in "xyz"},
    **{f"r{axis}_rad": (word,) for axis, word in zip("xyz", ("roll", "pitch", "yaw"), strict=True)},
}  # fmt: skip


def measured_as(name: str) -> MeasuredColumn | None:
    """Quantity and unit of a column whose name says both in other letters or with other marks, or None.

    Raises:
        InputError: its unit may be one of two (`MN` in capitals).
    """
    for form in _FORMS:
        found = form.fullmatch(name.strip())
        if found is None:
            continue
        base = re.sub(r"\s+", "_", found["base"].strip()).lower()
        dimensions = quantities(base)
        unit = unit_of(found["unit"])
        capitals = name.isupper() and found["unit"].isalpha()  # `MN` may then be mN
        if dimensions and (unit is None or unit.dimension not in dimensions or capitals):
            text = found["unit"].replace(" ", "")
            units = [one for one in UNITS.values() if one.name.lower() == text.lower() and one.dimension in dimensions]
            unit = _one_of(units, found["unit"])
        if dimensions and unit is not None:
            return MeasuredColumn(base, unit)
    return None


def _one_of(units: list[Unit], written: str) -> Unit | None:
    if len(units) > 1:
        names = " or ".join(unit.name for unit in units)
        raise InputError(f"the unit {written} may be {names}", remedy="Write it in its own letters.")
    return units[0] if units else None


def plain_as(name: str) -> str | None:
    """The column without a unit that has this name in other letters, or None."""
    lower = name.strip().lower().replace(" ", "_")
    return lower if lower in PLAIN else None


def meant(name: str) -> str | None:
    """The known column whose name this is but for marks and the unit (`dxm`, `x`), or None."""
    compact = _compact(name)
    joint = re.fullmatch(r"q(\d+)(rad)?", compact)
    return f"q{joint.group(1)}_rad" if joint else _without_marks().get(compact)


def synonym(name: str) -> str | None:
    """The known column that another word stands for (`Masse`, `Seq`), or None."""
    compact = _compact(name)
    own = meant(name)
    return own or next((known for known, words in _SYNONYMS.items() if compact in words), None)


def _compact(name: str) -> str:
    return re.sub(r"[\W_]", "", name).lower()


@cache
def _without_marks() -> dict[str, str]:
    """Known names by their letters and digits, with and without the unit."""
    known = list(PLAIN)
    for coordinates in (SPATIAL, PLANE, PLANAR):
        known += [name for names in vars(coordinates).values() if isinstance(names, tuple) for name in names]
    known += ["mass_kg", "time_s", "temperature_degC", "px_m", "py_m", "pz_m", "spx_m", "spy_m", "spz_m"]
    known += [f"{before}_{name}" for before in ("measured", "reading") for name in SPATIAL.pose]
    found = {_compact(name): name for name in known}
    for name in known:
        base = re.sub(r"_(m|rad|N|Nm|kg|s|degC|m_s2)$", "", name)
        found.setdefault(_compact(base), name)
    return found

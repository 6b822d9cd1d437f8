"""Units in YAML: a text of number and unit (`0.5 mm`) in the place of a number becomes the number in SI.

There is one form, the same for single numbers, lists, ranges and choices: `x_m: ["-30 mm", "30 mm"]`,
`mass_kg: {choices: ["500 g", 5]}`, `home: [0, 0, "250 mm"]`. What the key measures is read off its name (`x_m`, `sx_m`,
`mass_kg`, `half_angle_deg`), or stands here for keys whose names have no unit. A text at any other key stays a text.
"""

from typing import Any

from expdesign.io.units import QUANTITY, Dimension, Unit, measured_column, quantity, require_dimension, unit_of
from expdesign.io.yaml_document import KeyPath, YamlDocument

_KEYS: dict[str, tuple[Dimension, ...]] = {
    "home": ("length",),
    "base_joints": ("length",),
    "platform_joints": ("length",),
    "leg_length": ("length",),
    "markers": ("length",),
    "positions": ("length",),
    "com_m": ("length",),
    "std_m": ("length",),
    "gravity_m_s2": ("acceleration",),
    "actuator_stiffness": ("stiffness", "torsional stiffness"),
    "pose_change": ("time",),
    "mass_change": ("time",),
    "reading": ("time",),
}
_ERRORS: dict[str, tuple[Dimension, ...]] = {
    "com": ("length",),
    "mass": ("mass",),
    "direction": ("angle",),
}
_POSES = ("pose", "instrument", "candidates")
_MINUTES = ("pose_change", "mass_change", "reading")


def with_si_numbers(document: YamlDocument) -> YamlDocument:
    """The document with every text of number and unit, where a key measures something, as the number in SI.

    Raises:
        InputError: a unit is unknown, or contradicts what the key measures.
    """
    content = _converted(document.content, (), document)
    return YamlDocument(document.source, document.folder, content, document.lines, document.prefix)


def _converted(content: Any, path: KeyPath, document: YamlDocument) -> Any:
    if isinstance(content, dict):
        return {key: _converted(value, (*path, key), document) for key, value in content.items()}
    if isinstance(content, list):
        return [_converted(value, (*path, index), document) for index, value in enumerate(content)]
    if not isinstance(content, str):
        return content
    dimensions = _dimensions(path, document.content) if QUANTITY.fullmatch(content.strip()) else ()
    if not dimensions:
        return content
    value, unit = quantity(content, document.where(path))
    require_dimension(unit, dimensions, str(_named(path)[-1]), document.where(path))
    if _named(path)[-1] in _MINUTES:
        return value / 60.0
    own = _own_unit(_named(path)[-1])
    return value if own is None else own.from_si(value)


def _dimensions(path: KeyPath, content: Any) -> tuple[Dimension, ...]:
    """What stands at a key path may measure; empty where that is not known."""
    names, last = _named(path), path[-1]
    if not names:
        return ()
    if "markers" in names[:-1]:
        return _KEYS["markers"]
    key = names[-1]
    if key == "wrench" and isinstance(last, int):
        return ("force",) if last < len(_at(content, path[:-1])) / 2 else ("moment",)
    if key in _POSES and isinstance(last, int):
        return _coordinate(_at(content, path[:-1]), last)
    if key == "std" and "load_error" in names:
        entry = _at(content, path[: len(path) - 1 - path[::-1].index("std")])
        source = entry.get("source") if isinstance(entry, dict) else None
        if source == "wrench":
            return ("moment",) if isinstance(last, int) and last >= 3 else ("force",)
        return _ERRORS.get(str(source), ())
    if key in _KEYS:
        return _KEYS[key]
    if "limits" in names[:-1]:  # of joints, by their names
        return ("length", "angle")
    own = _own_unit(key)
    return () if own is None else (own.dimension,)


def _own_unit(key: str) -> Unit | None:
    """The unit with which a key's name ends (`x_m`, `radius_m`, `half_angle_deg`); None where it is no unit."""
    if key in _KEYS:
        return None
    measured = measured_column(key)
    if measured is not None:
        return measured.unit
    return unit_of(key.rpartition("_")[2]) if "_" in key else None


def _coordinate(row: list[Any], index: int) -> tuple[Dimension, ...]:
    """A coordinate of a pose: three lengths and three angles, or joints, of which the first ones turn."""
    first = [unit for unit in map(_unit_in, row[:3]) if unit is not None]
    joints = any(unit.dimension == "angle" for unit in first)
    if joints:
        return ("length", "angle")
    return ("length", "angle") if index < 3 and not first else (("length",) if index < 3 else ("angle",))


def _unit_in(value: Any) -> Unit | None:
    found = QUANTITY.fullmatch(value.strip()) if isinstance(value, str) else None
    return unit_of(found.group(2)) if found else None


def _named(path: KeyPath) -> list[str]:
    """The names on a key path; a sweep writes several in one (`experiment.load.mass_kg`)."""
    names = [name for key in path if isinstance(key, str) for name in key.split(".")]
    return [name for name in names if name != "choices"]


def _at(content: Any, path: KeyPath) -> Any:
    for key in path:
        content = content[key]
    return content

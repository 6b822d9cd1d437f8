"""YAML with the number formats of YAML 1.2, no duplicate keys, and the line on which every key stands.

The content of a YAML file, with the line on which every key stands.

Units in YAML: a text of number and unit (`0.5 mm`) in the place of a number becomes the number in SI.

There is one form, the same for single numbers, lists, ranges and choices: `x_m: ["-30 mm", "30 mm"]`,
`mass_kg: {choices: ["500 g", 5]}`, `home: [0, 0, "250 mm"]`. What the key measures is read off its name (`x_m`, `sx_m`,
`mass_kg`, `half_angle_deg`), or stands here for keys whose names have no unit. A text at any other key stays a text.
"""

import os
import re
import stat
from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field
from functools import reduce
from operator import getitem
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from pydantic import BaseModel
from yaml.composer import Composer

from expdesign.errors import InputError
from expdesign.io.units import QUANTITY, Dimension, Unit, measured_column, quantity, require_dimension, unit_of

KeyPath = tuple[str | int, ...]


@dataclass(frozen=True)
class YamlDocument:
    """The content of a YAML file, or what stands at a place in it.

    Attributes:
        source: name of the file, for messages.
        folder: what relative paths inside the document are relative to.
        content: plain Python data.
        lines: line number (from 1) of each key path.
        prefix: key path of `content` inside the file, where it is a part of it.
    """

    source: str
    folder: Path
    content: Any
    lines: dict[KeyPath, int] = field(default_factory=dict)
    prefix: KeyPath = ()

    def where(self, *path: str | int) -> "YamlDocument":
        """What stands at a key, or an entry of a list, below this content: None where nothing does."""
        try:
            content = reduce(getitem, path, self.content)
        except (LookupError, TypeError):
            content = None
        return YamlDocument(self.source, self.folder, content, self.lines, self.prefix + path)

    def __str__(self) -> str:
        """File, line and key, as a person would look it up."""
        known = self.prefix
        while known and known not in self.lines:
            known = known[:-1]
        place = f"{self.source}, line {self.lines[known]}" if known in self.lines else self.source
        return f"{place}, {dotted(self.prefix)}" if self.prefix else place

    def fault(self, what: str, remedy: str = "") -> InputError:
        """The error to raise where what stands here cannot be meant."""
        return InputError(what, where=str(self), remedy=remedy)

    @property
    def file(self) -> Path:
        """The file that is named here.

        Raises:
            InputError: there is none, or it is a pipe or a device, which only a person can name: reading may never end.
        """
        place = self.folder / self.content
        if os.path.isfile(place):  # False for a name that no file can have
            return place
        if os.path.exists(place) and not os.path.isdir(place):
            raise InputError("this is a pipe or a device, not a file", where=str(place), remedy="Name a file.")
        raise self.fault(f"there is no file {place}", "Paths are relative to the file in which they stand.")

    @property
    def written_out(self) -> "YamlDocument":
        """What stands in the file that is named here; the document itself where none is named."""
        return read_yaml(self.file) if isinstance(self.content, str) else self


def dotted(path: KeyPath) -> str:
    """`("targets", 0, "pose")` as `targets[0].pose`."""
    text = ""
    for key in path:
        text += f"[{key}]" if isinstance(key, int) else (f".{key}" if text else key)
    return text


_POSES = ("pose", "instrument", "candidates")
_MINUTES = ("pose_change", "mass_change", "reading")
_LENGTHS = ("home", "base_joints", "platform_joints", "leg_length", "markers", "positions", "com_m", "std_m")
_KEYS: dict[str, tuple[Dimension, ...]] = {
    **dict.fromkeys(_LENGTHS, ("length",)),
    **dict.fromkeys(_MINUTES, ("time",)),
    "gravity_m_s2": ("acceleration",),
    "actuator_stiffness": ("stiffness", "torsional stiffness"),
}
_ERRORS: dict[str, tuple[Dimension, ...]] = {"com": ("length",), "mass": ("mass",), "direction": ("angle",)}


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
    dimensions = _dimensions(path, document) if QUANTITY.fullmatch(content.strip()) else ()
    if not dimensions:
        return content
    where = str(document.where(*path))
    value, unit = quantity(content, where)
    require_dimension(unit, dimensions, str(_named(path)[-1]), where)
    if _named(path)[-1] in _MINUTES:
        return value / 60.0
    own = _own_unit(_named(path)[-1])
    return value if own is None else own.from_si(value)


def _dimensions(path: KeyPath, document: YamlDocument) -> tuple[Dimension, ...]:
    """What stands at a key path may measure; empty where that is not known."""
    names, last = _named(path), path[-1]
    if not names:
        return ()
    if "markers" in names[:-1]:
        return _KEYS["markers"]
    key = names[-1]
    if key == "wrench" and isinstance(last, int):
        return ("force",) if last < len(document.where(*path[:-1]).content) / 2 else ("moment",)
    if key in _POSES and isinstance(last, int):
        return _coordinate(document.where(*path[:-1]).content, last)
    if key == "std" and "load_error" in names:
        entry = document.where(*path[: len(path) - 1 - path[::-1].index("std")]).content
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


_EXPONENT = re.compile(r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)[eE][-+]?[0-9]+")
"""Numbers that YAML 1.1 reads as texts."""
_INPUTS = {"kind", "base_joints", "experiment", "targets", "vary", "cases"}
"""Keys of which every file that is read has one; a record of results has none."""
_TEXTS = ("name", "urdf", "robot", "base_link", "tip_link")
"""Keys whose texts stay as they are, whatever they look like."""
_LARGEST_DOCUMENT = 1_000_000
"""Keys and entries, aliases written out; aliases of aliases can ask for more than any memory holds."""


class _Loader(Composer, yaml.CSafeLoader):
    """Safe loader whose numbers are those of YAML 1.2 (`1e8` is a number, `1:30` and `010` are not surprises).

    Nodes are made here from what libyaml parses: its own are made by recursion without a limit.
    """

    def __init__(self, text: str) -> None:
        yaml.CSafeLoader.__init__(self, text)
        Composer.__init__(self)


_Loader.yaml_implicit_resolvers = {
    first: [(tag, pattern) for tag, pattern in resolvers if tag not in _REPLACED]
    for _REPLACED in [("tag:yaml.org,2002:float", "tag:yaml.org,2002:int", "tag:yaml.org,2002:timestamp")]
    for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()
}
_Loader.add_implicit_resolver("tag:yaml.org,2002:int", re.compile(r"^[-+]?[0-9]+$"), list("-+0123456789"))
_Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float",
    re.compile(
        r"^(?:[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?|[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN))$"
    ),
    list("-+.0123456789"),
)


def yaml_text(content: Mapping[str, Any]) -> str:
    """Content as YAML in the order of its keys, lines of 120 characters, lists of numbers in brackets."""
    try:
        text: str = yaml.dump(
            content, Dumper=yaml.CSafeDumper, sort_keys=False, default_flow_style=None, width=120, allow_unicode=True
        )
    except UnicodeEncodeError as error:
        what = f"the name of a file in it is not UTF-8 text ({error.object!a})"
        raise InputError(what, remedy="Rename the file.") from None
    return text


_Loader.add_constructor("tag:yaml.org,2002:int", lambda _, node: int(node.value))


def read_yaml(path: Path) -> YamlDocument:
    """Read a YAML file.

    Raises:
        InputError: the file is missing, is not text, is not YAML, or names a key twice.
    """
    document = parse_yaml(read_text(path), str(path), path.parent)
    if path.suffix.lower() == ".json" and not (isinstance(document.content, dict) and _INPUTS & set(document.content)):
        remedy = "Name the file from which the results were made, or the `model.yaml` beside it."
        raise InputError("this is a record of results", where=str(path), remedy=remedy)
    return document


def read_text(path: Path) -> str:
    """The text of a UTF-8 file (a byte-order mark is ignored), or an `InputError` that says why there is none."""
    data = read_bytes(path)
    if data[:15].lower().lstrip().startswith((b"<!doctype html", b"<html")):
        remedy = "Name a YAML file; results that can be used again are in the `model.yaml` beside the page."
        raise InputError("this is a page (HTML)", where=str(path), remedy=remedy)
    if data[:4] == b"PK\x03\x04":
        raise InputError("this is a workbook, not text", where=str(path), remedy="Check the order of the files.")
    try:
        return data.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError as error:
        remedy = "Save the file as UTF-8 text."
        raise InputError(f"not UTF-8 text (byte {error.start})", where=str(path), remedy=remedy) from None


def read_bytes(path: Path) -> bytes:
    """The content of a file, or an `InputError` that says why there is none."""
    try:
        mode = path.stat().st_mode
        if stat.S_ISCHR(mode) or stat.S_ISBLK(mode) or stat.S_ISSOCK(mode):
            raise InputError("this is a device, not a file", where=str(path), remedy="Name a file.")
        return path.read_bytes()
    except FileNotFoundError:
        raise InputError("there is no such file", where=str(path), remedy="Check the path.") from None
    except IsADirectoryError:
        raise InputError("this is a folder, not a file", where=str(path), remedy="Name a file in it.") from None
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError(
            f"cannot be read ({reason})", where=str(path), remedy="Check the path and its rights."
        ) from None


def parse_yaml(text: str, source: str, folder: Path) -> YamlDocument:
    """Read YAML from text; see `read_yaml`."""
    try:
        loader = _Loader(text)
        try:
            node = loader.get_single_node()
            lines: dict[KeyPath, int] = {}
            if node is not None:
                _walk(node, (), lines, source, set())
            content = loader.construct_document(node) if node is not None else None
        finally:
            loader.dispose()
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = f", line {mark.line + 1}" if mark else ""
        what = f"not valid YAML: {error.problem or error.context or 'it cannot be parsed'}"
        remedy = "Correct the syntax there (indentation, a missing colon or bracket)."
        raise InputError(what, where=f"{source}{line}", remedy=remedy) from None
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        what = f"not valid YAML: {' '.join(str(error).split())}"
        raise InputError(what, where=source, remedy="Correct the syntax.") from None
    return with_si_numbers(YamlDocument(source, folder, content, lines))


def document_from_mapping(content: Mapping[str, Any] | BaseModel, name: str) -> YamlDocument:
    """Content that was made in Python, relative paths being those of the working folder.

    Readers of YAML 1.1 (`yaml.safe_load`) take `1e7` for a text; here it is the number.
    """
    return with_si_numbers(YamlDocument(name, Path(), _plain(content)))


def _plain(content: Any, key: object = None) -> Any:
    """Sections, arrays and paths as what a YAML file holds."""
    if isinstance(content, BaseModel):
        return content.model_dump(mode="json", exclude_none=True)
    if isinstance(content, Mapping):
        return {name: _plain(value, name) for name, value in content.items()}
    if isinstance(content, np.ndarray | np.generic):
        return content.tolist()
    if isinstance(content, list | tuple):
        return [_plain(value, key) for value in content]
    if isinstance(content, str) and key not in _TEXTS and _EXPONENT.fullmatch(content):
        return float(content)
    return str(content) if isinstance(content, Path) else content


def _walk(node: yaml.Node, path: KeyPath, lines: dict[KeyPath, int], source: str, above: set[int]) -> None:
    """Note the line of every key below `node`, and refuse duplicate keys and aliases that contain themselves."""
    if id(node) in above:
        where = f"{source}, line {node.start_mark.line + 1}"
        raise InputError("an alias refers to itself", where=where, remedy="Write the value out.")
    if len(lines) > _LARGEST_DOCUMENT:
        what = f"more than {_LARGEST_DOCUMENT} entries"
        raise InputError(what, where=source, remedy="Shorten the file (aliases count as often as they are used).")
    above = above | {id(node)}
    if isinstance(node, yaml.MappingNode):
        seen: set[Hashable] = set()
        for key_node, value_node in node.value:
            key = str(key_node.value) if isinstance(key_node, yaml.ScalarNode) else "?"
            line = key_node.start_mark.line + 1
            if key in seen and key != "<<":
                where = f"{source}, line {line}, {dotted((*path, key))}"
                raise InputError("this key appears twice", where=where, remedy="Keep one of them.")
            seen.add(key)
            lines[(*path, key)] = line
            _walk(value_node, (*path, key), lines, source, above)
    elif isinstance(node, yaml.SequenceNode):
        for index, item in enumerate(node.value):
            lines[(*path, index)] = item.start_mark.line + 1
            _walk(item, (*path, index), lines, source, above)

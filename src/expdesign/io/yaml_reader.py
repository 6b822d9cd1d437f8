"""YAML with the number formats of YAML 1.2, no duplicate keys, and the line on which every key stands."""

import re
from collections.abc import Hashable, Mapping
from pathlib import Path
from typing import Any

import yaml

from expdesign.errors import InputError
from expdesign.io.yaml_document import KeyPath, YamlDocument, dotted
from expdesign.io.yaml_units import with_si_numbers

__all__ = [
    "KeyPath",
    "YamlDocument",
    "document_from_mapping",
    "dotted",
    "parse_yaml",
    "read_bytes",
    "read_text",
    "read_yaml",
]

_EXPONENT = re.compile(r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)[eE][-+]?[0-9]+")
"""Numbers that YAML 1.1 reads as texts."""
_INPUTS = {"kind", "base_joints", "experiment", "targets", "vary", "cases"}
"""Keys of which every file that is read has one; a record of results has none."""
_TEXTS = ("name", "urdf", "robot", "base_link", "tip_link")
"""Keys whose texts stay as they are, whatever they look like."""
_LARGEST_DOCUMENT = 1_000_000
"""Keys and entries, aliases written out; aliases of aliases can ask for more than any memory holds."""


class _Loader(yaml.SafeLoader):
    """Safe loader whose numbers are those of YAML 1.2 (`1e8` is a number, `1:30` and `010` are not surprises)."""


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


def _construct_int(loader: yaml.SafeLoader, node: yaml.ScalarNode) -> int:
    return int(node.value)


def _construct_float(loader: yaml.SafeLoader, node: yaml.ScalarNode) -> float:
    return float(node.value.lower().replace(".inf", "inf").replace(".nan", "nan"))


_Loader.add_constructor("tag:yaml.org,2002:int", _construct_int)
_Loader.add_constructor("tag:yaml.org,2002:float", _construct_float)


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


def document_from_mapping(content: Mapping[str, Any], name: str) -> YamlDocument:
    """Content that was read elsewhere, relative paths being those of the working folder.

    Readers of YAML 1.1 (`yaml.safe_load`) take `1e7` for a text; here it is the number.
    """
    return with_si_numbers(YamlDocument(name, Path(), _with_numbers(dict(content))))


def _with_numbers(content: Any, key: object = None) -> Any:
    if isinstance(content, Mapping):
        return {name: _with_numbers(value, name) for name, value in content.items()}
    if isinstance(content, list | tuple):
        return [_with_numbers(value, key) for value in content]
    if isinstance(content, str) and key not in _TEXTS and _EXPONENT.fullmatch(content):
        return float(content)
    return content


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
                raise InputError("this key stands here twice", where=where, remedy="Keep one of them.")
            seen.add(key)
            lines[(*path, key)] = line
            _walk(value_node, (*path, key), lines, source, above)
    elif isinstance(node, yaml.SequenceNode):
        for index, item in enumerate(node.value):
            lines[(*path, index)] = item.start_mark.line + 1
            _walk(item, (*path, index), lines, source, above)

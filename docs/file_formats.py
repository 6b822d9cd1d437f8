"""Write the tables of keys into docs/file-formats.md: `python docs/file_formats.py` (`--check` only compares).

A table stands between `<!-- keys: NAME -->` and `<!-- end -->`. It is made from the schemas that read the files, so
that key, value and meaning are those of the program. `<!-- keys: configuration optimiser -->` is the table of one
section of a configuration. The JSON schemas for editors in docs/schema are written as well.
"""

import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

import expdesign as xd
from expdesign.app.api.schema import KINDS, robot_sections
from expdesign.chain.declaration import Declaration
from expdesign.chain.models.effect_entry import effect_classes
from expdesign.chain.recordings.columns import RECORDED
from expdesign.io.output import json_text
from expdesign.mechanics.robots.robot import RobotSection

DOCS = Path(__file__).parent
PAGE = DOCS / "file-formats.md"
ROBOTS = ("bipod", "body", "hexapod", "serial")
"""Kinds of robots on the page; a new kind works without being on it."""
SECTIONS = (
    "experiment",
    "experiment.poses",
    "experiment.load",
    "experiment.deflection_noise",
    "experiment.load_error[]",
    "experiment.constraints",
    "targets[]",
    "model_error",
    "optimiser",
    "acceptance",
)
"""Sections of a configuration that have a table of their own."""
_BLOCK = re.compile(r"(<!-- keys: (\w+)(?: ([\w.\[\]]+))? -->\n).*?(<!-- end -->)", flags=re.DOTALL)


@dataclass(frozen=True)
class Entry:
    """A row of a table: a key with its section, the values it takes, and what it means."""

    section: str
    key: str
    value: str
    meaning: str


def page(text: str) -> str:
    """The page with its tables made anew."""
    return _BLOCK.sub(lambda found: f"{found[1]}\n{table(found[2], found[3] or '')}\n{found[4]}", text)


def table(name: str, section: str = "") -> str:
    """One table.

    Args:
        name: `robot` (what all have), `hexapod` …, `configuration`, `physics`, `recordings` or `sweep`.
        section: of a configuration, one of `SECTIONS`; without it the keys outside of all of them.
    """
    if name == "physics":
        rows = ["| identifier | left out of the base model |", *_physics_rows()]
    elif name == "recordings":
        rows = ["| column | meaning |", *(f"| {group.shown} | {group.meaning} |" for group in RECORDED)]
    else:
        rows = ["| key | value | meaning |", *_rows(entry for entry in entries(name) if entry.section == section)]
    columns = rows[0].count("|") - 1
    return "\n".join([rows[0], "|" + " --- |" * columns, *rows[1:]]) + "\n"


def entries(name: str) -> list[Entry]:
    """Keys of a kind of file in the order of its schema."""
    shared = RobotSection.model_json_schema()
    if name in ROBOTS:
        schema = robot_sections([name])[name].model_json_schema()
        schema["properties"] = {
            key: one for key, one in schema["properties"].items() if key not in shared["properties"]
        }
    else:
        schema = shared if name == "robot" else xd.schema(name)
    return list(_entries(schema, schema.get("$defs", {}), {}, SECTIONS if name == "configuration" else ()))


def _entries(
    schema: dict[str, Any],
    definitions: dict[str, Any],
    listed: dict[str, str],
    sections: tuple[str, ...],
    above: str = "",
) -> Iterator[Entry]:
    """Keys of a schema, those of a section below its key; a section that stands in several places is listed once."""
    for key, content in schema.get("properties", {}).items():
        path = f"{above}{key}"
        section = max((name for name in sections if path.startswith(f"{name}.")), key=len, default="")
        references = [reference for part in _parts(content) for reference in _references(part)]
        again = [listed[name] for name, _ in references if name in listed]
        meaning = content.get("description", "") + (f" Keys as of `{again[0]}`." if again else "")
        shown = path.removeprefix(f"{section}.")
        yield Entry(section, shown, _value(content, key in schema.get("required", [])), meaning)
        for name, ending in references:
            if name not in listed:
                listed[name] = shown
                yield from _entries(definitions[name], definitions, listed, sections, f"{path}{ending}.")


def _references(part: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Sections that a value is made of, and what stands behind its key: nothing, `[]` in a list, a key in a mapping."""
    if "$ref" in part:
        yield part["$ref"].rsplit("/", 1)[1], ""
    for name, ending in (("items", "[]"), ("additionalProperties", ".KEY")):
        inner = part.get(name)
        for option in _parts(inner) if isinstance(inner, dict) else []:
            if "$ref" in option:
                yield option["$ref"].rsplit("/", 1)[1], ending


def _parts(content: dict[str, Any]) -> list[dict[str, Any]]:
    """The alternatives of a value, without null."""
    for name in ("anyOf", "oneOf", "allOf"):
        if name in content:
            return [part for option in content[name] for part in _parts(option)]
    return [] if content.get("type") == "null" else [content]


def _rows(found: Iterator[Entry]) -> Iterator[str]:
    """Rows of a table; keys that follow each other with the same value and meaning stand in one."""
    for (value, meaning), same in groupby(found, key=lambda entry: (entry.value, entry.meaning)):
        cells = [", ".join(f"`{entry.key}`" for entry in same), value, meaning]
        yield "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def _value(content: dict[str, Any], required: bool) -> str:
    """What may stand there, and what holds where nothing does."""
    default = content.get("default")
    form = _form(content)
    if required:
        return f"{form}, required"
    if default is None or isinstance(default, dict) or form == f"`{default}`":
        return form
    text = str(default).lower() if isinstance(default, bool) else default
    return f"{form}; default `{text}`"


_WORDS = {
    "number": "number",
    "integer": "whole number",
    "string": "text",
    "boolean": "true or false",
    "object": "mapping",
    "array": "list",
}


def _form(content: dict[str, Any]) -> str:
    parts = _parts(content)
    if any(set(part.get("properties", {})) == {"choices"} for part in parts):
        return "quantity"
    # Every number may be a text of number and unit, which the page says once.
    forms = [_one_form(part) for part in parts if "pattern" not in part]
    return " or ".join(dict.fromkeys(forms))


def _one_form(part: dict[str, Any]) -> str:
    if "$ref" in part:
        return "mapping"
    if "const" in part:
        return f"`{part['const']}`"
    if "enum" in part:
        return ", ".join(f"`{value}`" for value in part["enum"])
    kind = part.get("type")
    if kind == "array":
        low, high = part.get("minItems"), part.get("maxItems")
        size = f" of {low}" if low is not None and low == high else ""
        items = [one for one in _parts(part.get("items", {})) if "pattern" not in one]
        inner = _one_form(items[0]) if len(items) == 1 and items[0] else ""
        plural = {"number": "numbers", "list of 3": "`[x, y, z]`", "list of 2": "`[x, y]`", "text": "texts"}
        inner = "lists of numbers" if inner == "list of numbers" else plural.get(inner, plural.get(inner[:9], inner))
        inner = "mappings" if inner == "mapping" else inner.replace("number ", "numbers ", 1)
        return f"list{size}{' ' if size and inner else ' of ' if inner else ''}{inner}" if inner else f"list{size}"
    low, above = part.get("minimum", part.get("ge")), part.get("exclusiveMinimum", part.get("gt"))
    bound = f" > {above:g}" if above is not None else f" ≥ {low:g}" if low is not None else ""
    return _WORDS.get(str(kind), "anything") + bound


_NO_EFFECTS = {
    "outlier": "single rows that belong to no physics",
    "law": "a law at a port ([theory, 22](theory.md#22-laws-at-ports)) that none of these covers",
    "unknown": "none of these",
}


def _physics_rows() -> Iterator[str]:
    """Identifiers of physics as the effects declare them; several classes may have one."""
    declared: dict[str, list[Declaration]] = {}
    for cls in effect_classes():
        declared.setdefault(cls.physics, []).append(cls.declared)
    for physics, every in declared.items():
        yield f"| `{physics}` | {'; '.join(dict.fromkeys(each.left_out for each in every))} |"
    for identifier, meaning in _NO_EFFECTS.items():
        yield f"| `{identifier}` | {meaning} |"


def files() -> dict[Path, str]:
    """Every file that this script makes, with its content."""
    made = {DOCS / "schema" / f"{kind}.schema.json": json_text(xd.schema(kind, ROBOTS)) for kind in KINDS}
    return {PAGE: page(PAGE.read_text(encoding="utf-8"))} | made


if __name__ == "__main__":
    stale = [path for path, text in files().items() if path.read_text(encoding="utf-8") != text]
    for path in stale:
        print(path)
        if "--check" not in sys.argv:
            path.write_text(files()[path], encoding="utf-8")
    sys.exit(1 if stale and "--check" in sys.argv else 0)

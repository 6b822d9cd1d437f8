"""Write the tables of keys into docs/file-formats.md: `python docs/file_formats.py` (`--check` only compares).

A table stands between `<!-- keys: NAME -->` and `<!-- end -->`. It is made from the schemas that read the files, so
that key, form, default and meaning are those of the program. The JSON schemas for editors in docs/schema are written
as well.
"""

import re
import sys
from collections.abc import Iterator
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
_BLOCK = re.compile(r"(<!-- keys: ([\w ]+) -->\n).*?(<!-- end -->)", flags=re.DOTALL)


def page(text: str) -> str:
    """The page with its tables made anew."""
    return _BLOCK.sub(lambda found: found[1] + "\n" + table(found[2]) + "\n" + found[3], text)


def table(name: str) -> str:
    """One table: `robot` (what all have), `hexapod` …, `configuration`, `physics`, `recordings` or `sweep`."""
    rows = ["| key | form | default | meaning |", "| --- | --- | --- | --- |"]
    if name == "physics":
        return "\n".join(_physics_rows()) + "\n"
    if name == "recordings":
        columns = (f"| {group.shown} | {group.meaning} |" for group in RECORDED)
        return "\n".join(["| column | meaning |", "| --- | --- |", *columns]) + "\n"
    shared = RobotSection.model_json_schema()
    if name in ROBOTS:
        schema = robot_sections([name])[name].model_json_schema()
        schema["properties"] = {
            key: one for key, one in schema["properties"].items() if key not in shared["properties"]
        }
    else:
        schema = shared if name == "robot" else xd.schema(name)
    return "\n".join([*rows, *(_row(*entry) for entry in _entries(schema, schema.get("$defs", {})))]) + "\n"


_NO_EFFECTS = {
    "outlier": "single rows that belong to no physics",
    "law": "none of these: a law at a port ([theory, 22](theory.md#22-laws-at-ports))",
    "unknown": "none of these",
}


def _physics_rows() -> Iterator[str]:
    """Identifiers of physics as the effects declare them, by where they act; several classes may have one."""
    yield from ("| identifier | left out of the base model | usually |", "| --- | --- | --- |")
    declared: dict[str, list[Declaration]] = {}
    for cls in effect_classes():
        declared.setdefault(cls.physics, []).append(cls.declared)
    for physics, every in declared.items():
        left_out, usually = (
            "; ".join(dict.fromkeys(text)) for text in zip(*((d.left_out, d.usually) for d in every), strict=True)
        )
        yield f"| `{physics}` | {left_out} | {usually} |"
    for identifier, meaning in _NO_EFFECTS.items():
        yield f"| `{identifier}` | {meaning} | |"


Entry = tuple[str, dict[str, Any], bool]


def _entries(schema: dict[str, Any], sections: dict[str, Any], above: str = "") -> Iterator[Entry]:
    """Keys with their schemas and whether they are required, those of sections below the section's own key."""
    for key, content in schema.get("properties", {}).items():
        path = f"{above}{key}"
        yield path, content, key in schema.get("required", [])
        for part in _parts(content):
            for reference, ending in _references(part):
                yield from _entries(sections[reference.rsplit("/", 1)[1]], sections, f"{path}{ending}.")


def _references(part: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Sections that a value is made of, and what stands behind its key: nothing, `[]` in a list, a key in a mapping."""
    if "$ref" in part:
        yield part["$ref"], ""
    for name, ending in (("items", "[]"), ("additionalProperties", ".KEY")):
        inner = part.get(name)
        for option in _parts(inner) if isinstance(inner, dict) else []:
            if "$ref" in option:
                yield option["$ref"], ending


def _parts(content: dict[str, Any]) -> list[dict[str, Any]]:
    """The alternatives of a value, without null."""
    for name in ("anyOf", "oneOf", "allOf"):
        if name in content:
            return [part for option in content[name] for part in _parts(option)]
    return [] if content.get("type") == "null" else [content]


def _row(key: str, content: dict[str, Any], required: bool) -> str:
    cells = [f"`{key}`", _form(content), _default(content, required), content.get("description", "")]
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def _default(content: dict[str, Any], required: bool) -> str:
    if required:
        return "required"
    if content.get("default") is None or isinstance(content["default"], dict):
        return "–"
    return f"`{str(content['default']).lower() if isinstance(content['default'], bool) else content['default']}`"


_WORDS = {
    "number": "number",
    "integer": "whole number",
    "string": "text",
    "boolean": "true or false",
    "object": "mapping",
    "array": "list",
}


def _form(content: dict[str, Any]) -> str:
    forms = [_one_form(part) for part in _parts(content)]
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
        items = part.get("items", {})
        inner = _one_form(_parts(items)[0]) if items and len(_parts(items)) == 1 else ""
        plural = {"number": "numbers", "list of 3": "`[x, y, z]`", "list of 2": "`[x, y]`", "text": "texts"}
        inner = "lists of numbers" if inner == "list of numbers" else plural.get(inner, plural.get(inner[:9], inner))
        inner = "mappings" if inner == "mapping" else inner
        return f"list{size}{' ' if size and inner else ' of ' if inner else ''}{inner}" if inner else f"list{size}"
    low, above = part.get("minimum", part.get("ge")), part.get("exclusiveMinimum", part.get("gt"))
    bound = f" > {above:g}" if above is not None else f" ≥ {low:g}" if low is not None else ""
    return _WORDS.get(str(kind), "anything") + bound


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

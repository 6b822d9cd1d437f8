"""`expdesign schema`: the keys of a file, for editors."""

import difflib
from typing import Annotated, Any

import typer
from pydantic import BaseModel

from expdesign.design.schema import RunSection
from expdesign.errors import InputError
from expdesign.files.output import json_text
from expdesign.files.units import QUANTITY
from expdesign.sweeps.schema import SweepSection

SCHEMAS: dict[str, type[BaseModel]] = {"configuration": RunSection, "sweep": SweepSection}


def command(
    kind: Annotated[str, typer.Argument(help="`configuration` or `sweep`.")] = "configuration",
) -> None:
    """Print the JSON schema of a kind of file, with which an editor completes keys and marks mistakes.

    Example: expdesign schema configuration > configuration.schema.json
    """
    if kind not in SCHEMAS:
        near = difflib.get_close_matches(kind, list(SCHEMAS), n=1, cutoff=0.4)
        remedy = f"Did you mean `{near[0]}`?" if near else f"Known: {', '.join(SCHEMAS)}."
        raise InputError(f"there is no schema of `{kind}`", remedy=remedy)
    print(schema_text(kind), end="")


def schema_text(kind: str) -> str:
    """The schema as it stands in a file."""
    content: dict[str, Any] = {"$schema": "https://json-schema.org/draft/2020-12/schema"}
    return json_text(content | _with_texts(SCHEMAS[kind].model_json_schema()))


def _with_texts(schema: Any) -> Any:
    """The schema in which a number may also be a text of number and unit (`0.5 mm`)."""
    if isinstance(schema, list):
        return [_with_texts(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    if schema.get("type") != "number":
        return {key: _with_texts(value) for key, value in schema.items()}
    outer = {key: value for key, value in schema.items() if key in ("title", "default", "description")}
    inner = {key: value for key, value in schema.items() if key not in outer}
    return outer | {"anyOf": [inner, {"type": "string", "pattern": f"^{QUANTITY.pattern}$"}]}

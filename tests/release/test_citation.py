"""`CITATION.cff` keeps the rules of the Citation File Format 1.2.0 (its schema guide), and names this version."""

import copy
import re
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import yaml

import expdesign as xd

FILE = Path(__file__).parents[2] / "CITATION.cff"

TEXT = {"type": "string", "minLength": 1}
DATE = {"type": "string", "pattern": r"^\d{4}-(0[1-9]|1[0-2])-(0[1-9]|[12]\d|3[01])$"}
POSTAL = {"type": ["string", "number"]}
CONTACT = ["address", "alias", "city", "country", "email", "fax", "orcid", "region", "tel", "website"]
NAMES = ["affiliation", "family-names", "given-names", "name-particle", "name-suffix"]
ENTITY = {
    "type": "object",
    "additionalProperties": False,
    "required": ["name"],
    "properties": dict.fromkeys([*CONTACT, "location", "name"], TEXT)
    | {"date-start": DATE, "date-end": DATE, "post-code": POSTAL},
}
PERSON = {
    "type": "object",
    "additionalProperties": False,
    "anyOf": [{"required": ["family-names"]}, {"required": ["given-names"]}, {"required": ["alias"]}],
    "properties": dict.fromkeys([*CONTACT, *NAMES], TEXT) | {"post-code": POSTAL},
}
PEOPLE = {"type": "array", "minItems": 1, "uniqueItems": True, "items": {"oneOf": [PERSON, ENTITY]}}
KEYWORDS = {"type": "array", "minItems": 1, "uniqueItems": True, "items": TEXT}
IDENTIFIERS = {
    "type": "array",
    "minItems": 1,
    "items": {
        "type": "object",
        "additionalProperties": False,
        "required": ["type", "value"],
        "properties": {"type": {"enum": ["doi", "url", "swh", "other"]}, "value": TEXT, "description": TEXT},
    },
}
REFERENCE = {
    "type": "object",
    "required": ["authors", "title", "type"],
    "additionalProperties": False,
    "properties": {
        "authors": PEOPLE,
        "title": TEXT,
        "type": {
            "enum": ["article", "book", "conference-paper", "report", "software", "standard", "thesis", "generic"]
        },
        "thesis-type": TEXT,
        "institution": ENTITY,
        "year": {"type": ["integer", "string"]},
        "identifiers": IDENTIFIERS,
        "doi": {"type": "string", "pattern": r"^10\.\d{4,9}(\.\d+)?/[A-Za-z0-9:/_;\-\.\(\)\[\]\\]+$"},
        "url": {"type": "string", "pattern": r"^(https|http|ftp|sftp)://.+"},
        "notes": TEXT,
    },
}
"""The keys of references that are of use here; the format knows more."""
RULES: dict[str, Any] = {
    "type": "object",
    "required": ["authors", "cff-version", "message", "title"],
    "additionalProperties": False,
    "properties": {
        "abstract": TEXT,
        "authors": PEOPLE,
        "cff-version": {"const": "1.2.0"},
        "commit": TEXT,
        "contact": PEOPLE,
        "date-released": DATE,
        "doi": REFERENCE["properties"]["doi"],  # type: ignore[index]
        "identifiers": IDENTIFIERS,
        "keywords": KEYWORDS,
        "license": TEXT,
        "message": TEXT,
        "preferred-citation": REFERENCE,
        "references": {"type": "array", "minItems": 1, "uniqueItems": True, "items": REFERENCE},
        "repository-code": REFERENCE["properties"]["url"],  # type: ignore[index]
        "title": TEXT,
        "type": {"enum": ["dataset", "software"]},
        "url": REFERENCE["properties"]["url"],  # type: ignore[index]
        "version": {"type": ["string", "number"]},
    },
}


def content() -> dict[str, Any]:
    found = yaml.safe_load(FILE.read_text(encoding="utf-8"))
    assert isinstance(found, dict)
    return found


def test_the_file_keeps_the_rules() -> None:
    jsonschema.validate(content(), RULES, cls=jsonschema.Draft7Validator)


def test_it_names_this_version() -> None:
    assert content()["version"] == xd.__version__
    assert re.fullmatch(r"\d+\.\d+\.\d+\S*", content()["version"])


WRONG = {
    "no author": {"authors": []},
    "an author that is neither a person nor an entity": {"authors": [{"name": "A", "family-names": "B"}]},
    "another version of the format": {"cff-version": "1.1.0"},
    "unknown key": {"licence": "MIT"},
    "a date that is none": {"date-released": "2026-13-01"},
    "a reference without title": {"references": [{"type": "thesis", "authors": [{"name": "A"}]}]},
}


@pytest.mark.parametrize("name", WRONG)
def test_what_breaks_the_rules_is_seen(name: str) -> None:
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(copy.deepcopy(content()) | WRONG[name], RULES, cls=jsonschema.Draft7Validator)

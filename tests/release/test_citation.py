"""`CITATION.cff` has the keys of the Citation File Format 1.2.0 (its schema guide), and names this version."""

import datetime
from pathlib import Path
from typing import Any

import yaml

import expdesign as xd

FILE = Path(__file__).parents[2] / "CITATION.cff"
REQUIRED = {"authors", "cff-version", "message", "title"}
KNOWN = REQUIRED | {
    "abstract", "commit", "contact", "date-released", "doi", "identifiers", "keywords", "license", "license-url",
    "preferred-citation", "references", "repository", "repository-artifact", "repository-code", "type", "url",
    "version",
}  # fmt: skip


def people_of(work: dict[str, Any]) -> bool:
    """Whether a work has authors, each a person or an entity."""
    return bool(work["authors"]) and all({"name", "family-names"} & set(author) for author in work["authors"])


def test_the_file_has_the_keys_of_the_format() -> None:
    content = yaml.safe_load(FILE.read_text(encoding="utf-8"))
    assert REQUIRED <= set(content) <= KNOWN
    assert content["cff-version"] == "1.2.0"
    assert content["version"] == xd.__version__
    assert people_of(content)
    for work in content.get("references", []):
        assert {"authors", "title", "type"} <= set(work)
        assert people_of(work)
    if released := content.get("date-released"):
        datetime.date.fromisoformat(str(released))

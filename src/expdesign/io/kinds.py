"""What a YAML file is, so that a file in the place of another is called by its name, and which versions are read.

A file states the version of its format as `schema_version`; a robot file may leave it out. What a release promises
about the formats is in docs/versions.md.
"""

from importlib.metadata import version as version_of
from typing import Any, Literal

from expdesign.errors import InputError
from expdesign.io.yaml_reader import YamlDocument

Kind = Literal["robot", "run configuration", "identified model", "sweep"]

_REMEDIES: dict[Kind, str] = {
    "robot": "Name a robot file (with the keys `name`, `kind`, ...); a run configuration names its own under `robot`.",
    "run configuration": "Name a file with the keys `robot`, `experiment` and `targets`.",
    "identified model": "`expdesign identify` and `expdesign diagnose` write model files (`model.yaml`).",
    "sweep": "Name a file with the key `vary`.",
}

CURRENT_VERSIONS: dict[Kind, int] = {"robot": 1, "run configuration": 1, "identified model": 2, "sweep": 1}
"""Version of each format that is written, or that templates have."""
READ_BACK = 2
"""How many versions before the current one are read as well."""


def readable_versions(kind: Kind) -> range:
    """The versions of a format that are read."""
    current = CURRENT_VERSIONS[kind]
    return range(max(1, current - READ_BACK), current + 1)


def kind_of(content: Any) -> Kind | None:
    """The kind of file that has this content, or None where that cannot be told."""
    if not isinstance(content, dict):
        return None
    if content.get("kind") == "model":
        return "identified model"
    if "vary" in content:
        return "sweep"
    if "experiment" in content or "targets" in content:
        return "run configuration"
    if {"cases", "config"} & set(content):
        return "sweep"
    return "robot" if "kind" in content or "base_joints" in content else None


def require_kind(document: YamlDocument, wanted: Kind) -> None:
    """Raise an `InputError` where a file is plainly of another kind, or in a version of its format that is not read."""
    found: str | None = kind_of(document.content)
    if not isinstance(document.content, dict):
        found = "table" if document.source.lower().endswith(".csv") else None
    if found is not None and found != wanted:
        article = {"identified model": "an"}
        what = f"this is {article.get(found, 'a')} {found}, not {article.get(wanted, 'a')} {wanted}"
        remedy = "Check the order of the files." if found == "table" else _REMEDIES[wanted]
        raise InputError(what, where=document.source, remedy=remedy)
    _require_readable(document, wanted)


def _require_readable(document: YamlDocument, kind: Kind) -> None:
    """Raise where the version is another; where there is none, or no whole number, the format's own schema says so."""
    version = document.content.get("schema_version") if isinstance(document.content, dict) else None
    read = readable_versions(kind)
    if type(version) is not int or version in read:
        return
    known = f"version {read[0]}" if len(read) == 1 else f"versions {read[0]} to {read[-1]}"
    what = f"schema version {version} is not known: expdesign {version_of('expdesign')} reads {known} of this format"
    remedy = "Correct the number."
    if version > read[-1]:
        remedy = "Install the version of expdesign that the file was made for, or a later one."
    elif version > 0:
        remedy = "Read and write it with a version of expdesign in between."
    raise document.where("schema_version").fault(what, remedy)

"""What a YAML file is, so that a file in the place of another is called by its name."""

from typing import Any, Literal

from expdesign.errors import InputError
from expdesign.files.yaml_reader import YamlDocument

Kind = Literal["robot", "run configuration", "identified model", "sweep"]

_REMEDIES: dict[Kind, str] = {
    "robot": "Name a robot file (with the keys `name`, `kind`, ...); a run configuration names its own under `robot`.",
    "run configuration": "Name a file with the keys `robot`, `experiment` and `targets`.",
    "identified model": "`expdesign identify` and `expdesign diagnose` write model files (`model.yaml`).",
    "sweep": "Name a file with the key `vary`.",
}


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
    return "robot" if "kind" in content or "base_joints" in content else None


def require_kind(document: YamlDocument, wanted: Kind) -> None:
    """Raise an `InputError` where a file is plainly of another kind than the one that is wanted."""
    found: str | None = kind_of(document.content)
    if not isinstance(document.content, dict):
        found = "table" if document.source.lower().endswith(".csv") else None
    if found is not None and found != wanted:
        article = {"identified model": "an"}
        what = f"this is {article.get(found, 'a')} {found}, not {article.get(wanted, 'a')} {wanted}"
        remedy = "Check the order of the files." if found == "table" else _REMEDIES[wanted]
        raise InputError(what, where=document.source, remedy=remedy)

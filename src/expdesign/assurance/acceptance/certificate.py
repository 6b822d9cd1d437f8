"""Texts and number of a certificate of verification."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from expdesign.errors import InputError
from expdesign.io.nearest import nearest
from expdesign.io.schema import Section, validate
from expdesign.io.yaml_reader import read_yaml


class About(Section):
    """Texts of a certificate; empty ones are left to be filled in by hand."""

    laboratory: str = ""
    robot: str = ""
    serial_number: str = ""
    load: str = ""
    weights: str = ""
    instrument: str = ""
    instrument_number: str = ""
    environment: str = ""
    operator: str = ""
    date: str = ""
    remarks: str = ""


def read_about(path: Path) -> About:
    """The texts of a YAML file.

    Raises:
        InputError: a key is unknown, or a value is no text.
    """
    document = read_yaml(path)
    if not isinstance(document.content, dict):
        raise document.where().fault(
            "a mapping (`key: value`) is needed here", f"Keys: {', '.join(About.model_fields)}."
        )
    # YAML reads 2026-03-01 as a date; on a certificate it is a text.
    texts = {key: str(value) if key == "date" else value for key, value in document.content.items()}
    return validate(About, replace(document, content=texts))


def about_of(texts: dict[str, str]) -> About:
    """The texts of a mapping.

    Raises:
        InputError: a key is unknown.
    """
    known = list(About.model_fields)
    for name in texts:
        if name not in known:
            raise InputError(f"unknown key `{name}`", where="about", remedy=nearest(name, known))
    return About(**texts)


def certificate_number(record: Mapping[str, Any]) -> str:
    """A number that follows from everything that a certificate states: twelve digits of the record's SHA-256."""
    digits = hashlib.sha256(json.dumps(record, sort_keys=True).encode()).hexdigest()[:12].upper()
    return "-".join(digits[start : start + 4] for start in (0, 4, 8))

"""Texts and number of a certificate of verification."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from expdesign.io.schema import Section, validate
from expdesign.io.yaml_reader import YamlDocument


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


def read_about(document: YamlDocument) -> About:
    """The texts of a YAML file or a mapping.

    Raises:
        InputError: a key is unknown, or a value is no text.
    """
    if not isinstance(document.content, dict):
        raise document.where().fault(
            "a mapping (`key: value`) is needed here", f"Keys: {', '.join(About.model_fields)}."
        )
    # YAML reads 2026-03-01 as a date; on a certificate it is a text.
    texts = {key: str(value) if key == "date" else value for key, value in document.content.items()}
    return validate(About, replace(document, content=texts))


def certificate_number(record: Mapping[str, Any]) -> str:
    """A number that follows from everything that a certificate states: twelve digits of the record's SHA-256."""
    digits = hashlib.sha256(json.dumps(record, sort_keys=True).encode()).hexdigest()[:12].upper()
    return "-".join(digits[start : start + 4] for start in (0, 4, 8))

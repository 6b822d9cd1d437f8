"""Texts and number of a certificate of verification."""

import hashlib
import json
from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import BeforeValidator

from expdesign.io.schema import Section


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
    date: Annotated[str, BeforeValidator(str)] = ""  # YAML reads 2026-03-01 as a date
    remarks: str = ""


def certificate_number(record: Mapping[str, Any]) -> str:
    """A number that follows from everything that a certificate states: twelve digits of the record's SHA-256."""
    digits = hashlib.sha256(json.dumps(record, sort_keys=True).encode()).hexdigest()[:12].upper()
    return "-".join(digits[start : start + 4] for start in (0, 4, 8))

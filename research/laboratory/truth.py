"""The truth file: what a laboratory hides, as YAML."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from .elements import LIBRARY, OUTSIDE, Element
from .elements.forms import FORMS
from .elements.unlisted import UNLISTED
from .errors import LaboratoryError
from .laboratory import Laboratory
from .robot import Robot, number

_KEYS = ("true_stiffness", "noise", "elements")
_NOISE_KEYS = ("std", "covariance", "shared_reference")


def laboratory_from(robot: Robot, truth: Mapping[str, Any], seed: int = 0) -> Laboratory:
    """Laboratory of a truth mapping: `true_stiffness` (N/m), `noise` and `elements`."""
    _known(truth, _KEYS, "truth")
    noise = truth.get("noise") or {}
    _known(noise, _NOISE_KEYS, "noise")
    covariance = noise.get("covariance")
    return Laboratory(
        robot,
        true_stiffness=_plain(truth.get("true_stiffness")),
        elements=[element_from(entry) for entry in truth.get("elements") or []],
        noise_std=_plain(noise.get("std")),
        covariance=None if covariance is None else np.array(_plain(covariance), dtype=float),
        shared_reference=bool(noise.get("shared_reference", False)),
        seed=seed,
    )


def read_truth(path: str | Path) -> Mapping[str, Any]:
    """Read a truth file."""
    try:
        content = yaml.safe_load(Path(path).read_text(encoding="utf-8")) or {}
    except (OSError, yaml.YAMLError) as error:
        raise LaboratoryError(f"{path}: cannot be read: {error}") from error
    if not isinstance(content, Mapping):
        raise LaboratoryError(f"{path}: a truth file is a mapping")
    return content


def element_from(entry: Mapping[str, Any]) -> Element:
    """Element of one entry: `physics` names it, the rest are its parameters."""
    catalogue = LIBRARY | OUTSIDE | UNLISTED | FORMS
    parameters = dict(entry)
    physics = parameters.pop("physics", None)
    if physics not in catalogue:
        raise LaboratoryError(f"elements: unknown physics {physics!r}; known: {', '.join(catalogue)}")
    element = catalogue[physics]
    names = [field.name for field in dataclasses.fields(element)]  # type: ignore[arg-type]
    _known(parameters, names, str(physics))
    try:
        return element(**{name: _plain(value) for name, value in parameters.items()})
    except TypeError as error:
        raise LaboratoryError(f"{physics}: {error}") from None


def _known(mapping: Mapping[str, Any], names: list[str] | tuple[str, ...], where: str) -> None:
    for key in mapping:
        if key not in names:
            raise LaboratoryError(f"{where}: unknown key {key!r}; known: {', '.join(names)}")


def _plain(value: Any) -> Any:
    """The value with numbers that YAML 1.1 read as text (`1e8`) as numbers."""
    if isinstance(value, Mapping):
        return {key: _plain(part) for key, part in value.items()}
    if isinstance(value, list):
        return [_plain(part) for part in value]
    if isinstance(value, str):
        try:
            return number(value)
        except LaboratoryError:
            return value
    return value

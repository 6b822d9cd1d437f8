"""What a robot can have beside its base model, in words: places, forms, parameters and usual sizes."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import pandas as pd

from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.models.effect_entry import Offered, unit_of_parameter
from expdesign.counted import counted
from expdesign.report.result import Result
from expdesign.report.said import Said

MOST = 3
"""Names of parameters of one size that are all listed."""


@dataclass(frozen=True, repr=False)
class PhysicsResult(Result):
    """What can be there.

    Attributes:
        robot: its name.
        offered: one entry per physics and set of parameters.
    """

    robot: str
    offered: tuple[Offered, ...]

    @property
    def said(self) -> Said:
        entries = [_entry(each) for each in self.offered]
        lines: list[str] = []
        for physics, alike in groupby(entries, lambda entry: entry["physics"]):
            for number, entry in enumerate(alike):
                lines += [*([] if number else _about(physics, entry)), *_at(entry)]
        kinds = {entry["physics"] for entry in entries}
        record = {"robot": self.robot, "physics": entries}
        return Said(f"{counted(len(kinds), 'physics', 'physics')} of {self.robot}", lines, document=lambda: record)

    @property
    def frame(self) -> pd.DataFrame:
        """One row per parameter."""
        rows = [
            {key: entry[key] for key in ("physics", "identifier", "components", "variants")} | parameter
            for entry in self.record["physics"]
            for parameter in entry["parameters"]
        ]
        return pd.DataFrame(rows)


def _about(physics: str, entry: Mapping[str, Any]) -> list[str]:
    """What a physics does, and what it depends on."""
    lines = [physics, f"  {entry['sentence']}"]
    if entry["usually"]:
        lines.append(f"  usually: {entry['usually']}")
    if entry["depends_on"]:
        depends = f"  depends on {', '.join(entry['depends_on'])}"
        lines.append(f"{depends}; beyond what was recorded it {entry['beyond_recorded']}")
    return lines


def _at(entry: Mapping[str, Any]) -> list[str]:
    """Where it can be, in which forms, with which parameters."""
    lines = [f"  at {_listed(entry['components'])}"]
    if entry["variants"] != [""]:
        lines.append(f"    forms: {', '.join(form or '(none named)' for form in entry['variants'])}")
    for size, alike in groupby(entry["parameters"], _size):
        names = [one["parameter"] for one in alike]
        many = f"{names[0]} to {names[-1]} ({len(names)} parameters)"
        lines.append(f"    {', '.join(names) if len(names) <= MOST else many}: usually {size}")
    if entry["example"]:
        lines.append(f'    --conceal "{entry["example"]}"')
    if not entry["shown_in"]:
        lines.append("    part of a calibration; no diagnosis asks for it by itself")
    elif len(entry["shown_in"]) < MOST:
        lines.append(f"    shows in {' and '.join(entry['shown_in'])} only")
    return lines


def _listed(names: list[str]) -> str:
    """`leg 1 to leg 6, all legs`."""
    numbered = [name for name in names if name[-1].isdigit()]
    others = [name for name in names if name not in numbered]
    return ", ".join(([f"{numbered[0]} to {numbered[-1]}"] if len(numbered) > 2 else numbered) + others)


def _size(one: Mapping[str, Any]) -> str:
    size = f"{one['usual']:g} × {one['multiple_of']}" if one["multiple_of"] else f"{one['usual']:g} {one['unit']}"
    return size.strip() + (f" ({one['source']})" if one["source"] else "")


def _entry(one: Offered) -> dict[str, Any]:
    effect, declared = one.effect, one.effect.declared
    return {
        "physics": one.physics,
        "identifier": effect.identifier,
        "sentence": one.sentence,
        "usually": declared.usually,
        "port": effect.port_name,
        "depends_on": [str(each) for each in declared.inputs],
        "beyond_recorded": str(effect.beyond),
        "components": [str(component) for component in one.components],
        "variants": list(one.variants),
        "parameters": [_parameter(effect, parameter) for parameter in one.parameters],
        "shown_in": [measurand.name for measurand in effect.measurands],
        "example": one.example,
    }


def _parameter(effect: Effect, parameter: Parameter) -> dict[str, Any]:
    """A parameter with its usual size, which may be a multiple of what the robot has."""
    size = effect.size(parameter)
    return {
        "parameter": parameter.name,
        "unit": unit_of_parameter(parameter.name),
        "usual": parameter.neutral if parameter.shape else size.value,
        "multiple_of": "" if parameter.shape else size.of,
        "source": "" if parameter.shape else size.source,
    }

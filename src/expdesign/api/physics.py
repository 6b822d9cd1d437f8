"""`physics`: what a robot can have beside its base model, with places, forms, parameters and usual sizes."""

from dataclasses import dataclass
from typing import Any

import pandas as pd

from expdesign.api.inputs import RobotInput, purpose_of, robot_of
from expdesign.api.result import Result
from expdesign.chain.parameter import Parameter
from expdesign.counted import counted
from expdesign.model_error.offered import Offered, offered, unit_of_parameter


@dataclass(frozen=True, repr=False)
class Physics(Result):
    """What can be there.

    Attributes:
        robot: its name.
        offered: one entry per physics and set of parameters.
    """

    robot: str
    offered: tuple[Offered, ...]

    @property
    def summary(self) -> str:
        """How many there are."""
        return f"{counted(len({each.physics for each in self.offered}), 'physics', 'physics')} of {self.robot}"

    @property
    def frame(self) -> pd.DataFrame:
        """One row per parameter."""
        rows = [
            {key: entry[key] for key in ("physics", "identifier", "components", "variants")} | parameter
            for entry in self.record["physics"]
            for parameter in entry["parameters"]
        ]
        return pd.DataFrame(rows)

    @property
    def record(self) -> dict[str, Any]:
        """The document of `physics --json`."""
        return {"robot": self.robot, "physics": [_entry(each) for each in self.offered]}


def physics(robot: RobotInput) -> Physics:
    """List the physics that a robot can have beside its base model.

    Args:
        robot: file, mapping or loaded robot.

    Raises:
        InputError: the file is missing or wrong.
    """
    machine = robot_of(robot).robot
    return Physics(machine.name, tuple(offered(machine)), purpose=purpose_of("physics", robot))


def _entry(one: Offered) -> dict[str, Any]:
    return {
        "physics": one.physics,
        "identifier": one.identifier,
        "sentence": one.sentence,
        "components": [str(component) for component in one.components],
        "variants": list(one.variants),
        "parameters": [_parameter(one, parameter) for parameter in one.parameters],
        "shown_in": [measurand.name for measurand in one.measurands],
        "example": one.example,
    }


def _parameter(one: Offered, parameter: Parameter) -> dict[str, Any]:
    """A parameter with its usual size, which may be a multiple of what the robot has."""
    size = None if parameter.shape else one.size(parameter)
    value = parameter.neutral if parameter.shape else parameter.scale if size is None else size.value
    return {
        "parameter": parameter.name,
        "unit": unit_of_parameter(parameter.name),
        "usual": value,
        "multiple_of": "" if size is None else size.of,
        "source": "" if size is None else size.source,
    }

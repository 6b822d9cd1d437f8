"""`physics`: what a robot can have beside its base model, with places, forms, parameters and usual sizes."""

from dataclasses import dataclass
from typing import Any

import pandas as pd

from expdesign.app.api.inputs import RobotInput, purpose_of, robot_of
from expdesign.app.api.result import Result
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.models.effect_entry import Offered, offered, unit_of_parameter
from expdesign.counted import counted


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


def physics(robot: RobotInput) -> PhysicsResult:
    """List the physics that a robot can have beside its base model.

    Args:
        robot: file, mapping or loaded robot.

    Raises:
        InputError: the file is missing or wrong.
    """
    machine = robot_of(robot).robot
    return PhysicsResult(machine.name, tuple(offered(machine)), purpose=purpose_of("physics", robot))


def _entry(one: Offered) -> dict[str, Any]:
    effect, declared = one.effect, one.effect.declared
    return {
        "physics": one.physics,
        "identifier": effect.identifier,
        "sentence": one.sentence,
        "usually": declared.usually,
        "port": effect.acts_at,
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

"""`physics`: what a robot can have beside its base model, with places, forms, parameters and usual sizes."""

from __future__ import annotations

from dataclasses import dataclass

import pandas as pd

from expdesign.app.api.inputs import RobotInput, load_robot, named_arguments, purpose_of
from expdesign.app.api.result import Result
from expdesign.chain.models.effect_entry import Offered, offered
from expdesign.report.physics_texts import offered_physics
from expdesign.report.said import Said


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
        return offered_physics(self.robot, self.offered)

    @property
    def frame(self) -> pd.DataFrame:
        """One row per parameter."""
        rows = [
            {key: entry[key] for key in ("physics", "identifier", "components", "variants")} | parameter
            for entry in self.record["physics"]
            for parameter in entry["parameters"]
        ]
        return pd.DataFrame(rows)


@named_arguments
def physics(robot: RobotInput) -> PhysicsResult:
    """List the physics that a robot can have: identifiers, places, forms, parameters with units and usual sizes.

    Args:
        robot: robot (YAML).

    Raises:
        InputError: the file is missing or wrong.

    Command:
        expdesign physics configs/robots/hexapod-h1.yaml
    """
    machine = load_robot(robot).robot
    return PhysicsResult(machine.name, tuple(offered(machine)), purpose=purpose_of("physics", robot))

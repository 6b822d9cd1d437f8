"""`physics`: what a robot can have beside its base model, with places, forms, parameters and usual sizes."""

from __future__ import annotations

from expdesign.app.api.arguments import named_arguments
from expdesign.app.api.inputs import RobotInput, load_robot, purpose_of
from expdesign.chain.models.effect_entry import offered
from expdesign.report.physics_texts import PhysicsResult


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

"""A robot and a run configuration as objects: what stands in YAML can be said in Python, with the same checks.

    robot = xd.Hexapod(name="mine", home=[0, 0, 0.3], base=..., platform=..., actuator_stiffness=[1e7] * 6)
    experiment = xd.Experiment(
        measurements=6,
        poses=xd.Poses(bounds={"x_m": ["-30 mm", "30 mm"]}),
        load=xd.Payload(mass_kg=26.5),
        deflection_noise=xd.DeflectionNoise(std={"dx_m": 1e-6}),
    )
    target = xd.Target(pose=[0] * 6, payload={"mass_kg": 26.5}, tolerance={"dx_m": "5 um"})
    run = xd.run(xd.Configuration(robot=robot, experiment=experiment, targets=[target]))

The keys and their meaning are those of file-formats.md. An error names the object and the key.
"""

from pathlib import Path
from typing import Any, Literal, Self

from pydantic import Field

from expdesign.io.schema import validate
from expdesign.io.yaml_reader import read_yaml
from expdesign.mechanics.robots.bipod import BipodSection
from expdesign.mechanics.robots.body import BodySection
from expdesign.mechanics.robots.hexapod import HexapodSection
from expdesign.mechanics.robots.robot import RobotSection
from expdesign.mechanics.robots.serial import SerialSection
from expdesign.planning import schema
from expdesign.report.result import PathLike

Acceptance = schema.AcceptanceSection
Budget = schema.BudgetSection
Collisions = schema.CollisionsSection
Constraints = schema.ConstraintsSection
Costs = schema.CostsSection
DeflectionNoise = schema.DeflectionNoiseSection
Experiment = schema.ExperimentSection
KeepOut = schema.KeepOutSection
LoadError = schema.LoadErrorSection
MeasuredPoints = schema.MeasuredPointsSection
ModelErrors = schema.ModelErrorsSection
Optimiser = schema.OptimiserSection
Poses = schema.PosesSection
Primitive = schema.PrimitiveSection
ReferencePose = schema.ReferencePoseSection
Target = schema.TargetSection
TargetPayload = schema.TargetPayloadSection
Tilt = schema.TiltSection


class Hexapod(HexapodSection):
    """A robot on six legs (file-formats.md, Hexapod)."""

    kind: Literal["hexapod"] = "hexapod"


class Bipod(BipodSection):
    """A robot on two legs in a plane (file-formats.md, Bipod)."""

    kind: Literal["bipod"] = "bipod"


class Arm(SerialSection):
    """A serial robot whose kinematics and masses are those of a URDF (file-formats.md, Robot files)."""

    kind: Literal["serial"] = "serial"

    @classmethod
    def from_urdf(cls, urdf: PathLike, *, base_link: str, tip_link: str | list[str], **further: Any) -> Self:
        """An arm between two links of a URDF, named as its file where no `name` is given.

        Args:
            urdf: path of the file.
            base_link: link that is fixed to the ground.
            tip_link: link whose deflection counts, or several.
            further: other keys, `actuator_stiffness` (N·m/rad or N/m for each joint) first of all.

        Raises:
            InputError: a key is missing, unknown or wrong.
        """
        content = {"name": Path(urdf).stem, "urdf": str(Path(urdf).resolve())}
        return cls(**{**content, "base_link": base_link, "tip_link": tip_link, **further})


class Body(BodySection):
    """A rigid body on a support that yields (file-formats.md, Body)."""

    kind: Literal["body"] = "body"


class Payload(schema.LoadSection):
    """A mass under gravity as the load of an experiment."""

    kind: Literal["payload"] = "payload"


class Wrench(schema.LoadSection):
    """A force and a moment that do not depend on the pose as the load of an experiment."""

    kind: Literal["wrench"] = "wrench"


class Configuration(schema.RunSection):
    """A run configuration: what `xd.run` plans."""

    schema_version: Literal[1] = 1
    robot: str | dict[str, Any] | RobotSection = Field(  # type: ignore[assignment]  # more than a file can say
        description="The robot: a file, a mapping or an object."
    )


def load_configuration(file: PathLike) -> Configuration:
    """The run configuration of a YAML file as objects; paths inside it are made absolute.

    Raises:
        InputError: the file is missing or wrong.
    """
    document = read_yaml(Path(file))
    content = validate(schema.RunSection, document).as_mapping()
    if isinstance(content["robot"], str):
        content["robot"] = str((document.folder / content["robot"]).resolve())
    poses = content["experiment"]["poses"]
    if isinstance(poses.get("candidates"), str):
        poses["candidates"] = str((document.folder / poses["candidates"]).resolve())
    return Configuration(**content)

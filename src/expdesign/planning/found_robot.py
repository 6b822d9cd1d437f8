"""A robot as identification or diagnosis found it, as the robot of a run configuration.

A plan for it identifies the compliances of the actuators anew. What else the model holds (parameters of its effects) is
taken as known exactly: their uncertainty is not in the criteria.
"""

from copy import copy
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from expdesign.chain.chain import Chain
from expdesign.chain.component import GEOMETRY
from expdesign.chain.effects.joints.geometry import ArmGeometricStiffness
from expdesign.chain.effects.legs.geometry import MAPPING, GeometricStiffness
from expdesign.chain.models.model_file import Model, model_from_document, model_of_robot
from expdesign.io.kinds import kind_of
from expdesign.io.yaml_reader import YamlDocument
from expdesign.mechanics.robots.robot import Robot
from expdesign.mechanics.robots.robot_file import robot_from_document
from expdesign.planning.linearised import KnownChain


@dataclass(frozen=True)
class FoundRobot:
    """A robot with the stiffness and the physics of a model file.

    Attributes:
        robot: with the identified stiffness of its actuators.
        physics: its chain with the identified parameters; None where the model has no effects.
        model: the model (`model_file.Model`), for what needs its history.
        identified: whether it is from a model file; else the configuration alone says what acts.
    """

    robot: Robot
    physics: KnownChain | None
    model: Model
    identified: bool = True

    @property
    def effects(self) -> tuple[str, ...]:
        """What the effects are called."""
        return tuple(effect.key for effect in self.model.chain.effects)

    @property
    def note(self) -> str:
        """What a plan for it supposes, in words."""
        if not self.effects:
            return "The robot has the stiffness of an identified model."
        whose = "is an identified model" if self.identified else "is taken"
        text = (
            f"The robot {whose} with {', '.join(self.effects)}; its maps are linearised at the planned "
            "loads and the identified parameters, of which the plan identifies the stiffnesses anew and takes the "
            "others as known."
        )
        held = [effect.key for effect in self.model.chain.effects if effect.states]
        if held:
            text += f" Every measurement is supposed to start from rest ({', '.join(held)})."
        return text

    def of(self, robot: Robot) -> "FoundRobot":
        """Another robot of the same kind with the physics that the configuration alone names."""
        return (
            replace(self, robot=robot, physics=None)
            if self.identified
            else with_geometric_stiffness(robot, None, self.model.source)
        )


def found_robot(document: YamlDocument) -> FoundRobot:
    """The robot of a model file.

    Raises:
        InputError: the file is wrong, or a stiffness in it is not positive.
    """
    model = model_from_document(document)
    chain = model.chain
    names = chain.robot.actuators
    for name, value in zip(names, model.compliance, strict=True):
        if not (np.isfinite(value) and value > 0.0):
            what = f"the compliance of {name} is {value:.3g}, and a plan needs positive ones"
            remedy = "Identify the robot from measurements that determine it, or give the robot file instead."
            raise document.where("compliance", name).fault(what, remedy)
    robot = copy(chain.robot)
    robot.stiffness = 1.0 / model.compliance
    return _found(robot, model)


def _found(robot: Robot, model: Model, *, identified: bool = True) -> FoundRobot:
    chain = model.chain
    values = np.concatenate([model.values[: chain.compliances], model.values[chain.base :]])
    return FoundRobot(robot, KnownChain(chain, values) if chain.effects else None, model, identified)


def with_geometric_stiffness(robot: Robot, found: FoundRobot | None, source: str) -> FoundRobot:
    """The robot with the change of geometry under load, for which `experiment.geometric_stiffness` stands.

    A robot on legs has the conservative mapping (theory.md 2.3). A model that has some form of this physics stays as
    it was identified.
    """
    model = model_of_robot(robot, YamlDocument(source, Path(), {})) if found is None else found.model
    effect = ArmGeometricStiffness(robot, GEOMETRY) if robot.jointed else GeometricStiffness(robot, GEOMETRY, MAPPING)
    chain = model.chain
    if any(other.slot == effect.slot for other in chain.effects):
        assert found is not None
        return found
    values = np.append(model.values, 1.0)  # mechanics itself
    longer = Chain(chain.robot, (*chain.effects, effect), reading=chain.reading)
    exact = np.pad(model.covariance, (0, 1))
    return _found(robot, replace(model, chain=longer, values=values, covariance=exact), identified=found is not None)


def robot_of(document: YamlDocument) -> tuple[Robot, FoundRobot | None]:
    """The robot of a robot file or a model file, and what it was found to be in the latter.

    Raises:
        InputError: the file is wrong.
    """
    if kind_of(document.content) == "identified model":
        found = found_robot(document)
        return found.robot, found
    return robot_from_document(document), None

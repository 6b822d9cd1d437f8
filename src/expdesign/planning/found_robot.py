"""A robot as identification or diagnosis found it, as the robot of a run configuration.

A plan for it identifies the compliances of the actuators anew. What else the model holds (parameters of its effects) is
taken as known exactly: their uncertainty is not in the criteria.
"""

from copy import copy
from dataclasses import dataclass
from typing import Any

import numpy as np

from expdesign.chain.linearised import KnownChain
from expdesign.chain.models.model_file import model_from_document
from expdesign.errors import InputError
from expdesign.io.kinds import kind_of
from expdesign.io.yaml_reader import YamlDocument
from expdesign.mechanics.robots.robot import Robot
from expdesign.mechanics.robots.robot_file import robot_from_document


@dataclass(frozen=True)
class FoundRobot:
    """A robot with the stiffness and the physics of a model file.

    Attributes:
        robot: with the identified stiffness of its actuators.
        physics: its chain with the identified parameters; None where the model has no effects.
        model: the model (`model_file.Model`), for what needs its history.
        effects: what the effects are called.
        held: effects that depend on history, which a plan supposes to start from rest.
    """

    robot: Robot
    physics: KnownChain | None
    model: Any
    effects: tuple[str, ...]
    held: tuple[str, ...]

    @property
    def note(self) -> str:
        """What a plan for it supposes, in words."""
        if not self.effects:
            return "The robot has the stiffness of an identified model."
        text = (
            f"The robot is an identified model with {', '.join(self.effects)}; its maps are linearised at the planned "
            "loads and the identified parameters, of which the plan identifies the stiffnesses anew and takes the "
            "others as known."
        )
        if self.held:
            text += f" Every measurement is supposed to start from rest ({', '.join(self.held)})."
        return text


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
            raise InputError(what, where=document.where(("compliance", name)), remedy=remedy)
    robot = copy(chain.robot)
    robot.stiffness = 1.0 / model.compliance
    values = np.concatenate([model.values[: chain.compliances], model.values[chain.base :]])
    effects = tuple(effect.key for effect in chain.effects)
    held = tuple(effect.key for effect in chain.effects if effect.states)
    return FoundRobot(robot, KnownChain(chain, values) if effects else None, model, effects, held)


def robot_of(document: YamlDocument) -> tuple[Robot, FoundRobot | None]:
    """The robot of a robot file or a model file, and what it was found to be in the latter.

    Raises:
        InputError: the file is wrong.
    """
    if kind_of(document.content) == "identified model":
        found = found_robot(document)
        return found.robot, found
    return robot_from_document(document), None

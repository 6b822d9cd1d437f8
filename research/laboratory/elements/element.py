"""What every element of physics is: parameters, and where it takes hold."""

from __future__ import annotations

from abc import ABC
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING, ClassVar

import numpy as np
import pandas as pd

from ..errors import LaboratoryError
from ..kinematics import Pose, Vector
from ..legs import Leg, LegConditions, LegLaw
from ..loads import Load
from ..robot import Robot

if TYPE_CHECKING:
    from ..machine import Machine


class Stage(IntEnum):
    """Order in which elements build: what carries others comes first."""

    BODIES = 0
    CARRIERS = 1
    JOINTS = 2
    STRUTS = 3
    SURROUNDINGS = 4


class Element(ABC):
    """One physical effect; a subclass overrides the hooks where it acts.

    `identifier` names the physics. Subclasses are frozen dataclasses whose fields are the parameters.
    """

    identifier: ClassVar[str]
    stage: ClassVar[Stage] = Stage.SURROUNDINGS

    def true_geometry(self, robot: Robot) -> Robot:
        """The robot as it was built, given the robot as it is described."""
        return robot

    def true_load(self, load: Load) -> Load:
        """The load that acts, given the load that is assumed."""
        return load

    def build(self, machine: Machine) -> None:
        """Add bodies and connectors to the machine."""
        del machine

    def leg_laws(self, legs: Sequence[Leg]) -> Mapping[int, LegLaw]:
        """Members to add to legs, by the leg's index; fresh ones at every call, since they have a memory."""
        del legs
        return {}

    def reading(self, pose: Pose) -> Pose:
        """The pose that the instrument shows, given the pose of the mount."""
        return pose

    def misread(self, deflections: Vector, rows: pd.DataFrame) -> Vector:
        """Deflections (rows x components) that an instrument zeroed at every series' start shows, before noise."""
        del rows
        return deflections

    def spoil(self, deflections: Vector, std: Vector, rng: np.random.Generator) -> Vector:
        """Recordings (rows x components) as written down, given the measured ones and their noise."""
        del std, rng
        return deflections


def legs_of(component: str, legs: int) -> list[int]:
    """Indices of the legs that a component names: `leg 3` or `all legs`."""
    if component == "all legs":
        return list(range(legs))
    kind, _, text = component.partition(" ")
    if kind != "leg" or not text.isdigit() or not 1 <= int(text) <= legs:
        raise LaboratoryError(f"component: 'leg 1' ... 'leg {legs}' or 'all legs', not {component!r}")
    return [int(text) - 1]


def require(condition: bool, message: str) -> None:
    """Refuse a parameter that makes no physical sense."""
    if not condition:
        raise LaboratoryError(message)


@dataclass(frozen=True)
class OfLegs(Element):
    """Physics of one leg or of all legs; a subclass gives the elongation, or a law with a memory."""

    component: str

    def leg_laws(self, legs: Sequence[Leg]) -> Mapping[int, LegLaw]:
        return {index: self.law(legs[index]) for index in legs_of(self.component, len(legs))}

    def law(self, leg: Leg) -> LegLaw:
        """The law of one leg; `stretch` without memory unless a subclass says otherwise."""
        return _Memoryless(self, leg)

    def stretch(self, force: float, leg: Leg, conditions: LegConditions) -> float:
        """Elongation beyond the linear spring (m) at a tension (N)."""
        raise NotImplementedError


@dataclass
class _Memoryless(LegLaw):
    physics: OfLegs
    leg: Leg

    def elongation(self, force: float, conditions: LegConditions) -> float:
        return self.physics.stretch(force, self.leg, conditions)

"""Legs that share a compliant mount."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ..engine import Point
from ..kinematics import Matrix
from .bushing import bushing_matrix
from .element import Element, Stage, require

if TYPE_CHECKING:
    from ..machine import Machine


@dataclass(frozen=True)
class LegCoupling(Element):
    """Neighbouring legs stand on one mount body, so that the force in one deflects all.

    The mount stands on the base on a bushing.

    `legs`: their numbers (1 ...). Bushing as for `BaseCompliance`, at the middle of the legs' base joints.
    """

    identifier: ClassVar[str] = "leg_coupling"
    stage: ClassVar[Stage] = Stage.CARRIERS
    legs: Sequence[int]
    stiffness: Sequence[float] | Matrix

    def build(self, machine: Machine) -> None:
        indices = [leg - 1 for leg in self.legs]
        count = len(machine.legs)
        require(len(set(indices)) >= 2, "legs: leg coupling needs two legs or more")
        require(all(0 <= index < count for index in indices), f"legs: the robot has legs 1 ... {count}")
        joints = machine.robot.base_joints
        middle = joints[indices].mean(axis=0)
        under = machine.base_ends[indices[0]].body
        carrier = machine.engine.add_body(np.zeros(3), machine.engine.ground.placement)
        machine.engine.add_bushing(Point(under, middle), Point(carrier, middle), bushing_matrix(self.stiffness))
        for index in indices:
            machine.base_ends[index] = Point(carrier, joints[index])

"""What a physical effect is, and where on the measurement chain it acts.

The chain runs from left to right,

    assumed load → actual load → actuator forces → actuator length changes → structure → pose → instrument reading,

and the base model is the chain with nothing on it but linear actuator springs: Δq = c∘(Jᵀ·F), ΔX = J̌·Δq. An effect
overrides the links at which it acts; each override takes what comes from the left and returns what goes to the right.
At the neutral values of its parameters every effect is the identity, so that base model and effect are nested and their
comparison is a test of the parameters.

To add an effect: one file in `chain/effects` with one subclass of `Effect`. Identification, prediction, compensation
and diagnosis find it there.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar, Self

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.row import Row
from expdesign.recordings.recordings import LoadedPoints
from expdesign.robots.robot import Robot


@dataclass(frozen=True)
class Parameter:
    """A parameter of an effect.

    Attributes:
        name: with its unit.
        scale: typical size, by which it is scaled in fits.
        neutral: value at which the effect vanishes (for a shape, a typical value).
        low, high: bounds.
        spread: standard deviation about `neutral` before anything is measured, infinite where nothing is known.
        shape: whether it only shapes the effect (a pitch, a time constant) and means nothing while the others are
            neutral.
    """

    name: str
    scale: float
    neutral: float = 0.0
    low: float = float("-inf")
    high: float = float("inf")
    shape: bool = False
    spread: float = float("inf")


class Effect(ABC):
    """One kind of physics at one component of a robot.

    Attributes:
        physics: identifier (file-formats.md, Identifiers of physics).
        component: e.g. `leg 3`, `payload`.
        variant: which of several forms, where there are some; empty otherwise.
        parameters: in the order of `theta` in the overrides.
        states: number of states that the effect carries from row to row of a series, all 0 at its start.
        builds_on: physics without which this effect has no meaning at its component (play, friction and creep of a
            support are ways in which it is not the spring that it is first of all); empty where there is none.
        changes_geometry: whether `geometry` or `unloaded` is overridden, which makes the kinematic maps symbolic.
    """

    physics: ClassVar[str]
    component: str
    variant: str
    parameters: tuple[Parameter, ...]
    states: int = 0
    builds_on: str = ""
    changes_geometry: bool = False

    def __init__(self, robot: Robot, component: str, variant: str = "") -> None:
        self.robot = robot
        self.component = component
        self.variant = variant
        self.parameters = self.describe()

    @abstractmethod
    def describe(self) -> tuple[Parameter, ...]:
        """The parameters of this component and variant."""

    @classmethod
    @abstractmethod
    def places(cls, robot: Robot, points: LoadedPoints) -> list[tuple[str, str]]:
        """Components and variants that these recordings could show on this robot."""

    @classmethod
    def candidates(cls, robot: Robot, points: LoadedPoints) -> list[Self]:
        """The effect at every place."""
        return [cls(robot, component, variant) for component, variant in cls.places(robot, points)]

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        """Neutral parameters with every value of the shapes from which a search has to start, shape (p,) each."""
        return [self.neutral()]

    def large_starts(self, points: LoadedPoints) -> list[FloatArray]:
        """Further starts away from neutral, where much of an effect with one parameter and states is unlike a little
        of it.
        """
        return []

    @property
    def leg(self) -> int:
        """Index of the actuator that the component names."""
        return int(self.component.split()[-1]) - 1

    @property
    def legs(self) -> tuple[int, ...]:
        """Indices of the actuators concerned: one, or all."""
        return tuple(range(len(self.robot.stiffness))) if self.component.startswith("all") else (self.leg,)

    @property
    def slot(self) -> tuple[str, str]:
        """What a model holds at most once: forms of one physics at one component exclude each other."""
        return self.physics, self.component

    @property
    def key(self) -> str:
        """Identifier of physics, component and variant."""
        return f"{self.physics} / {self.component}" + (f" / {self.variant}" if self.variant else "")

    def geometry(self, geometry: ca.SX, theta: ca.SX) -> ca.SX:
        """True joint coordinates, from the nominal ones."""
        return geometry

    def unloaded(self, pose: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        """True pose of the unloaded platform, from the one that geometry alone leads to."""
        return pose

    def own_weight_change(self, row: Row, theta: ca.SX) -> ca.SX:
        """Actual minus assumed actuator forces by the robot's own weight (n_p,)."""
        return ca.SX.zeros(row.own.shape[0])

    def load(self, wrench: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        """Actual wrench (n,), from the assumed one."""
        return wrench

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        """Length changes of the actuators (n_p,) and the effect's next states, from those so far.

        Args:
            elongation: length changes so far (n_p,), c∘τ in the base model.
            force: actuator forces τ (n_p,).
            compliance: c (n_p,).
            row: the row.
            state: the effect's states after the row before (zero at the start of a series).
            theta: parameters.
        """
        return elongation, state

    def structure(self, deflection: ca.SX, wrench: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        """Deflection of the platform (n,) in pose coordinates, from the one due to the actuators."""
        return deflection

    def structure_with_memory(
        self, deflection: ca.SX, wrench: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        """Deflection (n,) and the effect's next states, for effects of the structure that depend on history."""
        return deflection, state

    def reading(self, reading: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        """What the instrument reads (n,), from what the platform does."""
        return reading

    def reported(self, theta: ca.SX) -> dict[str, ca.SX]:
        """The parameters as people know them (names of file-formats.md, diagnosis.json), as expressions of `theta`."""
        return {parameter.name: theta[i] for i, parameter in enumerate(self.parameters)}

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        """What a technician should know, from reported values with their 95 % intervals."""
        listed = ", ".join(f"{name} = {v[0]:.3g} ({v[1]:.3g} to {v[2]:.3g})" for name, v in values.items())
        return f"{self.component}: {self.physics.replace('_', ' ')}, {listed}."

    def neutral(self) -> FloatArray:
        """Parameters at which the effect vanishes."""
        return np.array([p.neutral for p in self.parameters])

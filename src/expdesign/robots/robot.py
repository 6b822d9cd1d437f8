"""What every robot gives to the rest of the program.

A robot is one symbolic expression of its kinematics. From it follow, by differentiation, the two maps on which
all of elastostatics rests: how small changes of actuator length move the platform (J̌), and how a wrench on the
platform loads the actuators (Jᵀ). Everything to the right of this package works on these maps and does not ask
which kind of robot they came from.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, Self

import casadi as ca
import numpy as np
from pydantic import Field

from expdesign.arrays import BoolArray, FloatArray
from expdesign.coordinates import Coordinates
from expdesign.files.schema import Number, Section
from expdesign.files.yaml_reader import YamlDocument
from expdesign.robots.drawing import Drawing

#: A configuration whose scaled condition number (`Jacobians.condition`) exceeds this is treated as singular: a unit
#: error along the best direction becomes a hundred along the worst, and the linear deflection model has no meaning.
CONDITION_LIMIT = 100.0

STANDARD_GRAVITY = 9.80665
"""m/s², the magnitude that interfaces.md prescribes."""


@dataclass(frozen=True)
class Jacobians:
    """The kinematic maps at a batch of configurations (n pose coordinates, n_p actuators).

    Attributes:
        forward: J, twist of the platform per actuator speed (thesis 1.5), shape (..., n, n_p).
        pose: J̌, rate of the pose coordinates per actuator speed (thesis 1.13), shape (..., n, n_p).
        rotation: R, orientation of the platform in base axes, shape (..., d, d) with d = 2 or 3.
        condition: scaled condition number ≥ 1, `inf` where singular, shape (...).
    """

    forward: FloatArray
    pose: FloatArray
    rotation: FloatArray
    condition: FloatArray


class RobotSection(Section):
    """Keys that the files of all kinds of robots share."""

    name: str
    gravity_m_s2: list[Number] | None = None
    markers: dict[str, list[Number]] = Field(default_factory=dict)
    instrument: list[Number] | None = None


class Robot(ABC):
    """One robot: its kinematics, the approximate stiffness of its actuators, and gravity where it stands.

    Attributes:
        may_idle: whether an actuator may carry nothing however the robot is loaded, as a joint about the vertical does.
        name: for reports.
        stiffness: apK, approximate actuator stiffness (N/m or N·m/rad), shape (n_p,).
        gravity: gravity in the base frame O (m/s²), shape (d,).
        markers: known places of markers on the platform or tip (m), by name.
        instrument: known pose of the instrument that sees them in O (m, rad), shape (6,), or None.
    """

    kind: ClassVar[str]
    may_idle: ClassVar[bool] = False
    coordinates: ClassVar[Coordinates]
    configuration: tuple[str, ...]
    name: str
    stiffness: FloatArray
    gravity: FloatArray
    markers: Mapping[str, FloatArray] = MappingProxyType({})
    instrument: FloatArray | None = None

    @classmethod
    @abstractmethod
    def from_document(cls, document: YamlDocument) -> Self:
        """The robot that a robot file describes; raises `InputError`."""

    @abstractmethod
    def jacobians(self, configurations: FloatArray) -> Jacobians:
        """J, J̌, R and the scaled condition number at configurations of shape (..., n_q)."""

    @abstractmethod
    def jacobian_expressions(self, configuration: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
        """J, J̌ and R as expressions of a symbolic configuration (for exact derivatives)."""

    @abstractmethod
    def position(self, configurations: FloatArray) -> FloatArray:
        """Origin of P in O (m) at configurations (..., n_q), shape (..., d)."""

    @abstractmethod
    def limit_excess(self, configurations: FloatArray) -> FloatArray:
        """How far each configuration (..., n_q) is beyond the robot's limits (m or rad), ≤ 0 within; shape (...)."""

    @abstractmethod
    def limit_message(self, configuration: FloatArray) -> str:
        """Which limit the configuration (n_q,) is nearest to or beyond, in words."""

    def own_weight(self, configurations: FloatArray, gravity: FloatArray) -> FloatArray:
        """Actuator forces by the robot's own weight (N or N·m) at configurations (..., n_q) under gravity (..., d).

        Shape (..., n_p). Zero where the masses of its parts are not known, as those of a parallel robot.
        """
        batch = np.broadcast_shapes(configurations.shape[:-1], gravity.shape[:-1])
        return np.zeros((*batch, len(self.stiffness)))

    def weight_wrench(self, configurations: FloatArray, gravity: FloatArray) -> FloatArray:
        """Wrench of the robot's own weight about the origin of P along the axes of O (..., n); see `own_weight`."""
        batch = np.broadcast_shapes(configurations.shape[:-1], gravity.shape[:-1])
        return np.zeros((*batch, self.coordinates.n))

    def drawing(self, configurations: FloatArray) -> Drawing | None:
        """The robot at configurations of shape (..., n_q) as points and lines; None for a kind that is not drawn."""
        return None

    @property
    def effort(self) -> FloatArray | None:
        """Largest force or moment of each actuator (N or N·m), infinite where unknown, shape (n_p,); or None."""
        return None

    @property
    def compliance(self) -> FloatArray:
        """Compliances 1/apK (m/N or rad/(N·m)), shape (n_p,) (thesis 1.19)."""
        return 1.0 / self.stiffness

    @property
    def actuators(self) -> tuple[str, ...]:
        """Names of the actuators, as they appear in results."""
        return tuple(f"leg {i + 1}" for i in range(len(self.stiffness)))

    def reference_configuration(self) -> FloatArray:
        """A configuration (n_q,) at which a sound robot of this kind is regular."""
        return np.zeros(len(self.configuration))

    def usable(self, configurations: FloatArray) -> BoolArray:
        """Whether each configuration (..., n_q) is within the limits and regular; boolean, shape (...)."""
        regular = self.jacobians(configurations).condition <= CONDITION_LIMIT
        usable: BoolArray = regular & (self.limit_excess(configurations) <= 1e-12)
        return usable


def invert(matrices: FloatArray) -> FloatArray:
    """Inverses of a batch (..., n, n); NaN where a matrix is exactly singular or not finite."""
    try:
        inverse: FloatArray = np.linalg.inv(matrices)
        return inverse
    except np.linalg.LinAlgError:
        flat = matrices.reshape(-1, *matrices.shape[-2:])
        inverses = np.full_like(flat, np.nan)
        for index, matrix in enumerate(flat):
            try:
                inverses[index] = np.linalg.inv(matrix)
            except np.linalg.LinAlgError:
                continue
        return inverses.reshape(matrices.shape)

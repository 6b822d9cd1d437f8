"""What every robot gives to the rest of the program.

A robot is one symbolic expression of its kinematics. From it follow, by differentiation, the two maps on which
all of elastostatics rests: how small changes of actuator length move the platform (J̌), and how a wrench on the
platform loads the actuators (Jᵀ). Everything to the right of this package works on these maps and on what a robot
offers beside them (its capabilities), and does not ask which kind of robot they came from.

Who adds a robot derives from `ParallelRobot` where the actuator coordinates are a closed form of the pose, which then
gives all but `rotation`, `actuator_lengths`, `scaling_frame` and `from_document`. Others derive from `Robot` and give

- the attributes below that have no default, and `from_document`;
- the maps: `jacobian_expressions` for symbols, and for numbers what they are made of, `kinematics` and
  `jacobians_of`;
- where the platform is: `position` and `frame`;
- the actuators: `actuator_coordinates`, and `units` unless all of them are lengths;
- limits: `actuator_limits`, or `limits` where other coordinates have some as well;
- where the rates of pose coordinates are not the components of the twist: `pose_rates`;
- what else they have: own weight, a drawing, and the capabilities.

What a robot may offer beside its Jacobians; effects, readings and fits ask for these and never for its kind.

A robot says which capabilities it has (`Robot.on_legs`, `on_straight_legs`, `jointed`), and returns the object that has
one from the property of its name, most often itself. A new family of robots offers what it can, and gets the effects
that need no more than that. The closed form of inverse kinematics, on which most rests, is the abstract class
`ParallelRobot` itself.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar, Literal, NamedTuple, Self

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, model_validator

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.coordinates import Coordinates
from expdesign.errors import SingularConfigurationError
from expdesign.io.schema import Number, Positive, Section, invalid
from expdesign.io.yaml_reader import YamlDocument
from expdesign.mechanics.differentiation import inverse_with_adjoint
from expdesign.mechanics.robots.drawing import Drawing
from expdesign.mechanics.robots.orientation import Orientation
from expdesign.mechanics.symbolic import BatchFunction

if TYPE_CHECKING:
    from expdesign.mechanics.robots.parallel import ParallelRobot, StraightLegs
    from expdesign.mechanics.robots.serial import SerialRobot


#: A configuration whose scaled condition number (`Jacobians.condition`) exceeds this is treated as singular: a unit
#: error along the best direction becomes a hundred along the worst, and the linear deflection model has no meaning.
CONDITION_LIMIT = 100.0

LIMIT_MARGIN = 1e-9
"""m or rad beyond a limit that are the rounding of a file."""

STANDARD_GRAVITY = 9.80665
"""m/s², the standard magnitude (file-formats.md, Conventions)."""


def gravity_or_standard(gravity: ArrayLike | None, dimension: int) -> FloatArray:
    """Gravity in O (m/s²), shape (d,): the standard one, along the last axis and downwards, where none is given."""
    standard = [0.0] * (dimension - 1) + [-STANDARD_GRAVITY]
    return np.asarray(standard if gravity is None else gravity, dtype=float)


class CommandedState(NamedTuple):
    """Where a robot stands at a symbolic configuration, beside its Jacobians.

    Attributes:
        position: origin of P in O (d,), m.
        rates: T with Ẋ = T·η (n, n).
        lengths: commanded actuator lengths or angles (n_p,), m or rad.
        own: actuator forces by the robot's own weight (n_p,), 0 where the masses of its parts are not known.
    """

    position: ca.SX
    rates: ca.SX
    lengths: ca.SX
    own: ca.SX


@dataclass(frozen=True)
class Jacobians:
    """The kinematic maps at a batch of configurations (n pose coordinates, n_p actuators).

    Attributes:
        forward: J, twist of the platform per actuator speed (thesis 1.5), shape (..., n, n_p).
        pose: J̌, rate of the pose coordinates per actuator speed (thesis 1.13), shape (..., n, n_p).
        rotation: R, orientation of the platform in base axes, shape (..., d, d) with d = 2 or 3.
        condition: scaled condition number ≥ 1, `inf` where singular, shape (...); computed where it is asked for.
    """

    forward: FloatArray
    pose: FloatArray
    rotation: FloatArray
    _condition: Callable[[], FloatArray]

    @cached_property
    def condition(self) -> FloatArray:
        return self._condition()

    def require_regular(self, where: Callable[[int], str], remedy: str = "Choose another pose.") -> None:
        """Raise a `SingularConfigurationError` that names the first nearly singular configuration.

        Args:
            where: place of a configuration, by its number.
            remedy: what to do.
        """
        condition = np.ravel(self.condition)
        wrong = np.flatnonzero(condition > CONDITION_LIMIT)
        if wrong.size:
            what = f"the robot is singular or nearly so there (scaled condition number {condition[wrong[0]]:.3g})"
            raise SingularConfigurationError(what, where=where(int(wrong[0])), remedy=remedy)


class RobotSection(Section):
    """Keys that the files of all kinds of robots share.

    Attributes:
        axes: of the base frame O.
    """

    axes: ClassVar[str] = "xyz"
    name: str = Field(description="Name, for reports.")
    schema_version: Literal[1] = Field(default=1, description="Version of this format.")
    gravity_m_s2: list[Number] | None = Field(
        default=None,
        description="Gravity in O (m/s²). Default: 9.80665 m/s² along the last axis, downwards.",
    )
    markers: dict[str, list[Number]] = Field(
        default_factory=dict,
        description="Known places `[x, y, z]` of markers in P (m), by name. Default: estimated.",
    )
    instrument: list[Number] | None = Field(
        default=None,
        description="Known pose of the instrument in O, `[x, y, z, rx, ry, rz]` (m, rad), always with R = Rz·Ry·Rx, "
        "whatever `orientation` says. Default: estimated.",
    )
    geometry_std_m: Positive | None = Field(
        default=None,
        description="Standard deviation of joints and leg lengths on drawings (m): prior of a geometric calibration. "
        "Default: none.",
    )

    @model_validator(mode="after")
    def _gravity_has_every_axis(self) -> Self:
        if self.gravity_m_s2 is not None and len(self.gravity_m_s2) != len(self.axes):
            number = {2: "two", 3: "three"}[len(self.axes)]
            components = ", ".join(f"g{axis}" for axis in self.axes)
            raise invalid(f"{number} components are needed here", "gravity_m_s2", f"Write `[{components}]` in m/s².")
        return self


class Robot(ABC):
    """One robot: its kinematics, the approximate stiffness of its actuators, and gravity where it stands.

    Attributes:
        kind: the word in robot files.
        may_idle: whether an actuator may carry nothing however the robot is loaded, as a joint about the vertical does.
        on_legs: whether commands are poses, of which the actuators' coordinates are a closed form.
        on_straight_legs: whether its actuators are straight legs.
        jointed: whether commands are coordinates of joints between links.
        on_support: whether it rests on something whose yielding is physics to be found, having no actuators that yield.
        coordinates: of the workspace (n pose coordinates, d translations).
        configuration: names of the columns of a command (n_q,).
        name: for reports.
        stiffness: apK, approximate actuator stiffness (N/m or N·m/rad), shape (n_p,).
        gravity: gravity in the base frame O (m/s²), shape (d,).
        markers: known places of markers on the platform or tip (m), by name.
        instrument: known pose of the instrument that sees them in O (m, rad; `fixed-xyz`), shape (6,), or None.
        geometry_std: standard deviation with which drawings give joints and lengths of legs (m), or None.
        orientation: how the three angles of a pose make R; None where a command is no pose with three angles.
    """

    kind: ClassVar[str]
    may_idle: ClassVar[bool] = False
    on_legs: ClassVar[bool] = False
    on_straight_legs: ClassVar[bool] = False
    jointed: ClassVar[bool] = False
    on_support: ClassVar[bool] = False
    coordinates: ClassVar[Coordinates]
    configuration: tuple[str, ...]
    name: str
    stiffness: FloatArray
    gravity: FloatArray
    markers: Mapping[str, FloatArray] = MappingProxyType({})
    instrument: FloatArray | None = None
    geometry_std: float | None = None
    orientation: Orientation | None = None

    @classmethod
    @abstractmethod
    def from_document(cls, document: YamlDocument) -> Self:
        """The robot that a robot file describes; raises `InputError`."""

    @abstractmethod
    def kinematics(self, configuration: ca.SX) -> list[ca.SX]:
        """Matrices at a symbolic configuration (n_q,) from which `jacobians_of` makes the Jacobians."""

    @abstractmethod
    def jacobians_of(self, *kinematics: FloatArray) -> Jacobians:
        """J, J̌, R and the scaled condition number from values of `kinematics` with batch dimensions in front."""

    @cached_property
    def _kinematics(self) -> BatchFunction:
        configuration = ca.SX.sym("q", len(self.configuration))
        return BatchFunction("kinematics", [configuration], ca.cse(list(self.kinematics(configuration))))

    def jacobians(self, configurations: FloatArray) -> Jacobians:
        """J, J̌, R and the scaled condition number at configurations of shape (..., n_q)."""
        return self.jacobians_of(*self._kinematics(configurations))

    @abstractmethod
    def jacobian_expressions(self, configuration: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
        """J, J̌ and R as expressions of a symbolic configuration (for exact derivatives)."""

    @abstractmethod
    def position(self, configurations: FloatArray) -> FloatArray:
        """Origin of P in O (m) at configurations (..., n_q), shape (..., d)."""

    def tip_numbers(self, configurations: FloatArray) -> IntArray:
        """Which of several tips configurations (..., n_q) are of; all alike where there is one. Shape (...)."""
        return np.zeros(configurations.shape[:-1], dtype=np.int64)

    @abstractmethod
    def frame(self, configuration: ca.SX, deflection: ca.SX, geometry: ca.SX | None = None) -> tuple[ca.SX, ca.SX]:
        """Position (d,) and orientation R (d×d) in O of the platform or tip, moved by a small deflection.

        Args:
            configuration: command (n_q,).
            deflection: in pose coordinates (n,).
            geometry: errors of the geometry of `links`, or None.
        """

    @abstractmethod
    def actuator_coordinates(self, configurations: FloatArray) -> FloatArray:
        """Commanded coordinates of the actuators (m or rad) at configurations (..., n_q), shape (..., n_p)."""

    def limited(self, configurations: FloatArray) -> FloatArray:
        """Coordinates (m or rad) that `limits` are of, at configurations (..., n_q), shape (..., l)."""
        return self.actuator_coordinates(configurations)

    @property
    def limits(self) -> tuple[FloatArray, FloatArray]:
        """Least and largest `limited` coordinates, infinite without a limit, shapes (l,)."""
        return self.actuator_limits

    def _limited_by(self, index: int) -> tuple[str, str]:
        """What has a limited coordinate, in words, and its unit."""
        return f"{self.actuators[index]} would be", self.units[index]

    def limit_excess(self, configurations: FloatArray) -> FloatArray:
        """How far each configuration (..., n_q) is beyond the robot's limits (m or rad), ≤ 0 within; shape (...)."""
        low, high = self.limits
        if not np.isfinite([low, high]).any():
            return np.full(configurations.shape[:-1], -np.inf)
        at = self.limited(configurations)
        excess: FloatArray = np.maximum(low - at, at - high).max(axis=-1)
        return excess

    def limit_message(self, configuration: FloatArray) -> str:
        """Which limit the configuration (n_q,) is nearest to or beyond, in words."""
        low, high = self.limits
        if not np.isfinite([low, high]).any():
            return "the robot has no limits"
        at = self.limited(configuration)
        index = int(np.argmax(np.maximum(low - at, at - high)))
        words, unit = self._limited_by(index)
        return f"{words} at {at[index]:.6g} {unit} (limits {low[index]:.6g} to {high[index]:.6g} {unit})"

    def beyond_limits(self, configurations: FloatArray) -> tuple[IntArray, str]:
        """Which of N configurations (N, n_q) are beyond the limits by more than rounding, and the first in words."""
        rows = np.flatnonzero(self.limit_excess(configurations) > LIMIT_MARGIN)
        if not rows.size:
            return rows, ""
        more = f" (and {rows.size - 1} more)" if rows.size > 1 else ""
        return rows, f"beyond the robot's limits: {self.limit_message(configurations[rows[0]])}{more}"

    def commanded_state(self, configuration: ca.SX, gravity: ca.SX) -> CommandedState:
        """Position, rates, lengths and own weight at a symbolic configuration under gravity (d,), for robots that have
        actuators.
        """
        raise NotImplementedError

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

    def pose_rates(self, configurations: FloatArray) -> FloatArray:
        """T with Ẋ = T·η at configurations (..., n_q), shape (..., n, n); 1 where a deflection is the twist itself."""
        n = self.coordinates.n
        return np.broadcast_to(np.eye(n), (*configurations.shape[:-1], n, n))

    @property
    def inverse_kinematics(self) -> "ParallelRobot":
        """The closed form of the actuator coordinates of a pose, of a robot `on_legs`."""
        raise self._lacks("closed form of the actuators' coordinates")

    @property
    def straight_legs(self) -> "StraightLegs":
        """The directions of the legs, of a robot `on_straight_legs`."""
        raise self._lacks("straight legs")

    @property
    def links(self) -> "SerialRobot":
        """The chain of links with their masses, of a robot that is `jointed`."""
        raise self._lacks("links")

    def _lacks(self, what: str) -> NotImplementedError:
        return NotImplementedError(f"a {self.kind} has no {what}")

    def drawing(self, configurations: FloatArray) -> Drawing | None:
        """The robot at configurations of shape (..., n_q) as points and lines; None for a kind that is not drawn."""
        return None

    @property
    def actuator_limits(self) -> tuple[FloatArray, FloatArray]:
        """Least and largest coordinates of the actuators (m or rad), infinite without a limit, shapes (n_p,)."""
        unlimited = np.full(len(self.stiffness), np.inf)
        return -unlimited, unlimited

    @property
    def effort(self) -> FloatArray | None:
        """Largest force or moment of each actuator (N or N·m), infinite where unknown, shape (n_p,); or None."""
        return None

    @property
    def compliance(self) -> FloatArray:
        """Compliances 1/apK (m/N or rad/(N·m)), shape (n_p,) (thesis 1.19)."""
        return 1.0 / self.stiffness

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of each actuator's coordinate: `m` (its force in N) or `rad` (N·m), shape (n_p,)."""
        return ("m",) * len(self.stiffness)

    @property
    def actuated(self) -> bool:
        """Whether it has actuators, whose stiffness can be identified."""
        return len(self.stiffness) > 0

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


@inverse_with_adjoint
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

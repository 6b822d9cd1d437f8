"""What is calibrated: the parameters that a calibration identifies, and how each of them moves the platform.

The method asks for nothing else. With ε_X = A·π for small parameters π, the information of a measurement, the error of
an estimate and the error that it leaves after compensation follow from A alone (theory.md 3 to 5 and 9.I): the
compliances of the actuators are one choice of π, errors of the geometry another. Each regressor gives A from a few
matrices of a pose, in NumPy that can be differentiated (`differentiation.py`).
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar, Literal, get_args

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.mechanics.robots.orientation import frame_turn, twist_transfer
from expdesign.mechanics.robots.robot import Robot, invert

Calibration = Literal["elastostatic", "geometric", "both"]
"""What can be identified: compliances of the actuators, the geometry, or both."""
CALIBRATIONS: tuple[Calibration, ...] = get_args(Calibration)

TYPICAL_ERROR = 1e-4
"""m; of joints and lengths before calibration."""


@dataclass(frozen=True)
class PoseMaps:
    """What regressors are made of, with any batch dimensions in front.

    Attributes:
        pose: J̌, rate of the pose coordinates per actuator speed (thesis 1.13), shape (..., n, n_a).
        forces: τ, forces in the actuators (N or N·m), shape (..., n_a).
        further: the matrices of `Regressor.expressions` by name, shape (..., rows, columns) each.
    """

    pose: FloatArray
    forces: FloatArray
    further: dict[str, FloatArray]


class Regressor(ABC):
    """One group of parameters.

    Attributes:
        calibration: what it identifies, as configurations say it.
        noun: what its parameters are called, in the plural.
        measurement: what one measurement is called.
        needs_load: whether a measurement without load tells nothing.
        referenced: whether what is measured are deflections, counted from an unloaded reading, and not poses.
        remedy: what to do where measurements identify too little.
        redundant: how many combinations of its parameters are never identifiable (gauge freedoms). Estimates of such
            parameters do not exist, predictions of the pose may (theory.md 9.I, gauge freedoms).
    """

    calibration: Calibration
    noun: str
    measurement: str
    needs_load: bool
    referenced: ClassVar[bool] = False
    remedy: ClassVar[str] = "Measure more poses, more axes, or poses that differ more."
    redundant: int = 0

    @abstractmethod
    def names(self, robot: Robot) -> tuple[str, ...]:
        """Names of the parameters π, shape (p,)."""

    def scale(self, robot: Robot) -> FloatArray:
        """Typical size of each parameter, shape (p,): for conditioning and rank tests, of no influence on results."""
        return np.full(len(self.names(robot)), TYPICAL_ERROR)

    def nominal(self, robot: Robot) -> FloatArray:
        """Value of each parameter of the robot as its file describes it, shape (p,); 0 for errors."""
        return np.zeros(len(self.names(robot)))

    def require(self, robot: Robot) -> str | None:
        """What a robot lacks for this regressor, or None."""
        return None

    def expressions(self, robot: Robot, configuration: ca.SX) -> dict[str, ca.SX]:
        """Matrices that depend on the configuration alone, by name; none where J̌ and τ are enough."""
        return {}

    @abstractmethod
    def matrix(self, maps: PoseMaps) -> FloatArray:
        """A with ε_X = A·π in pose coordinates, shape (..., n, p)."""

    def under_load(
        self, observation: FloatArray, elastic: FloatArray, compliances: tuple[FloatArray, FloatArray]
    ) -> FloatArray:
        """A (..., n, p) of a robot that does more under load than stretch its actuators.

        What moves the platform at constant wrench moves it D'·D⁻¹ times as far, (K_C + K_G)⁻¹·K_C in the conservative
        mapping (theory.md 2.3).

        Args:
            observation: A of a robot that only stretches its actuators, shape (..., n, p).
            elastic: how the platform really moves with the compliances, shape (..., n, n_p).
            compliances: D and what it really is, D', shape (..., n, n) each.
        """
        before, after = compliances
        moved: FloatArray = after @ invert(before) @ observation
        return moved


class Elastostatic(Regressor):
    """Deflection per compliance: A = J̌·diag(JᵀΔF), N and N·rad/m (thesis 1.17, 1.18; theory.md 2.3).

    The parameters are c = 1/k (m/N or rad/(N·m)).
    """

    calibration = "elastostatic"
    noun = "stiffnesses"
    measurement = "loaded measurement"
    needs_load = True
    referenced = True
    remedy = "Measure more axes or more loads, so that every actuator carries load in some measurement."

    def names(self, robot: Robot) -> tuple[str, ...]:
        return robot.actuators

    def scale(self, robot: Robot) -> FloatArray:
        return robot.compliance

    def nominal(self, robot: Robot) -> FloatArray:
        return robot.compliance

    def matrix(self, maps: PoseMaps) -> FloatArray:
        matrix: FloatArray = maps.pose * maps.forces[..., None, :]
        return matrix

    def under_load(
        self, observation: FloatArray, elastic: FloatArray, compliances: tuple[FloatArray, FloatArray]
    ) -> FloatArray:
        return elastic


class Geometric(Regressor):
    """Pose error per error of a joint coordinate or a leg's length (1 and rad/m): A^g = J̌·[−∂q/∂g, I] (theory.md 9.I).

    The parameters are errors of every joint coordinate g in the robot file and of every leg's length. At given readings
    of the actuators q(X; g) = q + δl holds, so that δX = J̌·(δl − ∂q/∂g·δg); for a hexapod row i of the bracket is
    [u_iᵀ (base joint), −u_iᵀR (platform joint), 1 (length)], 42 parameters in all. What is measured are poses without
    load, against the commanded ones.
    """

    calibration = "geometric"
    noun = "geometric parameters"
    measurement = "pose measurement"
    needs_load = False

    def names(self, robot: Robot) -> tuple[str, ...]:
        return (*robot.inverse_kinematics.geometry_names, *(f"{name} length" for name in robot.actuators))

    def require(self, robot: Robot) -> str | None:
        return "geometric calibration needs a robot on legs" if not robot.on_legs else None

    def expressions(self, robot: Robot, configuration: ca.SX) -> dict[str, ca.SX]:
        closed_form = robot.inverse_kinematics
        geometry = ca.SX.sym("g", len(closed_form.geometry))
        rates = ca.jacobian(closed_form.actuator_lengths(configuration, geometry), geometry)
        return {"geometry": ca.substitute(rates, geometry, ca.SX(closed_form.geometry))}

    def matrix(self, maps: PoseMaps) -> FloatArray:
        return np.concatenate([-maps.pose @ maps.further["geometry"], maps.pose], axis=-1)


class Frames(Regressor):
    """Measured pose per displacement (1, rad/m) and per rotation (m, rad) of the two frames, in space.

    Where the instrument and what it looks at are, when nobody knows: twelve freedoms that measured poses cannot tell
    from the robot's own geometry (theory.md 9.I). A displacement of the instrument's frame moves every measured pose by
    one twist in base axes, one of the target on the platform by one twist in platform axes. A displacement of all base
    joints, or of all platform joints, does exactly the same: the parameters are therefore never estimable one by one,
    but the pose that the instrument will read is.
    """

    calibration = "geometric"
    noun = "placements of the frames"
    measurement = "pose measurement"
    needs_load = False
    redundant = 12

    def names(self, robot: Robot) -> tuple[str, ...]:
        parts = ("x", "y", "z", "rx", "ry", "rz")
        return tuple(f"{frame} {part}" for frame in ("instrument", "artefact") for part in parts)

    def require(self, robot: Robot) -> str | None:
        spatial = robot.on_legs and robot.coordinates.n == 6
        return None if spatial else "frames that are unknown need a robot with six pose coordinates"

    def expressions(self, robot: Robot, configuration: ca.SX) -> dict[str, ca.SX]:
        state = robot.commanded_state(configuration, ca.SX(robot.gravity))
        _, rotation = robot.frame(configuration, ca.SX.zeros(6))
        return {"frames": state.rates @ ca.horzcat(twist_transfer(state.position, 6), frame_turn(rotation, 6))}

    def matrix(self, maps: PoseMaps) -> FloatArray:
        return maps.further["frames"]


class Stacked(Regressor):
    """The parameters of several regressors, one after the other: A = [A_1 A_2 ...] (theory.md 9.I).

    Args:
        parts: at least one.
    """

    def __init__(self, parts: tuple[Regressor, ...]) -> None:
        self.parts = parts
        self.calibration = "both" if any(part.needs_load for part in parts) else "geometric"
        self.noun = "parameters"
        self.measurement = parts[-1].measurement
        self.needs_load = any(part.needs_load for part in parts)
        self.redundant = sum(part.redundant for part in parts)

    def names(self, robot: Robot) -> tuple[str, ...]:
        return tuple(name for part in self.parts for name in part.names(robot))

    def scale(self, robot: Robot) -> FloatArray:
        return np.concatenate([part.scale(robot) for part in self.parts])

    def nominal(self, robot: Robot) -> FloatArray:
        return np.concatenate([part.nominal(robot) for part in self.parts])

    def require(self, robot: Robot) -> str | None:
        return next((lack for part in self.parts if (lack := part.require(robot)) is not None), None)

    def expressions(self, robot: Robot, configuration: ca.SX) -> dict[str, ca.SX]:
        return {name: value for part in self.parts for name, value in part.expressions(robot, configuration).items()}

    def matrix(self, maps: PoseMaps) -> FloatArray:
        return np.concatenate([part.matrix(maps) for part in self.parts], axis=-1)

    def under_load(
        self, observation: FloatArray, elastic: FloatArray, compliances: tuple[FloatArray, FloatArray]
    ) -> FloatArray:
        rigid = observation.shape[-1] - elastic.shape[-1]
        if not self.needs_load:
            return super().under_load(observation, elastic, compliances)
        moved = super().under_load(observation[..., :rigid], elastic, compliances)
        return np.concatenate([moved, elastic], axis=-1)

"""The robot file: geometry of a bipod or hexapod as the engine needs it.

The laboratory works in space throughout. A planar bipod is a space mechanism in the plane z = 0 whose
tool point has no rotation; nothing ever loads it out of its plane.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self

import numpy as np
import yaml

from .errors import LaboratoryError
from .kinematics import ORIENTATIONS, Matrix, Pose, Vector, rotation_angles, rotation_matrix

STANDARD_GRAVITY = 9.80665  # m/s^2


@dataclass(frozen=True)
class Robot:
    """Geometry of a parallel robot; lengths in m, stiffness in N/m, gravity in m/s^2."""

    name: str
    kind: str
    orientation: str
    home: Vector
    base_joints: Matrix
    platform_joints: Matrix
    actuator_stiffness: Vector
    gravity: Vector

    @classmethod
    def read(cls, path: str | Path) -> Self:
        """Read a robot file (YAML)."""
        try:
            content = yaml.safe_load(Path(path).read_text(encoding="utf-8"))
        except (OSError, yaml.YAMLError) as error:
            raise LaboratoryError(f"{path}: cannot be read: {error}") from error
        if not isinstance(content, Mapping):
            raise LaboratoryError(f"{path}: a robot file is a mapping")
        try:
            return cls.from_mapping(content)
        except LaboratoryError as error:
            raise LaboratoryError(f"{path}: {error}") from error

    @classmethod
    def from_mapping(cls, content: Mapping[str, Any]) -> Self:
        """Robot from the mapping of a robot file."""
        kind = content.get("kind", "hexapod")
        if kind not in ("bipod", "hexapod"):
            raise LaboratoryError(f"kind: the laboratory has bipods and hexapods, not {kind!r}")
        legs, dimension = (2, 2) if kind == "bipod" else (6, 3)
        orientation = content.get("orientation", "fixed-xyz")
        if orientation not in ORIENTATIONS:
            raise LaboratoryError(f"orientation: must be one of {', '.join(ORIENTATIONS)}, not {orientation!r}")
        down = [0.0, -STANDARD_GRAVITY] if kind == "bipod" else [0.0, 0.0, -STANDARD_GRAVITY]
        platform = (
            content.get("platform_joints", np.zeros((2, 2))) if kind == "bipod" else content.get("platform_joints")
        )
        return cls(
            name=str(content.get("name", kind)),
            kind=kind,
            orientation=orientation,
            home=_in_space(_numbers(content.get("home"), (dimension,), "home")),
            base_joints=_in_space(_numbers(content.get("base_joints"), (legs, dimension), "base_joints")),
            platform_joints=_in_space(_numbers(platform, (legs, dimension), "platform_joints")),
            actuator_stiffness=_numbers(content.get("actuator_stiffness"), (legs,), "actuator_stiffness"),
            gravity=_in_space(_numbers(content.get("gravity_m_s2", down), (dimension,), "gravity_m_s2")),
        )

    @property
    def legs(self) -> int:
        """Number of legs."""
        return len(self.base_joints)

    @property
    def planar(self) -> bool:
        """Whether the robot is a bipod."""
        return self.kind == "bipod"

    def pose(self, coordinates: Vector) -> Pose:
        """Platform pose from pose coordinates (m, rad)."""
        if self.planar:
            return Pose(self.home + np.array([coordinates[0], coordinates[1], 0.0]), np.eye(3))
        return Pose(self.home + coordinates[:3], rotation_matrix(coordinates[3:], self.orientation))

    def coordinates(self, pose: Pose) -> Vector:
        """Pose coordinates (m, rad) of a platform pose."""
        shift = pose.position - self.home
        if self.planar:
            return shift[:2]
        return np.concatenate([shift, rotation_angles(pose.rotation, self.orientation)])

    def with_joints(self, base_joints: Matrix, platform_joints: Matrix) -> Self:
        """The same robot with its joints elsewhere."""
        return replace(self, base_joints=base_joints, platform_joints=platform_joints)


def number(value: object) -> float:
    """A number that YAML 1.1 may have read as text (`1e8`)."""
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        raise LaboratoryError(f"expected a number, not {value!r}")
    try:
        return float(value)
    except ValueError:
        raise LaboratoryError(f"expected a number, not {value!r}") from None


def _numbers(value: object, shape: tuple[int, ...], key: str) -> Vector:
    def convert(part: object) -> object:
        if isinstance(part, np.ndarray):
            return part.tolist()
        if isinstance(part, Sequence) and not isinstance(part, str):
            return [convert(each) for each in part]
        return number(part)

    if value is None:
        raise LaboratoryError(f"{key}: missing")
    try:
        array = np.array(convert(value), dtype=float)
    except (LaboratoryError, ValueError) as error:
        raise LaboratoryError(f"{key}: {error}") from None
    if array.shape != shape:
        raise LaboratoryError(f"{key}: expected shape {shape}, not {array.shape}")
    if not np.all(np.isfinite(array)):
        raise LaboratoryError(f"{key}: not finite")
    return array


def _in_space(array: Vector) -> Vector:
    missing = 3 - array.shape[-1]
    return np.concatenate([array, np.zeros((*array.shape[:-1], missing))], axis=-1)

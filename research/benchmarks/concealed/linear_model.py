"""The base model in a few lines of numpy: leg forces, observation matrix A, and what the least squares of A c leave.

Written from theory.md 2.2-3: rows of J^-1 are [u, b x u], J-check^-1 = dq/dX, dX = J-check diag(J^T F) c. The
derivative dq/dX is taken numerically, from the inverse kinematics alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from research.laboratory import Robot
from research.laboratory.kinematics import leg_lengths

Array = NDArray[np.floating[Any]]

POSE = ("x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad")
WRENCH = ("fx_N", "fy_N", "fz_N", "mx_Nm", "my_Nm", "mz_Nm")
CENTRE = ("com_x_m", "com_y_m", "com_z_m")


def pose_columns(robot: Robot) -> list[str]:
    return list(POSE[: 2 if robot.planar else 6])


def wrench_columns(robot: Robot) -> list[str]:
    return list(WRENCH[: 2 if robot.planar else 6])


def wrenches(robot: Robot, rows: pd.DataFrame) -> Array:
    """Assumed wrench of every row about the origin of P, axes of O (N, N m; rows x components)."""
    size = len(pose_columns(robot))
    if "mass_kg" not in rows:
        return rows[wrench_columns(robot)].to_numpy(dtype=float)
    found = np.zeros((len(rows), size))
    for index, (pose, mass) in enumerate(zip(_poses(robot, rows), rows["mass_kg"], strict=True)):
        force = mass * robot.gravity
        found[index, : min(size, 3)] = force[: min(size, 3)]
        if not robot.planar:
            centre = rows[list(CENTRE)].to_numpy(dtype=float)[index]
            found[index, 3:] = np.cross(robot.pose(pose).rotation @ centre, force)
    return found


@dataclass(frozen=True)
class Maps:
    """J and J-check of one pose (m and rad per m; components x legs)."""

    forward: Array
    pose: Array

    @classmethod
    def at(cls, robot: Robot, pose: Array) -> Maps:
        here = robot.pose(pose)
        arms = robot.platform_joints @ here.rotation.T
        legs = here.position + arms - robot.base_joints
        directions = legs / np.linalg.norm(legs, axis=1)[:, None]
        if robot.planar:
            inverse = np.linalg.inv(directions[:, :2])
            return cls(inverse, inverse)

        def lengths_at(coordinates: Array) -> Array:
            lengths: Array = leg_lengths(robot.base_joints, robot.platform_joints, robot.pose(coordinates))
            return lengths

        step = 1e-6 * np.eye(6)
        slope: Array = np.column_stack([(lengths_at(pose + h) - lengths_at(pose - h)) / 2e-6 for h in step])
        twist = np.hstack([directions, np.cross(arms, directions)])
        return cls(np.linalg.inv(twist), np.linalg.inv(slope))

    @property
    def condition(self) -> float:
        """Condition number of J, with rotations counted at the lever at which it is least (0.02-1 m)."""
        size = len(self.forward)
        if size == 2:
            return float(np.linalg.cond(self.forward))
        levers = np.geomspace(0.02, 1.0, 12)
        return min(float(np.linalg.cond(np.diag([1, 1, 1, r, r, r]) @ self.forward)) for r in levers)


def _poses(robot: Robot, rows: pd.DataFrame) -> Array:
    return rows[pose_columns(robot)].to_numpy(dtype=float)


def maps_of(robot: Robot, rows: pd.DataFrame) -> list[Maps]:
    """Maps of every row; rows of one pose share theirs."""
    known: dict[tuple[float, ...], Maps] = {}
    found = []
    for pose in _poses(robot, rows):
        key = tuple(pose.tolist())
        if key not in known:
            known[key] = Maps.at(robot, pose)
        found.append(known[key])
    return found


def leg_forces(robot: Robot, rows: pd.DataFrame) -> Array:
    """Tension of every leg by the base model, J^T F (N; rows x legs)."""
    each = zip(maps_of(robot, rows), wrenches(robot, rows), strict=True)
    return np.array([maps.forward.T @ wrench for maps, wrench in each])


class BaseFit:
    """Least squares of A c on the whitened measured components of the rows that may be fitted.

    `columns` are the indices of the measured components, `std` their standard deviations (m, rad), `fitted` marks the
    rows (not those of `split` test).
    """

    def __init__(self, robot: Robot, rows: pd.DataFrame, std: Array, columns: list[int], fitted: NDArray[np.bool_]):
        forces = leg_forces(robot, rows)
        matrices = [maps.pose * force for maps, force in zip(maps_of(robot, rows), forces, strict=True)]
        self._columns, self._std, self._fitted = columns, std, fitted
        stacked = np.array(matrices)[fitted][:, columns, :] / std[None, :, None]
        whitened = stacked.reshape(-1, robot.legs)
        self._basis, values, _ = np.linalg.svd(whitened, full_matrices=False)
        self.condition = float(values[0] / values[-1]) if values[-1] > 0 else np.inf
        self.dof = whitened.shape[0] - robot.legs

    def residual(self, deflections: Array) -> Array:
        """Whitened residuals (1 = one standard deviation) of deflections (rows x all components), flat."""
        whitened = (deflections[self._fitted][:, self._columns] / self._std).ravel()
        return np.asarray(whitened - self._basis @ (self._basis.T @ whitened))

    def misfit(self, deflections: Array) -> float:
        """Sum of squared whitened residuals: chi2 of noisy deflections, its expected excess of noise-free ones."""
        return float(np.sum(self.residual(deflections) ** 2))

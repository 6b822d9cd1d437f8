"""Robots of theory.md 2 and its linear model, written down once more in a few lines of numpy."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

POSE = ["x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad"]
WRENCH = ["fx_N", "fy_N", "fz_N", "mx_Nm", "my_Nm", "mz_Nm"]


def hexapod(base: float, platform: float, height: float, drop: float, stiffness: float) -> dict[str, Any]:
    """Robot mapping of the default hexapods (theory.md 2.2)."""
    angles = np.deg2rad(np.array([-10, 10, 110, 130, 230, 250]) + 90)
    tops = np.deg2rad(np.array([-50, 50, 70, 170, 190, 290]) + 90)
    return {
        "kind": "hexapod",
        "home": [0, 0, height],
        "base_joints": np.column_stack([base * np.cos(angles), base * np.sin(angles), 0 * angles]),
        "platform_joints": np.column_stack([platform * np.cos(tops), platform * np.sin(tops), 0 * tops - drop]),
        "actuator_stiffness": [stiffness] * 6,
    }


ROBOTS = {
    "H1": hexapod(0.24, 0.17, 0.30, 0.03, 5.24e6),
    "H_large": hexapod(0.36, 0.28, 0.44, 0.04, 60e6),
    "bipod": {
        "kind": "bipod",
        "home": [0.0, 0.0],
        "base_joints": [[-0.5, 0.0], [0.5, 0.0]],
        "actuator_stiffness": [1.0e7, 1.3e7],
    },
}


def rotation(angles: Any, orientation: str) -> Any:
    (cx, cy, cz), (sx, sy, sz) = np.cos(angles), np.sin(angles)
    x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return z @ y @ x if orientation == "fixed-xyz" else x @ y @ z


def euler_rates(angles: Any, orientation: str) -> Any:
    """E of theory.md 2.2: angular velocity = E x angle rates."""
    a, b, c = angles
    if orientation == "fixed-xyz":
        columns = [rotation([0, b, c], orientation)[:, 0], rotation([0, 0, c], orientation)[:, 1], [0, 0, 1]]
    else:
        columns = [[1, 0, 0], rotation([a, 0, 0], orientation)[:, 1], rotation([a, b, 0], orientation)[:, 2]]
    return np.array(columns).T


class Linear:
    """J, J-check and A c of theory.md 2.1-2.3, for a robot as the laboratory reads it."""

    def __init__(self, robot: Any, pose: Any) -> None:
        self.robot, self.pose = robot, np.asarray(pose, dtype=float)
        a = robot.base_joints
        if robot.planar:
            legs = np.append(self.pose, 0.0) + robot.home - a
            self.q = np.linalg.norm(legs, axis=1)
            self.u = (legs / self.q[:, None])[:, :2]
            self.b = np.zeros((2, 3))
            self.J_inverse = self.J_check_inverse = self.u
        else:
            b = robot.platform_joints @ rotation(self.pose[3:], robot.orientation).T
            legs = self.pose[:3] + robot.home + b - a
            self.q = np.linalg.norm(legs, axis=1)
            self.u, self.b = legs / self.q[:, None], b
            arm = np.cross(b, self.u)
            self.J_inverse = np.hstack([self.u, arm])
            self.J_check_inverse = np.hstack([self.u, arm @ euler_rates(self.pose[3:], robot.orientation)])
        self.J, self.J_check = np.linalg.inv(self.J_inverse), np.linalg.inv(self.J_check_inverse)

    def tau(self, wrench: Any) -> Any:
        return self.J.T @ np.asarray(wrench, dtype=float)

    def deflection(self, wrench: Any, compliance: Any = None) -> Any:
        c = 1 / self.robot.actuator_stiffness if compliance is None else compliance
        return self.J_check @ (c * self.tau(wrench))

    def geometric_stiffness(self, wrench: Any) -> Any:
        """K_G of theory.md 2.3, in twist columns."""

        def skew(v: Any) -> Any:
            return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])

        if self.robot.planar:
            each = zip(self.tau(wrench), self.u, self.q, strict=True)
            return sum(t * (np.eye(2) - np.outer(u, u)) / q for t, u, q in each)
        total = np.zeros((6, 6))
        for t, u, b, q in zip(self.tau(wrench), self.u, self.b, self.q, strict=True):
            p, s = (np.eye(3) - np.outer(u, u)) / q, skew(b)
            total += t * np.block([[p, -p @ s], [s @ p, -s @ p @ s + skew(u) @ s]])
        return total


def frame(poses: Any, **columns: Any) -> pd.DataFrame:
    """Rows of poses and further columns; every row is a series of its own unless `series` is given."""
    poses = np.atleast_2d(poses)
    rows = pd.DataFrame(poses, columns=POSE[: poses.shape[1]])
    for name, values in columns.items():
        rows[name] = values
    if "series" not in rows:
        rows["series"] = range(len(rows))
    return rows


def wrenches(values: Any) -> dict[str, Any]:
    """Wrench columns for `frame`; the same wrench for all rows, or one per row."""
    values = np.atleast_2d(values)
    return {name: values[:, i] if len(values) > 1 else values[0, i] for i, name in enumerate(WRENCH[: values.shape[1]])}


@pytest.fixture
def bench() -> SimpleNamespace:
    """What the tests need: robots, the linear model, frames of rows, and measuring without noise."""
    from virtual_laboratory import Laboratory, Robot  # noqa: PLC0415 - the engine may be missing

    def robot(name: str, **changes: Any) -> Any:
        return Robot.from_mapping(ROBOTS[name] | changes)

    def measure(machine: Any, rows: pd.DataFrame, *elements: Any, **options: Any) -> Any:
        measured = Laboratory(machine, elements=elements, **options).measure(rows)
        return measured[[f"d{name}" for name in POSE if f"d{name}" in measured]].to_numpy()

    return SimpleNamespace(
        robot=robot,
        Linear=Linear,
        frame=frame,
        wrenches=wrenches,
        measure=measure,
        rotation=rotation,
        euler_rates=euler_rates,
    )

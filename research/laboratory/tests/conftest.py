"""Robots of the table in the laboratory, and the linear model of theory.md 2 beside it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from expdesign.mechanics.robots.bipod import Bipod
from expdesign.mechanics.robots.hexapod import Hexapod
from expdesign.mechanics.robots.parallel import ParallelRobot
from tests import cases, oracle
from tests.cases import content_of

POSE = ["x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad"]
WRENCH = ["fx_N", "fy_N", "fz_N", "mx_Nm", "my_Nm", "mz_Nm"]


class Linear:
    """J, J-check and A c of the tests' own formulas, for a robot as the laboratory reads it."""

    def __init__(self, machine: Any, pose: Any) -> None:
        if machine.planar:
            same: ParallelRobot = Bipod(
                base_joints=machine.base_joints[:, :2], home=machine.home[:2], stiffness=machine.actuator_stiffness
            )
        else:
            same = Hexapod(
                base_joints=machine.base_joints,
                platform_joints=machine.platform_joints,
                home=machine.home,
                stiffness=machine.actuator_stiffness,
                orientation=machine.orientation,
            )
        self.robot, self.pose = same, np.asarray(pose, dtype=float)
        found = oracle.kinematics(same, self.pose)
        self.q, self.u, self.J, self.J_check = found.lengths, found.directions, found.forward, found.pose
        self.J_inverse, self.J_check_inverse = np.linalg.inv(self.J), np.linalg.inv(self.J_check)

    def tau(self, wrench: Any) -> Any:
        return self.J.T @ np.asarray(wrench, dtype=float)

    def deflection(self, wrench: Any, compliance: Any = None) -> Any:
        return self.J_check @ ((self.robot.compliance if compliance is None else compliance) * self.tau(wrench))

    def geometric_stiffness(self, wrench: Any) -> Any:
        return oracle.geometric_stiffness(self.robot, self.pose, self.tau(wrench))


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
    from research.laboratory import Laboratory, Robot  # noqa: PLC0415 - the engine may be missing

    def robot(name: str, **changes: Any) -> Any:
        return Robot.from_mapping(content_of(cases.robot(name)) | changes)

    def measure(machine: Any, rows: pd.DataFrame, *elements: Any, **options: Any) -> Any:
        measured = Laboratory(machine, elements=elements, **options).measure(rows)
        return measured[[f"d{name}" for name in POSE if f"d{name}" in measured]].to_numpy()

    return SimpleNamespace(
        robot=robot,
        Linear=Linear,
        frame=frame,
        wrenches=wrenches,
        measure=measure,
        rotation=oracle.rotation,
        euler_rates=oracle.angular_velocity_map,
    )

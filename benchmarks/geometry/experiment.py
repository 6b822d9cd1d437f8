"""One experiment of a geometric calibration: what is measured, what is held out, and the best that can be done."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd
from benchmarks.geometry.machine import Array, Geometry, Machine, with_errors

from expdesign.app.api.inputs import table_of
from expdesign.chain.recordings.reader import recordings_from_table
from expdesign.chain.recordings.recordings import Recordings
from expdesign.mechanics.robots.hexapod import Hexapod
from expdesign.mechanics.robots.robot_file import read_robot

ROBOT = Path(__file__).parents[2] / "configs" / "robots" / "hexapod-h1.yaml"
REACH = np.array([0.025, 0.025, 0.015, 0.12, 0.12, 0.16])
"""m, rad: poses are drawn evenly within."""
LOADS = np.array([200.0, 200.0, 300.0, 20.0, 20.0, 20.0])
"""N, N·m: standard deviations of the components of a load."""
NOISE = np.array([5e-6, 5e-6, 5e-6, 2e-5, 2e-5, 2e-5])
"""m, rad: standard deviations of a measured pose."""
ERRORS = np.concatenate([np.full(36, 2e-4), np.full(6, 1e-4), np.full(6, 0.2)])
"""Standard deviations of the machine's 48 errors."""
POSE = ("x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad")
WRENCH = ("fx_N", "fy_N", "fz_N", "mx_Nm", "my_Nm", "mz_Nm")


@dataclass(frozen=True)
class Plan:
    """Commands (N, 6) and wrenches (N, 6)."""

    commands: Array
    wrenches: Array

    def table(self) -> pd.DataFrame:
        """The rows in recordings form, without what is measured."""
        count = len(self.commands)
        frame = pd.DataFrame({"sequence": np.arange(1, count + 1), "series": np.arange(1, count + 1), "kind": "pose"})
        frame[list(POSE)] = self.commands
        frame[list(WRENCH)] = self.wrenches
        return frame


def robot() -> Hexapod:
    """The nominal robot."""
    found = read_robot(ROBOT)
    assert isinstance(found, Hexapod)
    return found


def nominal_geometry(hexapod: Hexapod) -> Geometry:
    """Its joints."""
    return Geometry(hexapod.base_joints, hexapod.platform_joints, hexapod.home)


def paired_plan(commands: int, seed: int) -> Plan:
    """Every command once without load and once with one."""
    random = np.random.default_rng([seed, 1])
    poses = random.uniform(-REACH, REACH, (commands, 6))
    wrenches = random.normal(size=(commands, 6)) * LOADS
    return Plan(np.repeat(poses, 2, axis=0), np.stack([np.zeros_like(wrenches), wrenches], axis=1).reshape(-1, 6))


def held_out_plan(count: int, seed: int) -> Plan:
    """Loaded poses that are never fitted."""
    random = np.random.default_rng([seed, 2])
    return Plan(random.uniform(-REACH, REACH, (count, 6)), random.normal(size=(count, 6)) * LOADS)


def drawn_machine(hexapod: Hexapod, random: np.random.Generator, scale: float = 1.0) -> tuple[Machine, Array]:
    """A machine with errors of `ERRORS`, those of the geometry times `scale`, and the errors (48,)."""
    sizes = ERRORS * np.concatenate([np.full(42, scale), np.ones(6)])
    errors = sizes * np.clip(random.standard_normal(48), -3.0, 3.0)
    return with_errors(nominal_geometry(hexapod), hexapod.compliance, errors), errors


def empty_recordings(hexapod: Hexapod, plan: Plan) -> Recordings:
    """Recordings of a plan whose measured poses are the commands, to be replaced."""
    frame = plan.table()
    frame[[f"measured_{name}" for name in POSE]] = plan.commands
    frame[[f"s{name}" for name in POSE]] = np.broadcast_to(NOISE, plan.commands.shape)
    return recordings_from_table(table_of(frame, "simulated"), hexapod)


def measured(empty: Recordings, poses: Array, random: np.random.Generator) -> Recordings:
    """The recordings with measured poses: the true ones (N, 6) with noise."""
    return replace(empty, deflections=poses + NOISE * random.standard_normal(poses.shape))


def sensitivities(hexapod: Hexapod, plan: Plan, errors: Array) -> Array:
    """Derivatives of the true poses with respect to the 48 errors (N, 6, 48), by central differences."""
    nominal, compliance = nominal_geometry(hexapod), hexapod.compliance
    columns = []
    for index in range(48):
        step = np.zeros(48)
        step[index] = 1e-6 if index < 42 else 1e-3
        high, low = (with_errors(nominal, compliance, errors + sign * step) for sign in (1.0, -1.0))
        difference = high.poses(plan.commands, plan.wrenches) - low.poses(plan.commands, plan.wrenches)
        columns.append(difference / (2.0 * step[index]))
    return np.stack(columns, axis=2)


def cramer_rao(hexapod: Hexapod, fitted: Plan, held_out: Plan) -> Array:
    """Covariances of the least errors that any unbiased estimator leaves in held-out poses, shape (N, 6, 6).

    S·(HᵀV⁻¹H)⁻¹·Sᵀ with the sensitivities H of the fitted poses and S of the held-out ones, at the nominal machine.
    """
    at = np.zeros(48)
    scaled = sensitivities(hexapod, fitted, at) / NOISE[:, None] * ERRORS
    triangle = np.linalg.qr(scaled.reshape(-1, 48), mode="r")
    spread = sensitivities(hexapod, held_out, at) * ERRORS @ np.linalg.inv(triangle)
    covariance: Array = spread @ spread.swapaxes(1, 2)
    return covariance

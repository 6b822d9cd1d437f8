"""Recordings as somebody else would simulate them: plain NumPy, formulas of a textbook, nothing of the chain.

Every effect is written as its line in the table of identifiers reads, with the conventions that an author of cases
might choose: forces and length changes of the legs, row by row.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from tests import oracle

Array = NDArray[np.float64]
GRAVITY = 9.80665


def rotation(angles: Array) -> Array:
    """Rz·Ry·Rx."""
    return oracle.rotation(angles, "fixed-xyz")


@dataclass(frozen=True)
class Machine:
    """A robot's numbers: joints (legs × d), home (d,), stiffness (legs,), and what a robot file says of it."""

    document: dict[str, Any]
    base: Array
    platform: Array
    home: Array
    stiffness: Array

    @property
    def planar(self) -> bool:
        """Whether it is a bipod."""
        return len(self.home) == 2

    def vectors(self, pose: Array) -> tuple[Array, Array]:
        """Leg vectors and platform joints relative to the origin of P, along O (legs × d)."""
        if self.planar:
            return self.home + pose - self.base, np.zeros_like(self.base)
        arms = self.platform @ rotation(pose[3:]).T
        return self.home + pose[:3] + arms - self.base, arms

    def lengths(self, pose: Array) -> Array:
        """Distances between joints."""
        return np.asarray(np.linalg.norm(self.vectors(pose)[0], axis=1))

    def inverse_jacobian(self, pose: Array) -> Array:
        """Length rates per twist (legs × n)."""
        vectors, arms = self.vectors(pose)
        u = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
        return u if self.planar else np.hstack([u, np.cross(arms, u)])

    def rates(self, pose: Array) -> Array:
        """Pose rates per twist (n × n)."""
        if self.planar:
            return np.eye(2)
        (_, cy, cz), (_, sy, sz) = np.cos(pose[3:]), np.sin(pose[3:])
        turning = np.linalg.inv(np.array([[cz * cy, -sz, 0], [sz * cy, cz, 0], [-sy, 0, 1]]))
        return np.block([[np.eye(3), np.zeros((3, 3))], [np.zeros((3, 3)), turning]])


def hexapod(softness: float = 1.0) -> Machine:
    """Six legs of 5 N/µm, half a metre wide."""
    around = np.radians([80, 100, 200, 220, 320, 340])
    above = np.radians([40, 140, 160, 260, 280, 20])
    base = np.column_stack([0.24 * np.cos(around), 0.24 * np.sin(around), np.zeros(6)]).round(6)
    platform = np.column_stack([0.17 * np.cos(above), 0.17 * np.sin(above), np.full(6, -0.03)]).round(6)
    stiffness = np.array([5.5e6, 5.0e6, 5.2e6, 4.9e6, 5.6e6, 5.1e6]) / softness
    home = np.array([0.0, 0.0, 0.30])
    return _machine("hexapod", base, platform, home, stiffness, 5.2e6 / softness)


def bipod(softness: float = 1.0) -> Machine:
    """Two legs of about 10 N/µm."""
    base, home = np.array([[-0.5, 0.0], [0.5, 0.0]]), np.array([0.0, 0.7])
    stiffness = np.array([0.95e7, 1.2e7]) / softness
    return _machine("bipod", base, np.zeros_like(base), home, stiffness, 1e7 / softness)


def _machine(kind: str, base: Array, platform: Array, home: Array, stiffness: Array, approximate: float) -> Machine:
    document: dict[str, Any] = {
        "name": kind, "kind": kind, "home": home.tolist(), "base_joints": base.tolist(),
        "actuator_stiffness": [approximate] * len(base),
    }  # fmt: skip
    if kind == "hexapod":
        document["platform_joints"] = platform.tolist()
    return Machine(document, base, platform, home, stiffness)


@dataclass
class Physics:
    """What is really there. Each entry changes one step of the calculation.

    Attributes:
        load: (row, wrench) → wrench that acts.
        legs: (row, forces, elongations, memory) → elongations; memory is empty at the start of each series.
        platform: (pose, wrench) → twist that is added.
        stiffness: pose → stiffness beside that of the legs (n × n, twists).
        geometry: the machine as it really is.
        reading: (row, deflection) → what is read.
    """

    load: Callable[[pd.Series, Array], Array] = lambda row, wrench: wrench
    legs: Callable[[pd.Series, Array, Array, dict[str, Any]], Array] = lambda row, force, stretch, memory: stretch
    platform: Callable[[Array, Array], Array] = lambda pose, wrench: np.zeros_like(wrench)
    stiffness: Callable[[Array, Array], Array] | None = None
    geometry: Machine | None = None
    reading: Callable[[pd.Series, Array], Array] = lambda row, deflection: deflection
    after: Callable[[pd.DataFrame, Array], Array] = lambda rows, readings: readings
    extra: dict[str, Any] = field(default_factory=dict)


def pose_names(machine: Machine) -> list[str]:
    """Columns of the pose."""
    return ["x_m", "y_m"] if machine.planar else ["x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad"]


def wrench_names(machine: Machine) -> list[str]:
    """Columns of the wrench."""
    return ["fx_N", "fy_N"] if machine.planar else ["fx_N", "fy_N", "fz_N", "mx_Nm", "my_Nm", "mz_Nm"]


def reading_names(machine: Machine) -> list[str]:
    """Columns of the deflection."""
    return ["dx_m", "dy_m"] if machine.planar else ["dx_m", "dy_m", "dz_m", "drx_rad", "dry_rad", "drz_rad"]


def wrench_of(machine: Machine, row: pd.Series) -> Array:
    """The assumed wrench of a row."""
    if "mass_kg" not in row.index:
        return row[wrench_names(machine)].to_numpy(dtype=float)
    weight = np.array([0.0, -GRAVITY * row["mass_kg"]] if machine.planar else [0.0, 0.0, -GRAVITY * row["mass_kg"]])
    if machine.planar:
        return weight
    arm = rotation(row[["rx_rad", "ry_rad", "rz_rad"]].to_numpy(dtype=float)) @ centre_of(row)
    return np.concatenate([weight, np.cross(arm, weight)])


def centre_of(row: pd.Series) -> Array:
    """Assumed centre of mass in the platform frame."""
    return row[["com_x_m", "com_y_m", "com_z_m"]].to_numpy(dtype=float)


def true_pose(nominal: Machine, true: Machine, pose: Array) -> Array:
    """Where the nominal lengths lead with the true joints."""
    wanted, reached = nominal.lengths(pose), pose.copy()
    for _ in range(20):
        twist = np.linalg.solve(true.inverse_jacobian(reached), wanted - true.lengths(reached))
        reached = reached + true.rates(reached) @ twist
    return reached


def measure(machine: Machine, rows: pd.DataFrame, physics: Physics, deviations: Array, seed: int) -> pd.DataFrame:
    """The rows with noisy deflections and their standard deviations."""
    true = physics.geometry or machine
    readings, memory, current = [], dict[str, Any](), None
    for _, row in rows.iterrows():
        if row["series"] != current:
            memory, current = {}, row["series"]
        pose = row[pose_names(machine)].to_numpy(dtype=float)
        reached = true_pose(machine, true, pose) if physics.geometry else pose
        moved = row.copy()
        moved[pose_names(machine)] = reached
        wrench = physics.load(moved, wrench_of(machine, moved))
        inverse = true.inverse_jacobian(reached)
        force = np.linalg.solve(inverse.T, wrench)
        if physics.stiffness is None:
            stretch = physics.legs(row, force, force / machine.stiffness, memory)  # type: ignore[arg-type]
            twist = np.linalg.solve(inverse, stretch)
        else:
            whole = inverse.T @ np.diag(machine.stiffness) @ inverse + physics.stiffness(reached, force)  # type: ignore[arg-type]
            twist = np.linalg.solve(whole, wrench)
        twist = twist + physics.platform(reached, wrench)
        readings.append(physics.reading(row, true.rates(reached) @ twist))
    names = reading_names(machine)
    noisy = np.array(readings) + np.random.default_rng(seed).standard_normal((len(rows), len(names))) * deviations
    noisy = physics.after(rows, noisy)
    result = rows.copy()
    result[names] = noisy
    result[["s" + name[1:] for name in names]] = deviations
    return result


def experiment(
    machine: Machine,
    load: str = "payload",
    series: int = 16,
    path: tuple[float, ...] = (0.0, 0.5, 1.0, 0.5),
    size: float = 1.0,
    reach: float = 1.0,
    seed: int = 0,
) -> pd.DataFrame:
    """Series at random poses. A payload lies at another place in every series; a wrench has another direction."""
    generator = np.random.default_rng(seed)
    table: list[dict[str, float]] = []
    clock = 0.0
    span = np.array([0.12, 0.12]) if machine.planar else np.array([0.03, 0.03, 0.02, 0.15, 0.15, 0.2])
    for number in range(1, series + 1):
        pose = reach * span * generator.uniform(-1.0, 1.0, len(span))
        centre = np.array([*generator.uniform(-0.15, 0.15, 2), 0.12])
        lever = np.array([1.0, 1.0, 1.0, 0.12, 0.12, 0.12])
        direction = generator.uniform(-1.0, 1.0, 2 if machine.planar else 6)
        clock += generator.uniform(200.0, 600.0)
        for share in path:
            clock += generator.uniform(30.0, 90.0)
            row = {"sequence": float(len(table) + 1), "series": float(number), "time_s": clock - 200.0}
            row |= dict(zip(pose_names(machine), pose, strict=True))
            if load == "payload":
                row["mass_kg"] = size * share * (100.0 if machine.planar else 26.5)
                if not machine.planar:
                    row |= dict(zip(["com_x_m", "com_y_m", "com_z_m"], centre, strict=True))
            else:
                strength = size * share * (1000.0 if machine.planar else 300.0)
                wrench = strength * direction * (1.0 if machine.planar else lever)
                row |= dict(zip(wrench_names(machine), wrench, strict=True))
            row["temperature_degC"] = 20.0 + np.sin(clock / 3000.0) + 0.3 * generator.standard_normal()
            table.append(row)
    frame = pd.DataFrame(table)
    frame["time_s"] -= frame["time_s"].iloc[0]
    return frame.astype({"sequence": int, "series": int})

"""Campaigns as laboratories make them: series of loads at poses, times and temperatures, noise, held-out series."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from .hexapods import Array, Hexapod, posture

POSE = ("x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad")
JOINTS = tuple(f"q{joint}_rad" for joint in range(1, 7))
WRENCH = ("fx_N", "fy_N", "fz_N", "mx_Nm", "my_Nm", "mz_Nm")
PAYLOAD = ("mass_kg", "com_x_m", "com_y_m", "com_z_m")
DEFLECTION = ("dx_m", "dy_m", "dz_m", "drx_rad", "dry_rad", "drz_rad")
POSITION = ("px_m", "py_m", "pz_m")
GRAVITY = 9.80665


@dataclass(frozen=True)
class Wishes:
    """What a campaign must have so that a physics can show at all.

    `loads`: payload, wrench or any; `path`: any, stairs (up and down again) or hold (loads that stay, with times);
    `reversing`: pushes and pulls; `temperature`: the room's temperature is written down; `series`: at least so many;
    `precise`: an instrument that is four times as good, for what is a small part of the deflection.
    """

    loads: str = "any"
    path: str = "any"
    reversing: bool = False
    temperature: bool = False
    series: int = 12
    precise: bool = False


@dataclass(frozen=True)
class Campaign:
    """Rows without readings, which of them are held out, and the standard deviations of the six readings (m, rad)."""

    rows: pd.DataFrame
    held_out: NDArray[np.bool_]
    std: Array

    @property
    def payload(self) -> bool:
        """Whether loads are payloads."""
        return "mass_kg" in self.rows


def draw_campaign(hexapod: Hexapod, wishes: Wishes, rng: np.random.Generator) -> Campaign:
    """A campaign on a hexapod; 20 to 30 % of the series are held out, on lines between poses of the others."""
    count = max(wishes.series, int(rng.integers(12, 21)))
    held = max(3, round(count * rng.uniform(0.2, 0.3)))
    poses = rng.uniform(-1, 1, (count - held, 6)) * hexapod.travel
    payload = wishes.loads == "payload" or (wishes.loads == "any" and not wishes.reversing and rng.random() < 0.5)
    shares = _levels(wishes, rng)
    stock = np.array([0.45, 0.75, 1.0]) * hexapod.payload_kg
    loads = [_load(hexapod, payload, stock, rng) for _ in range(count - held)]
    series = [(pose, load, False) for pose, load in zip(poses, loads, strict=True)]
    for _ in range(held):
        one, other = rng.choice(count - held, 2, replace=False)
        pose = poses[one] + rng.uniform(0.2, 0.8) * (poses[other] - poses[one])
        series.insert(int(rng.integers(1, len(series))), (pose, loads[one], True))
    blocks, aside = [], []
    for number, (pose, load, later) in enumerate(series, start=1):
        here = shares
        if payload:  # payloads are there or not; half of the series have two of them in turn
            second = load.copy()
            second[0] = rng.choice(stock)
            steps = [load * [share > 0, 1, 1, 1] if share in (0.0, 1.0) else second for share in here]
            columns: tuple[str, ...] = PAYLOAD
        else:
            steps, columns = [share * load for share in here], WRENCH
        block = pd.DataFrame(np.tile(pose.round(5), (len(here), 1)), columns=list(POSE))
        block.insert(0, "series", number)
        block[list(columns)] = np.array(steps).round(4) + 0.0
        blocks.append(block)
        aside += [later] * len(here)
    rows = pd.concat(blocks, ignore_index=True)
    rows.insert(0, "sequence", np.arange(1, len(rows) + 1))
    if wishes.path == "hold" or wishes.temperature or rng.random() < 0.4:
        add_times(rows, wishes, rng)
    return Campaign(rows, np.array(aside), _noise(hexapod, rows, wishes.precise, rng))


def draw_arm_campaign(low: Array, high: Array, wishes: Wishes, rng: np.random.Generator) -> Campaign:
    """Loads at configurations between two ends of the joints (rad), or payloads seen by one of three markers a row.

    Payloads stand on the flange where `wishes.loads` is payload.
    """
    count = max(wishes.series, int(rng.integers(14, 23)))
    held = max(4, round(count * rng.uniform(0.2, 0.3)))
    commands = rng.uniform(low, high, (count - held, 6)).round(4)
    series = [(command, _arm_steps(wishes, rng), False) for command in commands]
    for _ in range(held):
        one, other = rng.choice(count - held, 2, replace=False)
        between = (commands[one] + rng.uniform(0.2, 0.8) * (commands[other] - commands[one])).round(4)
        series.insert(int(rng.integers(1, len(series))), (between, series[one][1], True))
    columns, blocks, aside = PAYLOAD if wishes.loads == "payload" else WRENCH, [], []
    for number, (command, loads, later) in enumerate(series, start=1):
        block = pd.DataFrame(np.tile(command, (len(loads), 1)), columns=list(JOINTS))
        block.insert(0, "series", number)
        block[list(columns)] = loads.round(4) + 0.0
        blocks.append(block)
        aside += [later] * len(loads)
    rows = pd.concat(blocks, ignore_index=True)
    rows.insert(0, "sequence", np.arange(1, len(rows) + 1))
    if wishes.path == "hold" or wishes.temperature:
        add_times(rows, wishes, rng)
    finer = 4.0 if wishes.precise else 1.0
    if wishes.loads == "payload":
        rows["marker"] = [("red", "green", "blue")[index % 3] for index in range(len(rows))]
        std = np.array([float(f"{rng.uniform(1.5e-5, 4e-5):.2g}")] * 3)
    else:
        places, angles = (float(f"{rng.uniform(*ends):.2g}") for ends in ((8e-6, 2e-5), (1.2e-5, 3.5e-5)))
        std = np.array([places] * 3 + [angles] * 3) / finer
    return Campaign(rows, np.array(aside), std)


def _arm_steps(wishes: Wishes, rng: np.random.Generator) -> Array:
    if wishes.loads == "payload":
        centre = np.array([*(0.05 * rng.normal(size=2)), rng.uniform(0.03, 0.12)])
        return np.array([[mass, *(centre if mass else 0.0 * centre)] for mass in (0.0, 2.0, 5.0)] * 2)
    levels = _levels(wishes, rng) if wishes.path != "any" else [1.0, 0.5, -0.5, -1.0]
    return np.outer(levels, rng.normal(size=6) * [24, 24, 32, 4, 4, 4])


def _levels(wishes: Wishes, rng: np.random.Generator) -> list[float]:
    """Loads of a series as shares of its largest one; the first is none where friction or time matter."""
    if wishes.path == "stairs":
        back = [0.0, 0.5, 1.0, 0.5, 0.0]
        return [*back, -0.5, -1.0, 0.0] if wishes.reversing and rng.random() < 0.6 else back
    if wishes.path == "hold":
        return [0.0, 1.0, 1.0, 1.0, 0.0, 0.0] if rng.random() < 0.5 else [0.0, 0.5, 0.5, 1.0, 1.0]
    if wishes.reversing:
        return [-1.0, -0.4, 0.15, 0.5, 1.0]
    plain = [[0.0, 0.5, 1.0], [0.5, 1.0], [0.0, 1.0, 0.5, 0.25]][int(rng.integers(3))]
    return [*plain, 1.0] if wishes.temperature else plain


def _load(hexapod: Hexapod, payload: bool, stock: Array, rng: np.random.Generator) -> Array:
    """A payload (kg, m) or a wrench (N, N m) of the machine's class."""
    lever = float(np.hypot(*hexapod.platform[0, :2]))
    if payload:
        height = np.sign(hexapod.home[2]) * lever * rng.uniform(0.3, 0.8)
        return np.array([rng.choice(stock), *(lever * rng.uniform(-0.5, 0.5, 2)), height])
    weight = hexapod.payload_kg * GRAVITY
    force = rng.normal(size=3) * [0.35, 0.35, 0.8]
    return np.concatenate([weight * force, weight * lever * rng.normal(size=3) * [0.4, 0.4, 0.25]])


def add_times(rows: pd.DataFrame, wishes: Wishes, rng: np.random.Generator) -> None:
    """Times (s) with longer pauses between series, and a room that warms, swings or is cooled at night (°C)."""
    fresh = rows["series"].diff().fillna(0).to_numpy() != 0
    steps = np.where(fresh, rng.uniform(150, 500, len(rows)), rng.uniform(20, 60, len(rows)) * rng.uniform(0.7, 1.5))
    steps[0] = 0.0
    rows["time_s"] = np.cumsum(steps).round(1)
    if wishes.temperature:
        hours, amplitude = rows["time_s"].to_numpy() / 3600, rng.uniform(1.5, 4.0)
        swing = np.sin(2 * np.pi * (hours / rng.uniform(0.15, 0.5) + rng.random()))
        drift = hours / max(float(hours[-1]), 1e-9) * rng.uniform(0, 2)
        rows["temperature_degC"] = (20.0 + amplitude * swing + drift).round(3)


def wrenches(hexapod: Hexapod, rows: pd.DataFrame) -> Array:
    """Wrench of each row on the platform (N, N m), from its wrench or its payload."""
    if "fx_N" in rows:
        return np.asarray(rows[list(WRENCH)].to_numpy(dtype=float))
    found = np.zeros((len(rows), 6))
    for index, (pose, load) in enumerate(zip(_poses(rows), rows[list(PAYLOAD)].to_numpy(dtype=float), strict=True)):
        force = np.array([0, 0, -GRAVITY * load[0]])
        found[index] = [*force, *np.cross(posture(hexapod, pose).rotation @ load[1:], force)]
    return found


def _poses(rows: pd.DataFrame) -> Array:
    return np.asarray(rows[list(POSE)].to_numpy(dtype=float))


def leg_forces(hexapod: Hexapod, rows: pd.DataFrame) -> Array:
    """Forces of the legs under the assumed loads (rows × 6, N; a leg that is pushed longer pulls: positive)."""
    found = []
    each = zip(_poses(rows), wrenches(hexapod, rows), strict=True)
    for pose, wrench in each:
        found.append(np.linalg.solve(posture(hexapod, pose).inverse_jacobian.T, wrench))
    return np.array(found)


def base_matrices(hexapod: Hexapod, rows: pd.DataFrame) -> Array:
    """The base model's observation matrices for the assumed loads (rows × 6 × 6)."""
    each = zip(_poses(rows), wrenches(hexapod, rows), strict=True)
    return np.array([posture(hexapod, pose).base_matrix(wrench) for pose, wrench in each])


def _noise(hexapod: Hexapod, rows: pd.DataFrame, precise: bool, rng: np.random.Generator) -> Array:
    """Standard deviations such that the largest deflections are 30 to 90 of them (precise: four times as many)."""
    readings = base_matrices(hexapod, rows) @ (1.0 / hexapod.stiffness)
    largest = np.abs(readings).max(axis=0)
    finer = 4.0 if precise else 1.0
    one = [max(part) / rng.uniform(30, 90) / finer for part in (largest[:3], largest[3:])]
    return np.array([float(f"{value:.2g}") for value in np.repeat(one, 3)])

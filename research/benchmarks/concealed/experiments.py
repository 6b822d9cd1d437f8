"""Experiments as laboratories make them: poses, series of loads, times, temperatures, and what is measured how well."""

from __future__ import annotations

from dataclasses import dataclass, field, fields

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from research.laboratory.recordings import deflection_columns, std_columns

from .linear_model import Array, Maps, leg_forces, pose_columns, wrench_columns
from .robots import Machine

AXES = ("x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad")


@dataclass(frozen=True)
class Wishes:
    """What an effect needs of an experiment so that it can show at all."""

    load: str = "any"  # "payload" or "wrench" where it must be one of them
    series: int = 10  # at least so many
    path: str = "any"  # "stairs": loading and unloading; "hold": loads that stay for several rows
    time: bool = False
    temperature: bool = False
    reversals: bool = False  # legs whose force changes sign
    large: bool = False  # large loads and low noise: the effect is a small fraction of the deflection
    wide: bool = False  # a wide range of poses
    positions: bool = False  # the instrument must measure positions

    def __or__(self, other: Wishes) -> Wishes:
        merged = {each.name: getattr(self, each.name) or getattr(other, each.name) for each in fields(self)}
        merged["series"] = max(self.series, other.series)
        for name in ("load", "path"):
            mine, theirs = getattr(self, name), getattr(other, name)
            merged[name] = theirs if mine == "any" else mine
        return Wishes(**merged)

    def compatible(self, other: Wishes) -> bool:
        pairs = ((self.load, other.load), (self.path, other.path))
        return all(a in ("any", b) or b == "any" for a, b in pairs)


@dataclass(frozen=True)
class Experiment:
    """Rows with assumed loads, standard deviations of all axes (m, rad), the axes that are measured, rows to be fitted.

    `later` are further series of the same experiment, which nobody but the judge sees.
    """

    machine: Machine
    rows: pd.DataFrame
    later: pd.DataFrame
    std: Array
    measured: list[int]
    fitted: NDArray[np.bool_]
    weights: Array = field(default_factory=lambda: np.zeros(0))  # kg, the payloads that there are

    @property
    def forces(self) -> Array:
        """Leg forces by the base model (N; rows x legs)."""
        return leg_forces(self.machine.robot, self.rows)

    def written(self, rows: pd.DataFrame, deflections: Array, clean: Array | None = None) -> pd.DataFrame:
        """Rows as they are written down, with the measured components only, and the true values beside those."""
        robot, table = self.machine.robot, rows.copy()
        names, stds = deflection_columns(robot), std_columns(robot)
        for axis in self.measured:
            table[names[axis]] = [float(f"{value:.6g}") for value in deflections[:, axis]]
        for axis in self.measured:
            table[stds[axis]] = self.std[axis]
        if clean is not None:
            for axis in self.measured:
                table["true_" + names[axis]] = clean[:, axis]
        return table


def draw_experiment(machine: Machine, wishes: Wishes, rng: np.random.Generator) -> Experiment:
    planar = machine.robot.planar
    lengths, count = _series_lengths(wishes, rng)
    poses = _poses(machine, len(lengths), 1.0 if wishes.wide else rng.uniform(0.5, 1.0), rng)
    payload = wishes.load == "payload" or (wishes.load == "any" and rng.random() < 0.5)
    if planar and wishes.reversals:
        payload = False  # a weight never pulls at a bipod's legs
    loads = _Payloads(machine, wishes, rng) if payload else _Wrenches(machine, wishes, rng)
    unloaded_first = rng.random() < 0.75 or wishes.time or wishes.temperature or wishes.path == "hold"
    blocks = []
    for number, (pose, length) in enumerate(zip(poses, lengths, strict=True)):
        starts_unloaded = unloaded_first or rng.random() < 0.3
        block = loads.series(length, starts_unloaded, _path(wishes, rng))
        block.insert(0, "series", number + 1)
        for column, value in zip(pose_columns(machine.robot), pose, strict=True):
            block[column] = value
        blocks.append(block)
    everything = pd.concat(blocks, ignore_index=True)
    _add_time(everything, wishes, rng)
    _add_temperature(everything, machine.robot.legs, wishes, rng)
    seen = rng.permutation(len(lengths))[:count] + 1
    chosen = everything["series"].isin(seen)
    rows, later = _numbered(everything[chosen]), _numbered(everything[~chosen])
    std, measured = _instrument(planar, wishes, rng)
    return Experiment(machine, rows, later, std, measured, _split(rows, rng), loads.weights)


def _numbered(rows: pd.DataFrame) -> pd.DataFrame:
    """Sequence and series counted from 1, time from the first row."""
    rows = rows.reset_index(drop=True)
    rows["series"] = rows["series"].rank(method="dense").astype(int)
    rows.insert(0, "sequence", np.arange(1, len(rows) + 1))
    if "time_s" in rows:
        rows["time_s"] = (rows["time_s"] - rows["time_s"].iloc[0]).round(1)
    return rows


def draw_interleaved(machine: Machine, wishes: Wishes, rng: np.random.Generator) -> Experiment:
    """An experiment of 60-150 rows; its later series lie inside the others, also in time.

    A later series repeats the path of a seen one, with loads of at most its size, at a pose on the line between the
    poses of two seen ones; it is neither the first nor the last. `sequence`, `series` and `time_s` count all rows,
    those that only the judge sees included.
    """
    planar = machine.robot.planar
    while True:
        count = int(rng.integers(max(wishes.series, 12), 31))
        low = int(rng.integers(5 if wishes.path == "hold" else 3, 7))
        lengths = rng.integers(low, min(low + 3, 8) + 1, count)
        if 60 <= lengths.sum() <= 150:
            break
    poses = _poses(machine, count, 1.0 if wishes.wide else rng.uniform(0.5, 1.0), rng)
    payload = wishes.load == "payload" or (wishes.load == "any" and rng.random() < 0.5)
    if planar and wishes.reversals:
        payload = False  # a weight never pulls at a bipod's legs
    loads = _Payloads(machine, wishes, rng) if payload else _Wrenches(machine, wishes, rng)
    seen = [loads.series(int(length), True, _path(wishes, rng)) for length in lengths]
    blocks = [(block, pose, False) for block, pose in zip(seen, poses, strict=True)]
    for _ in range(max(5, round(0.2 * count))):
        one, other = rng.choice(count, 2, replace=False)
        share = rng.uniform(0.2, 0.8)
        smaller = seen[one] * ([1.0, *[rng.uniform(0.8, 1.0)] * 3][: seen[one].shape[1]] if payload else 0.9)
        pose = (share * poses[one] + (1 - share) * poses[other]).round(5)
        blocks.insert(int(rng.integers(1, len(blocks))), (smaller.round(4), pose, True))
    for number, (block, pose, _) in enumerate(blocks, start=1):
        block.insert(0, "series", number)
        block[pose_columns(machine.robot)] = pose
    everything = pd.concat([block for block, _, _ in blocks], ignore_index=True)
    everything.insert(0, "sequence", np.arange(1, len(everything) + 1))
    _add_time(everything, wishes, rng)
    _add_temperature(everything, machine.robot.legs, wishes, rng)
    kept = everything["series"].isin([n for n, (_, _, aside) in enumerate(blocks, start=1) if aside]).to_numpy()
    rows, later = everything[~kept].reset_index(drop=True), everything[kept].reset_index(drop=True)
    std, measured = _instrument(planar, wishes, rng)
    return Experiment(machine, rows, later, std, measured, _split(rows, rng), loads.weights)


LATER_SERIES = 8


def _series_lengths(wishes: Wishes, rng: np.random.Generator) -> tuple[list[int], int]:
    """Rows of every series, those for the judge included, and how many series are for the diagnosis."""
    least = 5 if wishes.path == "hold" else 3
    while True:
        count = int(rng.integers(wishes.series, 41))
        low = int(rng.integers(least, 7))
        lengths = rng.integers(low, min(low + 3, 8) + 1, count + LATER_SERIES)
        if 68 <= lengths.sum() * count / len(lengths) <= 188:
            return [int(each) for each in lengths], count


def _poses(machine: Machine, count: int, share: float, rng: np.random.Generator) -> Array:
    found: list[Array] = []
    while len(found) < count:
        pose = share * machine.travel * rng.uniform(-1, 1, len(machine.travel))
        if Maps.at(machine.robot, pose).condition < 15:
            found.append(pose.round(5))
    return np.array(found)


def _path(wishes: Wishes, rng: np.random.Generator) -> str:
    kinds = ["stairs", "hold", "mixed"]
    if wishes.path in kinds and rng.random() < 0.85:
        return wishes.path
    return str(rng.choice(kinds, p=[0.45, 0.15, 0.4]))


def _levels(path: str, count: int, rng: np.random.Generator) -> Array:
    """Share of the largest load in every loaded row of a series."""
    if path == "hold":
        change = int(rng.integers(max(2, count - 3), count + 1))
        return np.where(np.arange(count) < change, 1.0, rng.choice([0.0, 0.4]))
    if path == "stairs":
        top = max(1, (count + 1) // 2)
        up = np.arange(1, top + 1) / top
        return np.concatenate([up, up[-2::-1], np.full(count, up[0])])[:count]
    return rng.uniform(0.25, 1.0, count)


_SHARES = ([0.2, 0.5, 1.0], [0.25, 0.5, 0.75, 1.0], [0.1, 0.3, 0.6, 1.0], [0.4, 1.0])


class _Payloads:
    """Weights that are put on, at places that may be far off the middle."""

    def __init__(self, machine: Machine, wishes: Wishes, rng: np.random.Generator) -> None:
        self._rng, self._planar = rng, machine.robot.planar
        largest = machine.weight_kg * rng.uniform(0.8, 1.2) * (1.8 if wishes.large else 1.0)
        shares = _SHARES[int(rng.integers(len(_SHARES)))]
        self.weights = np.array([float(f"{largest * share:.2g}") for share in shares])
        self._eccentric = (0.9 if wishes.reversals or rng.random() < 0.6 else 0.35) * machine.reach
        self._height = rng.uniform(0.05, 0.2) * machine.reach / 0.24

    def series(self, count: int, starts_unloaded: bool, path: str) -> pd.DataFrame:
        loaded = count - 1 if starts_unloaded else count
        levels = _levels(path, loaded, self._rng)
        masses = [0.0 if level == 0 else self._nearest(level) for level in levels]
        centre = self._centre()
        centres = [self._centre() if path == "mixed" else centre for _ in masses]
        if starts_unloaded:
            masses, centres = [0.0, *masses], [centre, *centres]
        rows = pd.DataFrame({"mass_kg": masses})
        if not self._planar:
            for axis, name in enumerate(("com_x_m", "com_y_m", "com_z_m")):
                rows[name] = [each[axis] for each in centres]
        return rows

    def _nearest(self, level: float) -> float:
        return float(self.weights[np.argmin(np.abs(self.weights - level * self.weights[-1]))])

    def _centre(self) -> Array:
        away, angle = self._eccentric * np.sqrt(self._rng.random()), self._rng.uniform(0, 2 * np.pi)
        return np.array([away * np.cos(angle), away * np.sin(angle), self._height * self._rng.uniform(0.8, 1.2)]).round(
            4
        )


class _Wrenches:
    """Forces by cords, jacks and levers, in many directions."""

    weights = np.zeros(0)

    def __init__(self, machine: Machine, wishes: Wishes, rng: np.random.Generator) -> None:
        self._rng, self._columns = rng, wrench_columns(machine.robot)
        force = machine.weight_kg * 9.81 * rng.uniform(0.5, 0.9) * (2.0 if wishes.large else 1.0)
        lever = rng.uniform(0.3, 0.8) * machine.reach
        self._size = force * np.array([1.0, 1.0, 1.3, lever, lever, lever])[: len(self._columns)]
        self._through_zero = rng.random() < 0.4

    def series(self, count: int, starts_unloaded: bool, path: str) -> pd.DataFrame:
        loaded = count - 1 if starts_unloaded else count
        levels = _levels(path, loaded, self._rng)
        direction = self._direction()
        wrenches = []
        for index, level in enumerate(levels):
            if path == "mixed":
                direction = self._direction()
            sign = -1.0 if path == "stairs" and self._through_zero and index % 2 else 1.0
            wrenches.append(sign * level * direction)
        if starts_unloaded:
            wrenches.insert(0, np.zeros(len(direction)))
        return pd.DataFrame(np.array(wrenches).round(3) + 0.0, columns=self._columns)

    def _direction(self) -> Array:
        return np.clip(self._rng.normal(0, 0.6, len(self._size)), -1.2, 1.2) * self._size


def _add_time(rows: pd.DataFrame, wishes: Wishes, rng: np.random.Generator) -> None:
    if not (wishes.time or wishes.temperature or rng.random() < 0.85):
        return
    typical = np.exp(rng.uniform(np.log(20.0), np.log(180.0)))
    steps = typical * rng.uniform(0.6, 1.6, len(rows))
    first = rows["series"].diff().fillna(1).to_numpy() != 0
    steps[first] = rng.uniform(3, 12) * typical * rng.uniform(0.7, 1.5, int(first.sum()))
    steps[0] = 0.0
    rows["time_s"] = np.cumsum(steps).round(1)


def _add_temperature(rows: pd.DataFrame, legs: int, wishes: Wishes, rng: np.random.Generator) -> None:
    if "time_s" not in rows or not (wishes.temperature or rng.random() < 0.8):
        return
    time = rows["time_s"].to_numpy()
    room = 20.0 + rng.uniform(-1, 2) + _wandering(time, rows["series"].to_numpy(), rng)
    rows["temperature_degC"] = room.round(3)
    if rng.random() < 0.3:
        for leg in range(legs):
            own = 0.4 * _wandering(time, rows["series"].to_numpy(), rng)
            rows[f"leg{leg + 1}_degC"] = (room + rng.normal(0, 0.2) + own).round(3)


def _wandering(time: Array, series: Array, rng: np.random.Generator) -> Array:
    """A temperature (K) that varies over the day, and within series with the motors, the sun and the doors."""
    day = rng.uniform(0.3, 1.5) * np.sin(2 * np.pi * time / time[-1] * rng.uniform(0.5, 2.0) + rng.uniform(0, 6))
    within = np.zeros(len(time))
    strength = rng.uniform(0.3, 1.2)
    for number in np.unique(series):
        here = series == number
        span = max(float(np.ptp(time[here])), 1.0)
        slope = strength * rng.normal()
        within[here] = slope * (time[here] - time[here][0]) / span + np.cumsum(
            0.15 * strength * rng.normal(size=here.sum())
        )
    return day + within


def _instrument(planar: bool, wishes: Wishes, rng: np.random.Generator) -> tuple[Array, list[int]]:
    position = rng.uniform(0.3, 0.45) if wishes.large else rng.uniform(0.3, 1.0)
    rotation = rng.uniform(1.0, 1.6) if wishes.large else rng.uniform(1.0, 4.0)
    std = np.array([position * 1e-6] * 3 + [rotation * 1e-6] * 3) * rng.uniform(0.85, 1.2, 6)
    std = np.array([float(f"{each:.3g}") for each in std])
    if planar:
        return std[:2], [0, 1]
    chance = rng.random()
    if chance < 0.75:
        return std, [0, 1, 2, 3, 4, 5]
    if chance < 0.85 or wishes.positions:
        return std, [0, 1, 2]
    return std, [[0, 1, 2, 3, 4], [2, 3, 4], [0, 1, 2, 5], [1, 2, 3, 5]][int(rng.integers(4))]


def _split(rows: pd.DataFrame, rng: np.random.Generator) -> NDArray[np.bool_]:
    fitted = np.ones(len(rows), dtype=bool)
    if rng.random() < 0.25:
        numbers = rows["series"].unique()
        aside = rng.permutation(numbers)[: max(2, round(0.2 * len(numbers)))]
        fitted = ~rows["series"].isin(aside).to_numpy()
        rows["split"] = np.where(fitted, "train", "test")
    return fitted


def add_bystanders(rows: pd.DataFrame, rng: np.random.Generator) -> None:
    """Now and then a further numeric column that has nothing to do with anything."""
    if rng.random() < 0.3:
        name = str(rng.choice(["humidity_percent", "air_pressure_hPa", "supply_V", "motor_current_A"]))
        start, step = {"humidity_percent": (45, 0.5), "air_pressure_hPa": (1010, 0.2)}.get(name, (24, 0.05))
        rows[name] = (start + np.cumsum(step * rng.normal(size=len(rows)))).round(2)

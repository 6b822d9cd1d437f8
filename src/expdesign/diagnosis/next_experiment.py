"""What to measure next where two explanations remain: the series on which they disagree most (T-optimality).

The design space is that of the recordings: poses within the ranges that were commanded, within the robot's limits, and
loads as they were applied, series by series, so that effects with memory are asked about loadings that a laboratory can
repeat. A series counts by dᵀ·(I + S·P·Sᵀ)⁻¹·d, d being the whitened difference of the two predictions and P the
covariance of the rival's parameters: what the rival could still adapt to does not tell the two apart.
"""

from dataclasses import replace

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray, IntArray
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.row import row_data
from expdesign.diagnosis.names import NamedModel, Names
from expdesign.mechanics.loads.load import Payload
from expdesign.mechanics.robots.robot import Robot

CANDIDATES = 200
"""Series among which the best are chosen."""


def discriminating_series(
    names: Names, model: NamedModel, rival: NamedModel, count: int, seed: int = 0
) -> pd.DataFrame:
    """The plan of `count` further series that tell a model from its rival best, in recordings form."""
    robot, recordings = names.robot, names.sample.recordings
    generator = np.random.default_rng(seed)
    chosen: list[tuple[float, Recordings]] = []
    for _ in range(CANDIDATES):
        candidate = _candidate(robot, recordings, generator)
        if candidate is not None:
            chosen.append((_separation(names, model, rival, candidate), candidate))
    chosen.sort(key=lambda item: -item[0])
    return _plan([candidate for _, candidate in chosen[:count]], robot)


def _candidate(robot: Robot, recordings: Recordings, generator: np.random.Generator) -> Recordings | None:
    """A recorded series at a new pose, or None where the robot cannot go there."""
    numbers = np.unique(recordings.series)
    rows = np.flatnonzero(recordings.series == numbers[generator.integers(len(numbers))])
    low, high = recordings.configurations.min(axis=0), recordings.configurations.max(axis=0)
    pose = low + generator.random(len(low)) * (high - low)
    if not bool(robot.usable(pose)):
        return None
    series = recordings.rows(rows)
    poses = np.tile(pose, (len(rows), 1))
    wrenches = series.wrenches
    if series.payload is not None:
        loads = np.concatenate([series.payload, series.gravity], axis=1)
        rotation = robot.jacobians(poses).rotation
        wrenches = Payload(robot.coordinates).wrenches(rotation, loads)
    absolute = series.absolute - series.wrenches + wrenches
    return replace(series, configurations=poses, wrenches=wrenches, absolute=absolute)


def _separation(names: Names, model: NamedModel, rival: NamedModel, candidate: Recordings) -> float:
    rows = row_data(candidate, names.robot)
    deviations = np.median(names.sample.whitening.deviations, axis=0)
    axes = candidate.axes
    first = model.fit.chain.predict(rows, model.fit.values)[:, axes]
    second, slopes = rival.fit.chain.predict_with_sensitivities(rows, rival.fit.values)
    difference = ((first - second[:, axes]) / deviations).ravel()
    sensitivities = (slopes[:, axes] / deviations[:, None]).reshape(len(difference), -1)
    covariance: FloatArray = np.where(np.isfinite(rival.fit.covariance), rival.fit.covariance, 0.0)
    spread = np.eye(len(difference)) + sensitivities @ covariance @ sensitivities.T
    return float(difference @ np.linalg.solve(spread, difference))


def _plan(series: list[Recordings], robot: Robot) -> pd.DataFrame:
    """Series below each other, numbered anew, without measured columns."""
    frames = []
    start = 0
    for number, part in enumerate(series, start=1):
        count: int = len(part)
        order: IntArray = np.arange(start + 1, start + count + 1)
        columns: dict[str, object] = {"sequence": order, "series": number}
        columns |= {name: part.configurations[:, i] for i, name in enumerate(robot.configuration)}
        if part.payload is not None:
            names = ("mass_kg", *robot.coordinates.centre_of_mass)
            columns |= {name: part.payload[:, i] for i, name in enumerate(names)}
        else:
            columns |= {name: part.wrenches[:, i] for i, name in enumerate(robot.coordinates.wrench)}
        if np.any(part.gravity != robot.gravity):
            columns |= {name: part.gravity[:, i] for i, name in enumerate(robot.coordinates.gravity)}
        if part.markers:
            columns["marker"] = np.array(part.markers)[part.marker]
        frames.append(pd.DataFrame(columns))
        start += count
    return pd.concat(frames, ignore_index=True)

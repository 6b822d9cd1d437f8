"""Recordings of a six-axis arm: series of payloads under which nothing stands still, and the effects that arms have."""

from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd

from expdesign.chain.chain import Chain
from expdesign.chain.effect import Effect
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.row import row_data
from expdesign.mechanics.robots.robot_file import read_robot
from expdesign.mechanics.robots.serial import SerialRobot
from tests.identification.experiments import read
from tests.oracle import Array

DEVIATIONS = (5e-6, 5e-6, 5e-6, 2e-5, 2e-5, 2e-5)
LOW = np.array([-1.0, -2.2, 0.4, -2.6, -2.2, -1.5])
HIGH = np.array([1.0, -0.5, 2.2, 0.0, -0.9, 1.5])


@cache
def six_axis() -> SerialRobot:
    """The arm of the configurations."""
    robot = read_robot(Path(__file__).parents[2] / "configs" / "robots" / "ur5.yaml")
    assert isinstance(robot, SerialRobot)
    return robot


def arm_rows(
    robot: SerialRobot, series: int = 14, loads: int = 4, seed: int = 0, *, sideways: bool = False
) -> pd.DataFrame:
    """Series of `loads` payloads each, of three weights at any place, with time and a temperature per joint.

    `sideways` tilts gravity in every row, so that joints about the vertical are loaded too.
    """
    generator = np.random.default_rng(seed)
    count, joints = series * loads, len(robot.configuration)
    low, high = (LOW, HIGH) if joints == 6 else (np.maximum(robot.low, -1.5), np.minimum(robot.high, 1.5))
    commands = np.repeat(generator.uniform(low, high, (series, joints)), loads, axis=0)
    columns: dict[str, Array] = {
        "sequence": np.arange(1, count + 1),
        "series": np.repeat(np.arange(1, series + 1), loads),
        "time_s": np.cumsum(generator.uniform(20.0, 80.0, count)),
    }
    columns |= {column: commands[:, i] for i, column in enumerate(robot.configuration)}
    columns["mass_kg"] = generator.permuted(np.resize([1.5, 3.0, 5.0], count))
    columns |= {name: generator.uniform(-0.15, 0.15, count) for name in ("com_x_m", "com_y_m")}
    columns["com_z_m"] = generator.uniform(0.02, 0.2, count)
    if sideways:
        gravity = np.array([0.0, 0.0, -9.8]) + generator.uniform(-4.0, 4.0, (count, 3))
        columns |= {name: gravity[:, i] for i, name in enumerate(("gx_m_s2", "gy_m_s2", "gz_m_s2"))}
    warm = 20.0 + 5.0 * (1.0 - np.exp(-columns["time_s"] / 800.0))
    columns |= {f"leg{i + 1}_degC": warm + generator.uniform(-2.0, 2.0, count) for i in range(joints)}
    columns |= {column: np.zeros(count) for column in robot.coordinates.deflection}
    columns |= {c: np.full(count, d) for c, d in zip(robot.coordinates.deviation, DEVIATIONS, strict=True)}
    return pd.DataFrame(columns)


def concealed(
    robot: SerialRobot, frame: pd.DataFrame, effects: tuple[Effect, ...], parameters: list[float], seed: int = 7
) -> Recordings:
    """What an arm with these effects and stiffnesses of its own would show, with noise."""
    generator = np.random.default_rng(seed)
    chain = Chain(robot, effects)
    values = chain.start()
    values[: chain.compliances] = generator.uniform(0.8, 1.2, chain.compliances)
    values[chain.compliances :] = parameters
    deflections = chain.predict(row_data(read(frame, robot), robot), values)
    deflections = deflections + generator.standard_normal(deflections.shape) * DEVIATIONS
    return read(frame.assign(**dict(zip(robot.coordinates.deflection, deflections.T, strict=True))), robot)

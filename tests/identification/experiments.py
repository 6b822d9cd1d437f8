"""Recordings of random experiments with a known truth, as tables that the reader reads."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from expdesign.chain.recordings.reader import recordings_from_table
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.recordings.references import Sharing, with_references
from expdesign.io.output import csv_text
from expdesign.io.table import Table, parse_table
from expdesign.mechanics.elastostatics.maps import observation_matrix
from expdesign.mechanics.robots.parallel import ParallelRobot
from expdesign.mechanics.robots.robot import Robot
from tests.cases import ROBOTS, robot
from tests.oracle import Array


@dataclass(frozen=True)
class Experiment:
    """Commands, loads and series of an experiment with a robot whose compliances are known."""

    robot: ParallelRobot
    poses: Array
    wrenches: Array
    series: Array
    compliance: Array
    deviation: Array

    @property
    def observation(self) -> Array:
        """A_i of every row, shape (N, n, n_p)."""
        return observation_matrix(self.robot.jacobians(self.poses), self.wrenches)

    @property
    def exact(self) -> Array:
        """Deflections without noise, shape (N, n)."""
        return self.observation @ self.compliance

    def noisy(self, generator: np.random.Generator, *, shared_reference: bool = False) -> Array:
        """Deflections with noise, half of whose variance a series shares if asked."""
        own = generator.standard_normal(self.exact.shape)
        if shared_reference:
            common = generator.standard_normal((int(self.series.max()) + 1, self.exact.shape[-1]))
            own = np.sqrt(0.5) * (own + common[self.series])
        return self.exact + own * self.deviation

    def frame(self, deflections: Array, *, stated: bool = True) -> pd.DataFrame:
        """The recordings as a table, with standard deviations if `stated`."""
        coordinates = self.robot.coordinates
        columns: dict[str, Array] = {"sequence": np.arange(1, len(self.poses) + 1), "series": self.series}
        columns |= {name: self.poses[:, i] for i, name in enumerate(coordinates.pose)}
        columns |= {name: self.wrenches[:, i] for i, name in enumerate(coordinates.wrench)}
        columns |= {name: deflections[:, i] for i, name in enumerate(coordinates.deflection)}
        if stated:
            columns |= {
                name: np.full(len(self.poses), self.deviation[i]) for i, name in enumerate(coordinates.deviation)
            }
        return pd.DataFrame(columns)

    def recordings(self, deflections: Array, *, stated: bool = True) -> Recordings:
        """The recordings as the reader gives them."""
        return read(self.frame(deflections, stated=stated), self.robot)


def table_of(frame: pd.DataFrame, source: str = "recordings.csv") -> Table:
    """The table of a file that the frame was written to."""
    return parse_table(csv_text(frame), source)


def read(frame: pd.DataFrame, here: Robot, source: str = "recordings.csv") -> Recordings:
    """Recordings from a frame, through the text of a file."""
    return recordings_from_table(table_of(frame, source), here)


def by_series(recordings: Recordings, shared: bool) -> Recordings:
    """The recordings, the rows of one series sharing their reference or not."""
    return with_references(recordings, Sharing(option=shared))[0]


def experiment(name: str, rows: int, seed: int = 0, loads_per_pose: int = 2) -> Experiment:
    """A random experiment with a robot of the table, several loads at every pose."""
    generator = np.random.default_rng(seed)
    here, case = robot(name), ROBOTS[name]
    poses = case.poses(generator, -(-rows // loads_per_pose))
    poses = np.repeat(poses, loads_per_pose, axis=0)[:rows]
    series = np.repeat(np.arange(1, rows + 1), loads_per_pose)[:rows]
    compliance = here.compliance * generator.uniform(0.7, 1.3, len(here.stiffness))
    return Experiment(here, poses, case.wrenches(generator, rows), series, compliance, np.array(case.deviation))

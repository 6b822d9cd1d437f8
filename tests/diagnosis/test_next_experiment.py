"""What to measure next: where two explanations remain, the proposed series tell them apart."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
import pytest

from expdesign.chain.chain import Chain
from expdesign.chain.effects.legs.transmission import LegBacklash
from expdesign.chain.recordings.reader import recordings_from_table
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.row import row_data
from expdesign.diagnosis.diagnose import diagnose
from expdesign.diagnosis.next_experiment import discriminating_series
from expdesign.diagnosis.result import Diagnosis
from expdesign.io.output import csv_text
from expdesign.io.table import parse_table
from expdesign.mechanics.robots.parallel import ParallelRobot
from expdesign.mechanics.robots.robot_file import read_robot
from tests.commands.calls import ROBOT

DEVIATIONS = np.array([5e-7] * 3 + [2e-6] * 3)
GAP = 1.5e-6


@dataclass(frozen=True)
class Laboratory:
    """A hexapod whose third leg has play."""

    robot: ParallelRobot
    generator: np.random.Generator

    def plan(self, series: int) -> pd.DataFrame:
        """Series of an unloaded row and three loads each, at random poses."""
        rows: list[object] = []
        for number in range(1, series + 1):
            pose = (self.generator.random(6) - 0.5) * [0.05, 0.05, 0.03, 0.2, 0.2, 0.3]
            for mass in (0.0, 5.0, 10.0, 26.5):
                centre = (self.generator.random(2) - 0.5) * 0.35
                rows.append([len(rows) + 1, number, *pose, mass, *centre, 0.12])
        names = ["sequence", "series", *self.robot.configuration, "mass_kg", "com_x_m", "com_y_m", "com_z_m"]
        return pd.DataFrame(rows, columns=names)

    def measure(self, plan: pd.DataFrame) -> pd.DataFrame:
        """The plan with deflections of the true robot and noise."""
        coordinates = self.robot.coordinates
        filled = plan.copy()
        for name, deviation in zip(coordinates.deviation, DEVIATIONS, strict=True):
            filled[name] = deviation
        for name in coordinates.deflection:
            filled[name] = 0.0
        chain = Chain(self.robot, (LegBacklash.from_text(self.robot, "leg 3", "middle"),))
        truth = np.array([1.0, 1.1, 0.95, 1.05, 0.9, 1.0, GAP])
        rows = row_data(self.recordings(filled), self.robot)
        noise = self.generator.normal(size=(len(plan), 6)) * DEVIATIONS
        filled[list(coordinates.deflection)] = chain.predict(rows, truth) + noise
        return filled

    def recordings(self, frame: pd.DataFrame) -> Recordings:
        return recordings_from_table(parse_table(csv_text(frame), "recordings.csv"), self.robot)


def gap_to_rival(result: Diagnosis) -> float:
    """Penalised misfit by which the best model without play in leg 3 is worse than the best model."""
    others = [m for m in result.names.models if not any(e.physics == "leg_backlash" for e in m.effects)]
    return min(m.misfit for m in others) - result.model.misfit


@pytest.mark.parametrize("seed", [2, pytest.param(4, marks=pytest.mark.slow)])
def test_the_proposed_series_resolve_the_case(seed: int) -> None:
    robot = read_robot(ROBOT)
    assert isinstance(robot, ParallelRobot)
    laboratory = Laboratory(robot, np.random.default_rng(seed))
    first = laboratory.measure(laboratory.plan(6))
    before = diagnose(robot, laboratory.recordings(first))
    assert before.findings[0].indistinguishable[0] == "leg_nonlinear_stiffness"
    rival = before.rival
    assert rival is not None
    more = discriminating_series(before.names, before.model, rival, 3)
    assert more["series"].nunique() == 3
    poses = more[list(robot.configuration)]
    assert np.all(poses.min() >= first[list(robot.configuration)].min() - 1e-12)
    assert np.all(poses.max() <= first[list(robot.configuration)].max() + 1e-12)
    assert robot.usable(poses.to_numpy()).all()
    more["sequence"] += len(first)
    more["series"] += first["series"].max()
    after = diagnose(robot, laboratory.recordings(pd.concat([first, laboratory.measure(more)], ignore_index=True)))
    assert after.verdict == "explained"
    assert [(f.physics, f.component) for f in after.findings] == [("leg_backlash", "leg 3")]
    assert after.findings[0].indistinguishable == ()
    low, high = after.findings[0].parameters["gap_m"][1:]
    assert low < GAP < high
    assert gap_to_rival(after) > gap_to_rival(before) + 5.0

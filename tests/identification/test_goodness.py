"""One statement of fit: degrees of freedom by simulation, the row that is to blame, and noise that is overstated."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.stats import chi2

from expdesign.chain.chain import Chain
from expdesign.chain.component import GEOMETRY
from expdesign.chain.effects.legs.geometry import LegGeometry
from expdesign.chain.readings.position import MarkerPosition
from expdesign.chain.readings.reading import MeasuredPose
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.row import row_data
from expdesign.diagnosis.dispersion import statement
from expdesign.diagnosis.frame import framed
from expdesign.diagnosis.stages import unheard
from expdesign.diagnosis.verdict import within_noise
from expdesign.estimation.goodness import REFUTED, StatementOfFit, allows
from expdesign.estimation.identify import identify
from expdesign.mechanics.robots.robot import Robot
from expdesign.mechanics.robots.robot_file import read_robot
from expdesign.probabilities import p_text, probability_text
from tests.cases import ROBOTS
from tests.chain.arm_rows import arm_rows, six_axis
from tests.chain.arms import INSTRUMENT, PLACE, READING, configurations, read_arm, recordings_of
from tests.identification.experiments import by_series, experiment, read
from tests.oracle import Array

HEXAPOD = Path(__file__).parents[2] / "configs" / "robots" / "hexapod-h1.yaml"


@dataclass(frozen=True)
class Laboratory:
    """A robot and readings of it without noise, which state their standard deviations."""

    robot: Robot
    exact: Recordings
    frames_known: bool = True

    def measured(self, seed: int, factor: float = 1.0, *, shared: bool = False) -> Recordings:
        """The readings with `factor` times the noise that they state, half of which a series shares if asked."""
        generator = np.random.default_rng(seed)
        noise = generator.standard_normal(self.exact.deflections.shape)
        if shared:
            common = generator.standard_normal((int(self.exact.series.max()) + 1, noise.shape[1]))
            noise = np.sqrt(0.5) * (noise + common[self.exact.series])
        return replace(
            self.exact, deflections=self.exact.deflections + factor * noise * np.array(self.exact.deviations)
        )


def deflections_of(name: str, rows: int = 10) -> Callable[[Path], Laboratory]:
    made = experiment(name, rows)
    return lambda folder: Laboratory(made.robot, made.recordings(made.exact))


def deflections_of_arm(folder: Path) -> Laboratory:
    robot = six_axis()
    recordings = read(arm_rows(robot, series=6, loads=3), robot)
    chain = Chain(robot)
    return Laboratory(robot, replace(recordings, deflections=chain.predict(row_data(recordings, robot), chain.start())))


def positions_of_arm(folder: Path) -> Laboratory:
    robot = read_arm(folder)
    rows = recordings_of(robot, configurations(46, 3), np.zeros((46, 3)))
    chain = Chain(robot, reading=READING)
    truth = np.concatenate([np.full(7, 1.3), INSTRUMENT, PLACE])
    return Laboratory(robot, replace(rows, deflections=chain.predict(row_data(rows, robot), truth)))


def positions_of_one_orientation(folder: Path) -> Laboratory:
    """The marker's place is confounded with the instrument's, and held where it is: at the tip."""
    made = positions_of_arm(folder)
    rows = replace(made.exact, configurations=configurations(46, 3, one_orientation=True))
    chain = Chain(made.robot, reading=MarkerPosition(("ball",), {}, None, np.array([*INSTRUMENT, 0.0, 0.0, 0.0])))
    truth = np.concatenate([np.full(7, 1.3), INSTRUMENT, np.zeros(3)])
    return replace(made, exact=replace(rows, deflections=chain.predict(row_data(rows, made.robot), truth)))


def paired(commands: int) -> tuple[Robot, Array, Array]:
    """A hexapod, and every command once without load and once with one: commands (N, 6) and wrenches (N, 6)."""
    generator = np.random.default_rng(1)
    poses = generator.uniform(-1.0, 1.0, (commands, 6)) * [0.025, 0.025, 0.015, 0.12, 0.12, 0.16]
    wrenches = generator.standard_normal((2 * commands, 6)) * [200.0, 200.0, 300.0, 20.0, 20.0, 20.0]
    wrenches[::2] = 0.0
    return read_robot(HEXAPOD), np.repeat(poses, 2, axis=0), wrenches


def positions_of_hexapod(folder: Path) -> Laboratory:
    robot, commands, wrenches = paired(10)
    rows = recordings_of(six_axis(), commands, np.zeros((20, 3)))
    rows = replace(rows, wrenches=wrenches, absolute=wrenches, gravity=np.tile(robot.gravity, (20, 1)))
    chain = Chain(robot, reading=READING)
    truth = np.concatenate([np.full(6, 1.3), INSTRUMENT, PLACE])
    return Laboratory(robot, replace(rows, deflections=chain.predict(row_data(rows, robot), truth)))


def poses_of_hexapod(*, frames_known: bool) -> Callable[[Path], Laboratory]:
    def made(folder: Path) -> Laboratory:
        robot, commands, wrenches = paired(12)
        count = np.arange(1, len(commands) + 1)
        frame = pd.DataFrame({"sequence": count, "series": count, "kind": "pose"})
        for index, name in enumerate(robot.coordinates.pose):
            frame[name] = commands[:, index]
            frame[f"measured_{name}"] = commands[:, index]
            frame[f"s{name}"] = 5e-6 if index < 3 else 2e-5
        frame[list(robot.coordinates.wrench)] = wrenches
        rows = read(frame, robot)
        chain = Chain(robot, (LegGeometry(robot, GEOMETRY),), reading=MeasuredPose())
        errors = 2e-4 * np.random.default_rng(1).standard_normal(len(chain.parameters) - 6)
        truth = np.concatenate([np.full(6, 1.2), errors])
        exact = replace(rows, deflections=chain.predict(row_data(rows, robot), truth))
        return Laboratory(robot, exact, frames_known)

    return made


CASES: dict[str, tuple[Callable[[Path], Laboratory], int]] = {
    **{f"deflections of {name}": (deflections_of(name), 40) for name in ROBOTS},
    "deflections of an arm": (deflections_of_arm, 40),
    "positions of an arm": (positions_of_arm, 12),
    "positions of an arm that does not turn": (positions_of_one_orientation, 12),
    "positions of a hexapod": (positions_of_hexapod, 12),
    "poses of a hexapod": (poses_of_hexapod(frames_known=True), 12),
    "poses of a hexapod in unknown frames": (poses_of_hexapod(frames_known=False), 12),
}


def said_by_identify(made: Laboratory, recordings: Recordings, *, shared: bool = False) -> StatementOfFit:
    return identify(made.robot, by_series(recordings, shared), frames_known=made.frames_known).goodness


def said_by_diagnose(made: Laboratory, recordings: Recordings, *, shared: bool = False) -> StatementOfFit:
    """Of the base model."""
    frame = framed(made.robot, by_series(recordings, shared), without=frozenset(), report=unheard)
    return statement(frame.base, frame.names.sample, frame.noise)


@pytest.mark.parametrize("name", CASES)
def test_chi_squared_has_as_many_degrees_of_freedom_as_are_stated(name: str, tmp_path: Path) -> None:
    """Their mean difference over experiments is within three standard errors of none.

    Rows that decide how large an arm's errors are decide how many of them are fitted.
    """
    build, count = CASES[name]
    made = build(tmp_path)
    found = [said_by_identify(made, made.measured(seed)) for seed in range(count)]
    dof = np.array([each.dof for each in found])
    assert (dof > 0).all()
    assert (dof < made.exact.deflections.size).all()
    assert len(set(dof)) == 1 or "of an arm" in name
    away = np.array([each.chi2 - each.dof for each in found if each.chi2 is not None])
    assert abs(away.mean()) < 3.0 * np.sqrt(2.0 * dof.mean() / count)


@cache
def hexapod() -> Laboratory:
    made = experiment("H1", 24)
    return Laboratory(made.robot, made.recordings(made.exact))


def slipped(recordings: Recordings, *rows: int) -> Recordings:
    """One reading of each row ten times too large."""
    deflections = recordings.deflections.copy()
    deflections[list(rows), 2] *= 10.0
    return replace(recordings, deflections=deflections)


@pytest.mark.parametrize("shared", [False, True])
def test_one_reading_with_a_slipped_digit_is_the_one_that_is_named(shared: bool) -> None:
    made = hexapod()
    found = said_by_identify(made, slipped(made.measured(1, shared=shared), 13), shared=shared)
    assert found.refuted
    assert found.worst.where == "recordings.csv, row 15"
    assert found.worst.column == "dz_m"
    assert found.worst.outliers == ("recordings.csv, row 15",)
    assert found.worst.without is not None
    assert found.worst.without > 0.01
    assert "row 15 (dz_m" in found.worst.sentence
    assert "is an outlier" in found.worst.sentence


def test_three_slipped_digits_are_named_and_a_general_misfit_is_not_laid_to_rows() -> None:
    made = hexapod()
    several = said_by_identify(made, slipped(made.measured(1), 3, 13, 20)).worst
    assert set(several.outliers) == {f"recordings.csv, row {row}" for row in (5, 15, 22)}
    general = said_by_identify(made, made.measured(2, factor=10.0))
    assert general.refuted
    assert general.worst.outliers == ()


def test_setting_a_row_aside_is_fitting_without_it() -> None:
    made = hexapod()
    kept = np.arange(24) != 13
    for shared in (False, True):
        spoilt = slipped(made.measured(1, shared=shared), 13)
        worst = said_by_identify(made, spoilt, shared=shared).worst
        again = said_by_identify(made, spoilt.rows(kept), shared=shared)
        assert worst.without == pytest.approx(again.p_value, rel=1e-6)


def test_noise_that_is_stated_three_times_too_large_is_named() -> None:
    made = hexapod()
    found = said_by_identify(made, made.measured(1, factor=1.0 / 3.0))
    assert found.verdict == "too good"
    assert found.overstated == pytest.approx(3.0, rel=0.2)
    assert "times too large" in found.sentence()
    assert found.birge_ratio == 1.0
    assert found.reading_ratio == pytest.approx(1.0 / 3.0, rel=0.2)


def awkward(recordings: Recordings) -> Recordings:
    """Reference rows that measure nothing, and rows that are held out, in the same series as fitted ones."""
    reference = np.arange(len(recordings)) % 8 == 0
    zero = np.where(reference[:, None], 0.0, 1.0)
    return replace(
        recordings,
        wrenches=recordings.wrenches * zero,
        absolute=recordings.absolute * zero,
        deflections=recordings.deflections * zero,
        test=np.arange(len(recordings)) % 8 == 5,
    )


@pytest.mark.parametrize("stated", [True, False])
@pytest.mark.parametrize("shared", [False, True])
@pytest.mark.parametrize(("seed", "factor"), [(1, 1.0), (2, 1.0 / 3.0)])
def test_identify_and_diagnose_say_the_same_of_the_same_rows(
    seed: int, factor: float, shared: bool, stated: bool
) -> None:
    made = hexapod()
    recordings = awkward(made.measured(seed, factor=factor))
    if not stated:
        recordings = replace(recordings, deviations=None)
    one, other = (said(made, recordings, shared=shared) for said in (said_by_identify, said_by_diagnose))
    assert one.verdict == other.verdict
    assert (one.verdict == "too good") == (stated and factor < 1.0)
    assert one.dof == other.dof == 18 * 6 - 6
    assert one.p_value == (None if other.p_value is None else pytest.approx(other.p_value, rel=1e-6))
    assert one.worst.where == other.worst.where
    assert replace(one, left=None).sentence() == other.sentence()  # what is left, `identify` alone says


def test_identify_and_diagnose_count_the_frames_and_markers_of_positions(tmp_path: Path) -> None:
    made = positions_of_hexapod(tmp_path)  # an arm is calibrated by `identify`, which fits more than the base model
    recordings = made.measured(1)
    one, other = said_by_identify(made, recordings), said_by_diagnose(made, recordings)
    assert one.sentence() == other.sentence()
    assert one.dof <= 46 * 3 - 9


@pytest.mark.parametrize(
    ("value", "text"),
    [(9.9e-7, "p below 1e-6"), (2e-6, "p = 2.00e-6"), (0.99999, "p = 0.99999"), (1.0 - 1e-9, "p above 0.999999")],
)
def test_probabilities_are_written_as_far_as_they_mean_something(value: float, text: str) -> None:
    assert p_text(value) == text
    assert probability_text(value) in text


@pytest.mark.parametrize("dof", [3, 40, 400])
def test_at_the_threshold_all_say_the_same(dof: int) -> None:
    limit = float(chi2.isf(REFUTED, dof))
    for value in (0.999 * limit, 1.001 * limit):
        refuted = StatementOfFit.of_chi2(value, dof).refuted
        assert refuted == (value > limit)
        assert allows(value, dof) is not refuted
        assert within_noise((value, dof)) is not refuted

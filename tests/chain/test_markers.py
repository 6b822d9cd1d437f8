"""Positions of markers: instrument and marker are found with the rest, and what cannot be told apart is said."""

import tracemalloc
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from expdesign.chain.chain import Chain
from expdesign.chain.effects.instrument.frame import InstrumentDrift
from expdesign.chain.effects.joints.geometry import GeometricError
from expdesign.chain.models.model_file import Model
from expdesign.chain.readings.choice import reading_of
from expdesign.chain.readings.position import MarkerPosition, turns
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.row import row_data
from expdesign.diagnosis.diagnose import diagnose
from expdesign.errors import InputError
from expdesign.estimation.compensation.prediction import predict
from expdesign.estimation.fit import fit
from expdesign.estimation.noise_level import noise_from_replicates
from expdesign.io.yaml_reader import read_yaml
from expdesign.mechanics.robots.serial import SerialRobot
from expdesign.report.remark_texts import sentences
from tests.chain.arms import DEVIATION, INSTRUMENT, PLACE, READING, STIFFNESS, configurations, recordings_of, write_arm
from tests.fitting import data_of
from tests.oracle import Array


def measured(
    robot: SerialRobot,
    q: Array,
    effects: tuple[GeometricError | InstrumentDrift, ...] = (),
    values: tuple[float, ...] = (),
    seed: int | None = 0,
) -> Recordings:
    """What the instrument reads of the arm with twice the compliance of the robot file."""
    chain = Chain(robot, effects, reading=READING)
    truth = np.concatenate([np.full(7, 2.0), INSTRUMENT, PLACE, values])
    empty = recordings_of(robot, q, np.zeros((len(q), 3)))
    positions = chain.predict(row_data(empty, robot), truth)
    if seed is not None:
        positions = positions + DEVIATION * np.random.default_rng(seed).standard_normal(positions.shape)
    return replace(empty, deflections=positions)


def test_reading_against_rigid_bodies_and_gravity_by_hand(arm: SerialRobot) -> None:
    """Oracle: the torques of own weight where the joints stand, which have a test of their own."""
    q = configurations(4, 3)
    positions = measured(arm, q, seed=None).deflections
    for row, angles in enumerate(q):
        sagged = angles + 2.0 * arm.own_weight(angles, arm.gravity) / STIFFNESS
        bent = angles + 2.0 * arm.own_weight(sagged, arm.gravity) / STIFFNESS
        point = arm.position(bent) + arm.jacobians(bent).rotation @ PLACE
        turn = Rotation.from_euler("xyz", INSTRUMENT[3:]).as_matrix()
        np.testing.assert_allclose(positions[row], turn.T @ (point - INSTRUMENT[:3]), rtol=0.0, atol=1e-9)


def test_one_orientation_is_said_and_only_the_same_orientation_is_predicted(arm: SerialRobot) -> None:
    q = np.vstack([configurations(60, 1, one_orientation=True), configurations(20, 2)])
    data = replace(measured(arm, q), test=np.arange(80) >= 50)
    reading = reading_of(arm, data)
    assert isinstance(reading, MarkerPosition)
    assert len(reading.held) == 3
    assert "is confounded with that of the instrument" in sentences(reading.degeneracies)[0]
    predictable = reading.predictable(arm, data)
    assert predictable[:60].all()
    assert not predictable[60:].any()
    known = recordings_of(arm, q, data.deflections, data.test)
    arm.markers = {"ball": PLACE}
    try:
        given = reading_of(arm, known)
        assert not given.degeneracies
    finally:
        arm.markers = {}


def test_predictions_are_certain_only_where_the_tip_is_turned_as_before(arm: SerialRobot, tmp_path: Path) -> None:
    """Model and instrument are fitted in one orientation: a point in it is known, one turned otherwise is not."""
    data = measured(arm, configurations(60, 1, one_orientation=True))
    reading = reading_of(arm, data)
    assert data.deviations is not None
    chain = Chain(arm, reading=reading)
    result = fit(chain, data_of(data, arm, reading))
    model = Model.from_fit(result, read_yaml(write_arm(tmp_path)), "arm.csv")
    q = np.vstack([configurations(3, 9, one_orientation=True), configurations(3, 9)])
    truth = measured(arm, q, seed=None)
    found = predict(model, truth)
    assert found.deviations[:3].max() < 5e-4
    # The place that is held is wrong, and turns by what the arm sags: some 1e-3 rad times 0.13 m.
    assert np.abs(found.deflections - truth.deflections)[:3].max() < 2e-4
    assert np.abs((found.deflections - truth.deflections) / found.deviations)[3:].max() < 5.0
    assert found.deviations[3:].max() > 0.05
    assert predict(model, truth, platform=True).deflections.shape == (6, 6)
    with pytest.raises(InputError, match="knows no marker `cube`"):
        predict(model, replace(truth, markers=("cube",)))


def off_zero(arm: SerialRobot) -> Recordings:
    """Positions with joint 4 off its zero by 4 mrad; every third row is held out."""
    effects = (GeometricError.from_text(arm, "joint 4"),)
    return replace(measured(arm, configurations(150, 4), effects, (0.004,)), test=np.arange(150) % 3 == 2)


def test_a_joint_that_is_not_at_zero_is_calibrated_and_not_missing(arm: SerialRobot) -> None:
    data = off_zero(arm)
    result = diagnose(arm, data)
    assert result.verdict == "consistent"
    assert not result.findings
    assert result.errors.test_after < 1.2
    known = result.known
    assert [effect.physics for effect in known.chain.effects] == ["joint_position_error"]
    assert data.deviations is not None
    residuals = (data.deflections - known.chain.predict(row_data(data, arm), known.values)) / data.deviations
    assert np.sqrt((residuals[data.test] ** 2).mean()) == pytest.approx(result.errors.test_after, rel=0.01)


def test_a_geometry_that_shall_not_be_called_is_not_calibrated(arm: SerialRobot) -> None:
    result = diagnose(arm, off_zero(arm), without=frozenset({"joint_position_error"}))
    assert result.verdict != "consistent"


def test_an_arm_as_its_file_says_is_consistent(arm: SerialRobot) -> None:
    result = diagnose(arm, replace(measured(arm, configurations(150, 6), seed=7), test=np.arange(150) % 3 == 2))
    assert result.verdict == "consistent"
    assert not result.findings


def test_markers_read_at_one_configuration_are_no_replicates_of_each_other(arm: SerialRobot) -> None:
    """The noise level comes from readings of one marker; two markers are apart by their places."""
    first = measured(arm, configurations(12, 5), seed=1)
    again = measured(arm, configurations(12, 5), seed=2)
    readings = np.concatenate([first.deflections, again.deflections])
    place = np.array([0.1, -0.05, 0.02])
    empty = recordings_of(arm, np.tile(configurations(12, 5), (2, 1)), readings)
    names = ("ball", "other")
    apart = replace(empty, deflections=readings + np.repeat([[0.0] * 3, place], 12, axis=0), deviations=None)
    apart = replace(apart, marker=np.repeat([0, 1], 12), markers=names)
    assert noise_from_replicates(apart, 3) is None
    alike = replace(empty, deviations=None)
    level = noise_from_replicates(alike, 3)
    # 36 degrees of freedom: the standard error of a deviation is 1/√72 of it.
    assert level.deviations[0, 0] == pytest.approx(DEVIATION, rel=4.0 / np.sqrt(72.0))


def test_orientations_of_many_rows_need_little_memory(arm: SerialRobot) -> None:
    """The left singular vectors of 4,000 rotations would be a matrix of 1.2 GB."""
    q = configurations(4000, 3)
    rows = recordings_of(arm, q, np.zeros((4000, 3)))
    tracemalloc.start()
    turns(arm, rows)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 5e7

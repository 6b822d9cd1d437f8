"""Two hands in one model, payloads beside the one that is looked at; pinocchio as the machine."""

import re
from pathlib import Path

import casadi as ca
import numpy as np
import pandas as pd
import pytest

from expdesign.chain.chain import Chain
from expdesign.chain.effect import Effect
from expdesign.chain.effects.joints.bearings import JointCompliance
from expdesign.chain.effects.joints.geometry import GeometricError
from expdesign.chain.effects.links.links import LinkCompliance
from expdesign.chain.effects.load.payload import UnknownTool
from expdesign.chain.models.model_file import Model, model_text, read_model
from expdesign.chain.readings.choice import reading_of
from expdesign.chain.readings.position import MarkerPosition
from expdesign.chain.recordings.points import points_from_table
from expdesign.chain.recordings.reader import recordings_from_table
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.row import row_data
from expdesign.diagnosis.dispersion import widened, widening
from expdesign.diagnosis.held_out import held_out_rows
from expdesign.diagnosis.library import library
from expdesign.errors import InputError
from expdesign.estimation.compensation.prediction import predict
from expdesign.estimation.fit import Data, Fit, fit
from expdesign.io.yaml_reader import read_yaml
from expdesign.mechanics.robots.serial import SerialRobot
from tests.fitting import data_of
from tests.identification.experiments import table_of
from tests.oracle import Array
from tests.robots.torso import FILE, JOINTS, LIFTED, PLACES, STIFFNESS, Torso, read_torso

DEVIATION = 2e-5


@pytest.fixture(scope="module")
def torso(tmp_path_factory: pytest.TempPathFactory) -> SerialRobot:
    return read_torso(tmp_path_factory.mktemp("torso"))


def at(tip: int, q: Array, lifted: Array | None = None) -> Array:
    """Configurations of a tip (1: right, 2: left)."""
    carried = np.zeros((len(q), 4)) if lifted is None else lifted
    return np.hstack([q, carried, np.full((len(q), 1), float(tip))])


def test_both_hands_are_where_pinocchio_has_them(torso: SerialRobot) -> None:
    assert torso.configuration == (*(f"q{k}_rad" for k in range(1, 9)), *LIFTED, "tip")
    assert [c.joint for c in torso.tree.coordinates] == list(JOINTS)
    q = np.random.default_rng(0).uniform(-1.0, 1.0, (5, 8))
    for tip, hand in ((1, "right_hand"), (2, "left_hand")):
        there = at(tip, q)
        jacobians = torso.jacobians(there)
        poses = [Torso().pose(values, hand) for values in q]
        np.testing.assert_allclose(torso.position(there), [pose.translation for pose in poses], atol=1e-12)
        np.testing.assert_allclose(jacobians.rotation, [pose.rotation for pose in poses], atol=1e-12)
        step = 1e-6 * np.eye(13)[:8]
        for row, forward in zip(there, jacobians.forward, strict=True):
            slopes = (torso.position(row + step) - torso.position(row - step)) / 2e-6
            np.testing.assert_allclose(forward[:3], slopes.T, atol=1e-8)
        other = slice(5, 8) if tip == 1 else slice(2, 5)
        np.testing.assert_array_equal(jacobians.forward[:, :, other], 0.0)


def test_all_masses_load_the_joints_below_them(torso: SerialRobot) -> None:
    """Both arms, and what the left hand lifts while the right one is looked at."""
    generator = np.random.default_rng(1)
    q, centres = generator.uniform(-1.0, 1.0, (4, 8)), generator.uniform(-0.2, 0.2, (4, 3))
    masses = np.array([0.0, 2.0, 5.0, 9.0])
    found = [torso.own_weight(at(t, q, np.column_stack([masses, centres])), torso.gravity) for t in (1, 2)]
    expected = [Torso().torques(row, (m, c)) for row, m, c in zip(q, masses, centres, strict=True)]
    np.testing.assert_allclose(found[0], expected, atol=1e-10)
    np.testing.assert_array_equal(found[0], found[1])
    whole = torso.weight_wrench(at(1, q, np.column_stack([masses, centres])), torso.gravity)
    np.testing.assert_allclose(whole[:, 2], -9.80665 * (12.0 + 15.0 + 2 * 5.8 + masses), rtol=1e-12)


def read_data(robot: SerialRobot, frame: pd.DataFrame) -> Data:
    read = recordings_from_table(table_of(frame), robot)
    return data_of(read, robot, reading_of(robot, read))


def fitted(robot: SerialRobot, data: Data) -> Fit:
    """Geometry, stiffness and the tool of the right hand."""
    effects = (GeometricError.from_text(robot, "all joints"), UnknownTool.from_text(robot, "platform", "right_hand"))
    return fit(Chain(robot, effects, reading=data.reading), data.counting(~data.recordings.test))


def test_a_torso_with_two_arms_is_calibrated_as_one(torso: SerialRobot, tmp_path: Path) -> None:
    """Zeros, stiffness and an unknown tool from both hands' markers, while the left hand lifts known payloads.

    The machine is pinocchio's. Intervals hold the truth to 4 standard deviations, and 95 ± 4 % of held-out readings.
    """
    zeros = np.array([0.0, 4e-4, -6e-4, 5e-4, 3e-4, -5e-4, 4e-4, -2e-4])
    tool = (2.5, np.array([0.06, -0.02, 0.05]))
    frame = Torso(zeros, tool).recordings(360, 3, DEVIATION).assign(split=["train", "train", "train", "test"] * 90)
    data = read_data(torso, frame)
    found = fitted(torso, data)
    assert found.chi2 / (3 * 270 - found.rank) == pytest.approx(1.0, abs=0.15)
    own, deviations = found.chain.slices, np.sqrt(np.diag(found.covariance))
    truth = np.array([tool[0], *(tool[0] * tool[1])])
    assert np.abs((found.values[own[1]] - truth) / deviations[own[1]]).max() < 4.0
    assert deviations[own[1]][0] < 0.2
    assert np.abs((found.values[:8] - 1.0) / deviations[:8]).max() < 4.0
    sample = data.counting(~data.recordings.test)
    by = widening(found, sample, known_noise=True)
    rows = held_out_rows(found, sample, data.recordings.test)
    inside, count = rows.within(widened(found, by).estimable, by.readings)
    assert count == 270
    assert inside / count == pytest.approx(0.95, abs=0.04)
    document = read_yaml(read_torso_file(tmp_path))
    model = Model.from_fit(found, document, "recordings.csv")
    (tmp_path / "model.yaml").write_text(model_text(model, tmp_path), encoding="utf-8")
    points = points_from_table(table_of(frame), torso)
    again = predict(read_model(tmp_path / "model.yaml"), points)
    np.testing.assert_allclose(again.deflections, predict(model, points).deflections, atol=1e-12)


def read_torso_file(folder: Path) -> Path:
    read_torso(folder)
    return folder / "robot.yaml"


def test_what_the_other_hand_lifts_must_not_be_forgotten(torso: SerialRobot) -> None:
    """The same recordings with the payloads taken out of the columns are refuted."""
    frame = Torso().recordings(80, 3, DEVIATION)
    read = read_data(torso, frame)
    known = fit(Chain(torso, reading=read.reading), read)
    forgotten = read_data(torso, frame.assign(**dict.fromkeys(LIFTED, 0.0)))
    assert fit(Chain(torso, reading=forgotten.reading), forgotten).chi2 > 20.0 * known.chi2


def positions(robot: SerialRobot, effect: Effect, value: float, rows: Recordings) -> Array:
    reading = MarkerPosition(rows.markers, PLACES, np.zeros(6), np.zeros(0))
    chain = Chain(robot, (effect,), reading=reading)
    return chain.predict(row_data(rows, robot), np.concatenate([np.ones(8), np.full(len(effect.parameters), value)]))


@pytest.mark.parametrize(
    ("effect", "component"),
    [(JointCompliance, "joint 7"), (LinkCompliance, "link 6"), (GeometricError, "link 6"), (GeometricError, "joint 7")],
)
def test_physics_of_one_arm_moves_that_hand_alone(torso: SerialRobot, effect: type[Effect], component: str) -> None:
    rows = recordings_from_table(table_of(Torso().recordings(6, 5, DEVIATION)), torso)
    here = effect.from_text(torso, component)
    moved = np.abs(positions(torso, here, 1e-4, rows) - positions(torso, here, 0.0, rows)).max(axis=1)
    left = np.arange(6) % 2 == 1
    assert (moved[left] > 1e-7).all()
    np.testing.assert_array_equal(moved[~left], 0.0)


def test_a_link_with_two_far_ends_has_errors_at_each(torso: SerialRobot) -> None:
    """The chest ends at two shoulders: six errors for each arm, and the geometry has as many as there are ends."""
    here = GeometricError.from_text(torso, "link 2")
    assert [p.name for p in here.parameters][::6] == ["link_2_x_m", "link_2_left_shoulder_x_m"]
    whole = GeometricError.from_text(torso, "geometry")
    assert len(whole.parameters) == 8 + 6 * (len(torso.tree.ends) - 1) == 8 + 6 * 9
    rows = recordings_from_table(table_of(Torso().recordings(4, 5, DEVIATION)), torso)
    neutral = positions(torso, here, 0.0, rows)
    reading = MarkerPosition(rows.markers, PLACES, np.zeros(6), np.zeros(0))
    chain = Chain(torso, (here,), reading=reading)
    shifted = chain.predict(row_data(rows, torso), np.concatenate([np.ones(8), 1e-3 * np.eye(12)[6]]))
    np.testing.assert_allclose(np.linalg.norm(shifted - neutral, axis=1), [0.0, 1e-3, 0.0, 1e-3], atol=1e-12)


def test_tools_of_both_hands_may_be_in_one_model(torso: SerialRobot) -> None:
    """In rows of the other hand a tool loads the trunk alone, as a payload that is known to be there does."""
    rows = recordings_from_table(table_of(Torso().recordings(40, 5, DEVIATION)), torso)
    tools = [effect for effect in library(torso, rows) if isinstance(effect, UnknownTool)]
    assert [str(tool.variant) for tool in tools] == ["right_hand", "left_hand"]
    assert tools[0].slot != tools[1].slot
    mass, centre = 3.0, np.array([0.05, 0.02, -0.03])
    lifted = rows.configurations.copy()
    lifted[:, 8:12] = mass, *centre
    empty = lifted.copy()
    empty[:, 8] = 0.0
    reading = MarkerPosition(rows.markers, PLACES, np.zeros(6), np.zeros(0))
    chain = Chain(torso, (tools[1],), reading=reading)
    read = []
    for configurations, tool in ((lifted, np.zeros(4)), (empty, np.array([mass, *(mass * centre)]))):
        points = recordings_from_table(table_of(Torso().recordings(40, 5, DEVIATION)), torso)
        vars(points)["configurations"][:] = configurations
        read.append(chain.predict(row_data(points, torso), np.concatenate([np.ones(8), tool])))
    np.testing.assert_allclose(read[0], read[1], atol=1e-13)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"tip": ""}, "column tip.*missing.*`right_hand`, `left_hand`"),
        ({"tip": "hand"}, "row 2, column tip.*`hand` is no tip"),
        ({"marker": "ball"}, "row 3, column tip.*marker `ball` sits on `right_hand`"),
        ({"left_hand_mass_kg": "-1.0"}, "row 2, column left_hand_mass_kg.*negative"),
    ],
)
def test_rows_that_do_not_say_which_hand(torso: SerialRobot, change: dict[str, str], says: str) -> None:
    frame = Torso().recordings(4, 5, DEVIATION).assign(**change)  # type: ignore[arg-type]
    emptied = [name for name, value in change.items() if not value]
    with pytest.raises(InputError) as caught:
        recordings_from_table(table_of(frame.drop(columns=emptied)), torso)
    assert re.search(says, str(caught.value), re.DOTALL)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("[right_hand, left_hand]", "[right_hand, right_hand]", "tip_link.*named twice"),
        ("[right_hand, left_hand]", "[right_hand, lefthand]", "no link `lefthand`.*`left_hand`"),
        ("payload_links: [left_hand]", "payload_links: [ground]", "payload_links.*no joint of the robot moves"),
    ],
)
def test_wrong_tips_are_named(tmp_path: Path, old: str, new: str, says: str) -> None:
    with pytest.raises(InputError) as caught:
        read_torso(tmp_path, FILE.replace(old, new))
    assert re.search(says, str(caught.value), re.DOTALL)


def test_a_tip_on_the_way_to_another_has_an_error_of_its_own(tmp_path: Path) -> None:
    """A marker's frame on the fore arm may be off without moving the hand."""
    stiffness = STIFFNESS[:5].tolist()
    text = FILE.replace("[right_hand, left_hand]", "[right_hand, right_fore]").replace(
        str(STIFFNESS.tolist()), str(stiffness)
    )
    robot = read_torso(tmp_path, text.replace("payload_links: [left_hand]", ""))
    q, geometry = ca.SX.sym("q", 6), ca.SX.sym("g", robot.tree.size)
    place = ca.Function("place", [q, geometry], [robot.tip(q, geometry)[0]])
    index = robot.tree.geometry_names.index("link 4 right_fore x")
    error = 1e-3 * np.eye(robot.tree.size)[index]
    for tip, moved in ((1, 0.0), (2, 1e-3)):
        here = np.r_[0.1, 0.2, 0.3, 0.4, 0.5, tip]
        gone = np.array(place(here, error)) - np.array(place(here, 0.0 * error))
        assert np.linalg.norm(gone) == pytest.approx(moved, abs=1e-12)

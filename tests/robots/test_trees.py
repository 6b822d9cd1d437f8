"""Trees: joints off the chain, second arms, joints that follow several others; pinocchio as oracle."""

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pinocchio as pin
import pytest

from expdesign.chain.chain import Chain
from expdesign.chain.effects.structure.compliance import BaseCompliance
from expdesign.chain.readings.position import MarkerPosition
from expdesign.chain.recordings.points import points_from_table
from expdesign.chain.row import row_data
from expdesign.errors import InputError
from tests.identification.experiments import table_of
from tests.robots.urdf import joint_text, link_text, robot_of

TORSO = (
    '<robot name="torso"><link name="ground"/>'
    + link_text("trunk", 20.0)
    + joint_text("waist", "ground", "trunk", "0 0 0.5", "0 1 0")
    + "".join(
        link_text(f"{side}_upper", 3.0)
        + link_text(f"{side}_fore", 2.0)
        + joint_text(f"{side}_shoulder", "trunk", f"{side}_upper", f"0 {y} 0.4", "0 1 0")
        + joint_text(f"{side}_elbow", f"{side}_upper", f"{side}_fore", "0.3 0 0", "0 0 1")
        for side, y in (("right", -0.2), ("left", 0.2))
    )
    + link_text("beside", 4.0)
    + joint_text("stand", "ground", "beside", "0 0.6 0", "1 0 0")
    + "</robot>"
)
MOTORS = link_text("m1", 0.0) + link_text("m2", 0.0) + joint_text("one", "ground", "m1", "0 0 0", "0 1 0")
MOTORS += joint_text("two", "ground", "m2", "0 0 0", "0 1 0")
PARALLELOGRAM = (
    '<robot name="p"><link name="ground"/>'
    + MOTORS
    + link_text("upper", 3.0)
    + link_text("fore", 2.0)
    + joint_text("shoulder", "ground", "upper", "0 0 0.3", "0 1 0", rule='<mimic joint="one"/>')
    + joint_text("elbow", "upper", "fore", "0.4 0 0", "0 1 0", rule="RULE")
    + "</robot>"
)
TWO_TAGS = '<mimic joint="one" multiplier="-1"/><mimic joint="two" multiplier="0.5" offset="0.1"/>'
TORSO_FILE = (
    "name: torso\nkind: serial\nurdf: robot.urdf\nbase_link: ground\ntip_link: right_fore\n"
    "actuator_stiffness: [90000.0, 20000.0, 10000.0]\nbranch_joints: [left_shoulder, left_elbow, stand]\n"
)
PARALLELOGRAM_FILE = (
    "name: p\nkind: serial\nurdf: robot.urdf\nbase_link: ground\ntip_link: fore\nactuator_stiffness: [9000.0, 9000.0]\n"
)
COUPLING = "couplings: {elbow: {follows: {one: -1.0, two: 0.5}, offset: 0.1}}\n"


def test_the_weight_of_another_arm_moves_the_waist(tmp_path: Path) -> None:
    """Torques of all joints in pinocchio; the waist carries both arms, wherever the left one stands."""
    robot = robot_of(tmp_path, TORSO, TORSO_FILE)
    assert robot.configuration == (
        *("q1_rad", "q2_rad", "q3_rad"),
        *("left_shoulder_rad", "left_elbow_rad", "stand_rad"),
    )
    model = pin.buildModelFromXML(TORSO)
    names = [c.joint for c in (*robot.tree.coordinates, *robot.tree.branch_coordinates)]
    columns = [model.joints[model.getJointId(name)].idx_q for name in names]
    q = np.random.default_rng(0).uniform(-1.5, 1.5, (6, 6))
    found = robot.own_weight(q, robot.gravity)
    model.gravity.linear = robot.gravity
    data = model.createData()
    for values, torques in zip(q, found, strict=True):
        full = np.zeros(model.nq)
        full[columns] = values
        expected = -pin.computeGeneralizedGravity(model, data, full)[columns]
        np.testing.assert_allclose(torques, expected[:3], atol=1e-9)
    assert np.ptp(robot.own_weight(np.vstack([q[0], q[0] + [0, 0, 0, 1, 0, 0]]), robot.gravity)[:, 0]) > 1.0


def test_a_branch_moves_no_tip_and_yields_nowhere(tmp_path: Path) -> None:
    robot = robot_of(tmp_path, TORSO, TORSO_FILE)
    q = np.array([0.2, 0.3, 0.4, 0.5, 0.6, 0.7])
    assert robot.jacobians(q).forward.shape == (6, 3)
    np.testing.assert_array_equal(robot.position(q), robot.position(np.r_[q[:3], 0.0, 0.0, 0.0]))


def test_all_that_moves_weighs_on_the_base(tmp_path: Path) -> None:
    """Wrench about the base's origin by masses and places in pinocchio, the branch of the base included."""
    robot = robot_of(tmp_path, TORSO, TORSO_FILE)
    q = np.random.default_rng(1).uniform(-1.0, 1.0, 6)
    model = pin.buildModelFromXML(TORSO)
    names = [c.joint for c in (*robot.tree.coordinates, *robot.tree.branch_coordinates)]
    full = np.zeros(model.nq)
    full[[model.joints[model.getJointId(name)].idx_q for name in names]] = q
    centre = pin.centerOfMass(model, model.createData(), full)
    mass = pin.computeTotalMass(model)
    wrench = robot.weight_wrench(q, robot.gravity)
    moment = wrench[3:] + np.cross(robot.position(q), wrench[:3])
    np.testing.assert_allclose(wrench[:3], mass * robot.gravity, rtol=1e-12)
    np.testing.assert_allclose(moment, np.cross(centre, mass * robot.gravity), atol=1e-9)


def test_the_sag_that_positions_show_has_the_other_arm_in_it(tmp_path: Path) -> None:
    robot = robot_of(tmp_path, TORSO, TORSO_FILE + "instrument: [0, 0, 0, 0, 0, 0]\nmarkers: {a: [0.1, 0, 0]}\n")
    q = np.array([[0.2, 0.3, 0.4, 0.0, 0.0, 0.0], [0.2, 0.3, 0.4, 1.5, 0.0, 0.0]])
    frame = pd.DataFrame(q, columns=list(robot.configuration)).assign(sequence=[1, 2], series=[1, 2], marker="a")
    points = points_from_table(table_of(frame.assign(**dict.fromkeys(robot.coordinates.wrench, 0.0))), robot)
    effect = BaseCompliance.from_text(robot, "base", "diagonal")
    reading = MarkerPosition(("a",), dict(robot.markers), robot.instrument, np.zeros(0))
    chain = Chain(robot, (effect,), reading=reading)
    read = chain.predict(row_data(points, robot), chain.start())
    torque = robot.own_weight(q, robot.gravity)
    about = (torque[1] - torque[0])[0] / robot.stiffness[0]
    place = robot.position(q[0]) + robot.jacobians(q[0]).rotation @ [0.1, 0.0, 0.0]
    np.testing.assert_allclose(read[1] - read[0], np.cross([0, about, 0], place - [0, 0, 0.5]), atol=1e-6)
    assert abs(about) > 1e-4


@pytest.mark.parametrize("how", ["tags", "couplings"])
def test_a_joint_follows_two_others(tmp_path: Path, how: str) -> None:
    """The fore arm of a parallelogram: elbow = −one + two/2 + 0.1, so that its direction is two/2 + 0.1 alone."""
    rule, file = (TWO_TAGS, "") if how == "tags" else ("", COUPLING)
    robot = robot_of(tmp_path, PARALLELOGRAM.replace("RULE", rule), PARALLELOGRAM_FILE + file)
    assert [c.joint for c in robot.tree.coordinates] == ["one", "two"]
    q = np.array([[0.3, 0.8], [-0.6, 0.8], [0.3, -1.0]])
    rotation = robot.jacobians(q).rotation
    np.testing.assert_allclose(np.arctan2(rotation[:, 0, 2], rotation[:, 0, 0]), 0.5 * q[:, 1] + 0.1, atol=1e-12)
    elbow = np.stack([0.4 * np.cos(q[:, 0]), 0 * q[:, 0], 0.3 - 0.4 * np.sin(q[:, 0])], axis=1)
    np.testing.assert_allclose(robot.position(q), elbow, atol=1e-12)
    # Power: the torque about a motor is the weight times the vertical speed of the centres, by finite differences.
    steps, g = 1e-6 * np.eye(2), 9.80665

    def energy(x: np.ndarray) -> float:  # type: ignore[type-arg]
        angle = 0.5 * x[1] + 0.1
        upper = 0.3 - 0.1 * np.sin(x[0]) + 0.02 * np.cos(x[0])
        fore = 0.3 - 0.4 * np.sin(x[0]) - 0.1 * np.sin(angle) + 0.02 * np.cos(angle)
        return float(-g * (3.0 * upper + 2.0 * fore))

    expected = [(energy(q[0] + step) - energy(q[0] - step)) / 2e-6 for step in steps]
    np.testing.assert_allclose(robot.own_weight(q[0], robot.gravity), expected, rtol=1e-6)


def test_columns_may_have_the_names_of_joints(tmp_path: Path) -> None:
    robot = robot_of(tmp_path, TORSO, TORSO_FILE)
    frame = pd.DataFrame({"sequence": [1], "series": [1], "mass_kg": [1.0]})
    frame = frame.assign(com_x_m=0.0, com_y_m=0.0, com_z_m=0.0)
    names = ("waist", "right_shoulder", "right_elbow", "left_shoulder", "left_elbow", "stand")
    named = frame.assign(**{f"{name}_rad": 0.1 * i for i, name in enumerate(names)})
    points = points_from_table(table_of(named), robot)
    np.testing.assert_allclose(points.configurations, [[0.0, 0.1, 0.2, 0.3, 0.4, 0.5]])


@pytest.mark.parametrize(
    ("column", "says"),
    [
        ("q4_rad", "no such joint between `ground` and `right_fore`"),
        ("left_elbo_rad", "no joint `left_elbo`.*Is `left_elbow` meant"),
        ("left_elbow_m", "the other unit"),
        ("waist_rad", "the column q1_rad as well"),
        ("stand_rad", r"Add `branch_joints: \[stand\]`"),
    ],
)
def test_a_column_of_a_joint_that_is_not_there_is_named(tmp_path: Path, column: str, says: str) -> None:
    robot = robot_of(tmp_path, TORSO, TORSO_FILE.replace(", stand", ""))
    frame = pd.DataFrame({name: [0.0] for name in ("sequence", *robot.configuration, *robot.coordinates.wrench)})
    with pytest.raises(InputError) as caught:
        points_from_table(table_of(frame.assign(**{column: 0.0})), robot)
    assert column in caught.value.where
    assert re.search(says, str(caught.value), re.DOTALL)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("left_shoulder,", "left_shouldr,", "Did you mean `left_shoulder`|no joint `left_shouldr`"),
        ("left_shoulder,", "waist,", "on the chain"),
        ("left_shoulder,", "stand,", "named twice"),
        ("branch_joints", "couplings: {left_elbow: {follows: {ghost: 1.0}}}\nbranch_joints", "no joint `ghost`"),
        ("branch_joints", "couplings: {waist: {follows: {waist: 1.0}}}\nbranch_joints", "mimics itself"),
        ("branch_joints", "couplings: {left_elbow: {follows: {waist: 1.0}}}\nbranch_joints", "follows `waist`"),
    ],
)
def test_a_wrong_tree_is_named(tmp_path: Path, old: str, new: str, says: str) -> None:
    with pytest.raises(InputError, match=says):
        robot_of(tmp_path, TORSO, TORSO_FILE.replace(old, new))


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('<origin xyz="0.1 0 0.02"/>', '<origin xyz="500 0 0.02"/>', "centre of mass lies 500 m"),
        ('mass value="20.0"', 'mass value="2e9"', "does not fit"),
    ],
)
def test_masses_and_centres_that_no_robot_has_are_refused(tmp_path: Path, old: str, new: str, says: str) -> None:
    assert old in TORSO
    with pytest.raises(InputError, match=says) as caught:
        robot_of(tmp_path, TORSO.replace(old, new, 1), TORSO_FILE)
    assert "link trunk" in caught.value.where


def test_a_tag_that_stands_there_twice_is_an_error(tmp_path: Path) -> None:
    twice = PARALLELOGRAM.replace("RULE", '<mimic joint="one"/><mimic joint="one" multiplier="2"/>')
    with pytest.raises(InputError, match="two <mimic> tags"):
        robot_of(tmp_path, twice, PARALLELOGRAM_FILE)

"""Arms calibrated from positions and poses; pinocchio has the truth: zeros and links are off, joints yield."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pinocchio as pin
import pytest

import expdesign as xd
from expdesign.app.api.inputs import table_of
from expdesign.chain.chain import Chain
from expdesign.chain.component import GEOMETRY
from expdesign.chain.effects.joints.geometry import CalibratedGeometryError
from expdesign.chain.readings.position import MarkerPosition
from expdesign.chain.recordings.reader import recordings_from_table
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.row import row_data
from expdesign.estimation.arm import calibrate
from expdesign.estimation.arm_options import Loss
from expdesign.estimation.remarks import BlindPoses, GenerousNoise, NoiseBeyondStated
from expdesign.mechanics.robots.kinematic_tree import KinematicTree
from expdesign.mechanics.robots.robot_file import read_robot
from expdesign.mechanics.robots.serial import SerialRobot
from expdesign.mechanics.robots.urdf import read_urdf
from expdesign.report.blocks import KeyFigures
from expdesign.report.fit_texts import identified_sentences
from expdesign.report.identification_report import IdentificationResult
from tests.oracle import Array
from tests.plant import INSTRUMENT, JOINTS, NOISE, PLACES, READ, ROBOT, STATED, Arm, Faults, recordings
from tests.plant import PLAIN as FAULTS


def measured(rows: int = 240, seed: int = 5, faults: Faults = FAULTS) -> pd.DataFrame:
    """Positions of three markers without load columns."""
    return recordings(faults, rows, seed, loads=False)


@pytest.fixture(scope="module")
def identified() -> IdentificationResult:
    return xd.identify(ROBOT, measured())


def geometry(found: IdentificationResult) -> Array:
    frame = found.geometry
    return np.asarray(frame["estimate"], dtype=float)


def test_what_is_held_out_is_predicted_to_the_noise(identified: IdentificationResult) -> None:
    arm = identified.result.arm
    assert identified.result.calibration == "both"
    held_out = arm.accuracy["held out", "position"]
    assert held_out.before.rms > 1e-3
    assert held_out.after.rms < 1.2 * NOISE * np.sqrt(3.0)
    p_value = identified.result.goodness.p_value
    assert p_value is not None
    assert p_value > 0.001


def test_compliances_are_those_of_the_truth(identified: IdentificationResult) -> None:
    """Joint 1 is upright and joint 6 has nothing beyond it: nothing shows how they yield."""
    interval = identified.result.compliance
    truth = FAULTS.softness / read_robot(ROBOT).stiffness
    half = (interval.high - interval.low) / 2.0
    assert (np.abs(interval.estimate - truth)[1:5] < 2.0 * half[1:5]).all()
    assert half[1] < 0.05 * truth[1]
    arm = identified.result.arm
    assert arm.told_apart[1:4].all()
    assert not arm.told_apart[0]


def test_eighteen_parameters_of_six_revolute_axes_with_three_parallel_ones(identified: IdentificationResult) -> None:
    """4 per revolute axis, of which instrument and markers stand for the first and the last ones."""
    arm = identified.result.arm
    first = next(each for each in arm.redundant if each.name == "joint 1's zero")
    assert first.sentence.startswith("joint 1's zero cannot be told apart from the instrument")
    assert len(arm.redundant) == 18
    assert not [remark for remark in arm.remarks if isinstance(remark, BlindPoses)]


def test_the_corrected_urdf_predicts_the_same(identified: IdentificationResult, tmp_path: Path) -> None:
    identified.save(tmp_path / "out")
    robot = read_robot(ROBOT)
    assert isinstance(robot, SerialRobot)
    corrected = KinematicTree(read_urdf(tmp_path / "out/robot.urdf"), robot.tree.base, list(robot.tree.tips))
    other = SerialRobot(corrected, robot.stiffness)
    model, rows = identified.model, identified.result.recordings
    plain = Chain(other, reading=model.chain.reading)
    expected = model.chain.predict(row_data(rows, robot), model.values)
    found = plain.predict(row_data(rows, other), model.values[: plain.base])
    np.testing.assert_allclose(found, expected, atol=1e-12)
    assert "identified_one" in corrected.urdf.links


def test_the_model_file_holds_the_geometry(identified: IdentificationResult, tmp_path: Path) -> None:
    identified.save(tmp_path / "out")
    points = measured().drop(columns=[*READ, *STATED])
    predicted = xd.predict(tmp_path / "out/model.yaml", points).frame
    error = (predicted[READ] - measured()[READ]).to_numpy()
    assert np.sqrt((error**2).mean()) < 1.2 * NOISE
    assert predicted["spx_m"].max() < NOISE


def test_turning_the_instrument_changes_no_geometry(identified: IdentificationResult) -> None:
    """To where descents end, which differs by some 1e-8 rad between turns."""
    frame = measured()
    turn = pin.SE3(pin.rpy.rpyToMatrix(0.7, -0.4, 2.0), np.array([5.0, -3.0, 1.0]))
    frame[READ] = np.array([turn.act(point) for point in frame[READ].to_numpy()])
    np.testing.assert_allclose(geometry(xd.identify(ROBOT, frame)), geometry(identified), atol=1e-7)


@pytest.mark.parametrize("factor", [1.0 / 3.0, None, 1e3, pytest.param(3.0, marks=pytest.mark.slow)])
def test_a_wrong_standard_deviation_is_named_and_changes_nothing(
    identified: IdentificationResult, factor: float | None
) -> None:
    frame = measured()
    if factor is None:
        frame = frame.drop(columns=STATED)
    else:
        frame[STATED] *= factor
    other = xd.identify(ROBOT, frame)
    np.testing.assert_allclose(geometry(other), geometry(identified), atol=5e-6)
    (level,) = other.result.noise.groups
    assert abs(level.deviation / NOISE - 1.0) < 0.1
    named = [each.needed for each in other.result.suspicions if isinstance(each, NoiseBeyondStated | GenerousNoise)]
    assert named == ([] if factor is None else [level.deviation])


def test_the_tiles_say_what_the_sentence_says(identified: IdentificationResult) -> None:
    """Where the sentence leaves out joint 1, about which no weight turns, so do they."""
    blocks = (block for section in identified.page().sections for block in section.blocks)
    tiles = {each.label: each for block in blocks if isinstance(block, KeyFigures) for each in block.items}
    (said,) = (text for text in identified_sentences(identified.result) if "identify" in text)
    assert f"{tiles['Stiffnesses'].value} stiffnesses" in said
    assert f"to {tiles['Least certain stiffness'].value} % " in said


@pytest.mark.slow
@pytest.mark.parametrize("factor", [3.0, 1.0 / 3.0])
def test_a_diagnosis_predicts_alike_whatever_deviation_is_stated(factor: float, tmp_path: Path) -> None:
    """108 held-out readings of 30 µm noise."""
    frame = measured(120).assign(split=np.where(np.arange(120) % 10 < 3, "test", "train"))
    frame[STATED] *= factor
    found = xd.diagnose(ROBOT, frame)
    found.save(tmp_path / "found")
    predicted = xd.predict(tmp_path / "found/model.yaml", frame.drop(columns=READ), readings=True).frame
    held_out = (frame["split"] == "test").to_numpy()
    error, deviation = (frame[READ] - predicted[READ]).to_numpy()[held_out], predicted[STATED].to_numpy()[held_out]
    assert np.sqrt((error**2).mean()) < 1.2 * NOISE
    assert 0.90 <= (np.abs(error) <= 1.96 * deviation).mean() <= 0.98
    assert factor < 1.0 or any(isinstance(remark, GenerousNoise) for remark in found.result.caveats)


@pytest.mark.parametrize(("loss", "size"), [("student", 3e-3), ("huber", 0.1)])
def test_a_robust_loss_hardly_counts_outliers(loss: Loss, size: float, identified: IdentificationResult) -> None:
    frame = measured()
    train = np.flatnonzero(frame["split"] == "train")[:150:15]
    frame.loc[train, "px_m"] += size
    squares = np.abs(geometry(xd.identify(ROBOT, frame)) - geometry(identified)).max()
    found = xd.identify(ROBOT, frame, loss=loss)
    robust = np.abs(geometry(found) - geometry(identified)).max()
    assert robust < 2e-5
    assert robust < 0.1 * squares
    # Nor do they say anything of the noise of the other rows.
    assert found.result.reading_deviations.max() < 2.0 * NOISE


def test_a_joint_that_stands_still_is_named() -> None:
    rows = recordings_of(measured(120))
    still = replace(rows, configurations=np.where(np.arange(6) == 3, 0.3, rows.configurations))
    arm = Arm(FAULTS)
    positions = np.array([
        arm.position(q, PLACES[rows.markers[int(number)]])
        for q, number in zip(still.configurations, np.asarray(rows.marker), strict=True)
    ])  # fmt: skip
    found = calibrate(read_robot(ROBOT), replace(still, deflections=positions), "both")
    (blind,) = [remark for remark in found.remarks if isinstance(remark, BlindPoses)]
    assert any("joint 4" in name or "joint 5" in name for name in blind.names)


def recordings_of(frame: pd.DataFrame) -> Recordings:
    return recordings_from_table(table_of(frame, "recordings"), read_robot(ROBOT))


def mixed(count: int = 90, seed: int = 1) -> pd.DataFrame:
    """Full poses of a target and positions of a marker in one table, joints by their names in the URDF."""
    generator, arm = np.random.default_rng(seed), Arm(FAULTS)
    target = pin.SE3(pin.rpy.rpyToMatrix(0.3, -0.5, 1.0), np.array([0.02, 0.03, 0.1]))
    names = ["shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3"]
    rows = []
    for number in range(count):
        command = generator.uniform([-2.5, -2.4, -2.0, -2.5, -2.5, -2.8], [2.5, -0.7, 2.0, 2.5, 2.5, 2.8])
        row: dict[str, object] = {"sequence": number + 1, "series": number + 1}
        row |= {f"{name}_rad": value for name, value in zip(names, command, strict=True)}
        position = arm.position(command, PLACES["one"]) + NOISE * generator.standard_normal(3)
        if number % 3 == 2:
            row |= {"kind": "position", "marker": "one"}
            row |= dict(zip(READ, position, strict=True))
            if number % 2:
                del row["py_m"]
        else:
            pose = INSTRUMENT.inverse() * arm._data.oMf[arm._tip] * target
            turned = pin.exp3(1e-4 * generator.standard_normal(3)) @ pose.rotation
            place = pose.translation + NOISE * generator.standard_normal(3)
            row |= {"kind": "pose"}
            row |= dict(zip((f"measured_{axis}_m" for axis in "xyz"), place, strict=True))
            angles = pin.rpy.matrixToRpy(turned)
            row |= dict(zip((f"measured_r{axis}_rad" for axis in "xyz"), angles, strict=True))
        rows.append({**row, "split": "test" if number % 5 == 0 else "train"})
    return pd.DataFrame(rows)


def test_poses_and_positions_with_empty_cells_and_without_loads() -> None:
    found = xd.identify(ROBOT, mixed())
    arm = found.result.arm
    assert arm.accuracy["held out", "position"].after.rms < 1.5 * NOISE * np.sqrt(3.0)
    assert arm.accuracy["held out", "orientation"].after.rms < 1.5 * 1e-4 * np.sqrt(3.0)
    levels = {group.name: group.deviation for group in found.result.noise.groups}
    assert abs(levels["translations"] / NOISE - 1.0) < 0.25
    assert abs(levels["rotations"] / 1e-4 - 1.0) < 0.25
    points = mixed().drop(columns=[name for name in mixed() if str(name).startswith(("measured_", "p"))])
    predicted = xd.predict(found.model, points).frame
    poses = (points["kind"] == "pose").to_numpy()
    for name in ("measured_x_m", "measured_z_m"):
        assert np.abs(predicted[name] - mixed()[name])[poses].max() < 6.0 * NOISE
    assert np.abs(predicted["px_m"] - mixed()["px_m"])[~poses].max() < 6.0 * NOISE


def test_geometry_alone_needs_no_stiffness(tmp_path: Path) -> None:
    """Of an arm that does not yield: the whole of the truth is found."""
    text = f"name: plain\nkind: serial\nurdf: {ROBOT.with_suffix('.urdf')}\nbase_link: base\ntip_link: flange\n"
    (tmp_path / "robot.yaml").write_text(text)
    faults = replace(FAULTS, softness=np.zeros(6))
    found = xd.identify(tmp_path / "robot.yaml", measured(180, faults=faults))
    assert found.result.calibration == "geometric"
    arm = found.result.arm
    assert arm.accuracy["held out", "position"].after.rms < 1.3 * NOISE * np.sqrt(3.0)
    found.save(tmp_path / "out")
    assert xd.predict(tmp_path / "out/model.yaml", measured(6)).frame["spx_m"].max() < NOISE
    with pytest.raises(xd.InputError, match="actuator_stiffness"):
        xd.identify(tmp_path / "robot.yaml", measured(30), calibration="both")


def test_commands_reach_targets_of_the_tip_in_pinocchio(identified: IdentificationResult) -> None:
    """Places of the markers at known configurations are reached again from a posture that is a little off."""
    model, arm = identified.model, Arm(FAULTS)
    reading = model.chain.reading
    assert isinstance(reading, MarkerPosition)
    places = model.values[model.chain.compliances + 6 : model.chain.base].reshape(3, 3)
    commands = np.random.default_rng(9).uniform(
        [-2.0, -2.0, -1.5, -2.0, 0.5, -2.0], [2.0, -0.9, -0.5, 2.0, 2.0, 2.0], (6, 6)
    )
    wanted = [np.array([arm.position(q, PLACES[name]) for name in reading.names]) for q in commands]
    poses = np.array([pose_between(places, points) for points in wanted])
    targets = pd.DataFrame(commands + 0.003, columns=JOINTS)
    targets[["x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad"]] = poses
    found = xd.compensate(model, targets, frame="instrument").frame
    reached = [np.array([arm.position(q, PLACES[name]) for name in reading.names]) for q in found[JOINTS].to_numpy()]
    assert np.abs(np.array(reached) - np.array(wanted)).max() < NOISE
    assert np.abs(found[JOINTS].to_numpy() - commands).max() > 5e-5
    # The nominal controller, asked for the corrected pose, goes to the same joint coordinates.
    nominal = read_robot(ROBOT).position(found[JOINTS].to_numpy())
    np.testing.assert_allclose(found[["controller_x_m", "controller_y_m", "controller_z_m"]], nominal, atol=1e-12)


def pose_between(places: Array, points: Array) -> Array:
    """The rigid motion from markers on the tip to where they are (Kabsch), as x, y, z, rx, ry, rz."""
    centre, middle = places.mean(axis=0), points.mean(axis=0)
    left, _, right = np.linalg.svd((points - middle).T @ (places - centre))
    turn = left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right
    return np.concatenate([middle - turn @ centre, pin.rpy.matrixToRpy(turn)])


def test_joint_columns_alone_are_the_pose_of_the_nominal_robot(identified: IdentificationResult) -> None:
    commands = np.random.default_rng(2).uniform(-1.0, 1.0, (4, 6)) + np.array([0.0, -1.5, 1.0, 0.0, 1.2, 0.0])
    found = xd.compensate(identified.model, pd.DataFrame(commands, columns=JOINTS)).frame
    robot = read_robot(ROBOT)
    np.testing.assert_allclose(found[["target_x_m", "target_y_m", "target_z_m"]], robot.position(commands), atol=1e-12)
    # Own weight alone lowers the tip by more than a tenth of a millimetre, and zeros are off by a milliradian.
    assert np.abs(found[JOINTS].to_numpy() - commands).max() > 1e-3
    assert (found["sx_m"] > 0.0).all()


def test_targets_of_the_tip_in_degrees_are_warned_of(
    identified: IdentificationResult, caplog: pytest.LogCaptureFixture
) -> None:
    pose = {"x_m": -0.4, "y_m": 0.1, "z_m": 0.5, "rx_rad": 1.2, "ry_rad": 0.1, "rz_rad": -0.4}
    xd.compensate(identified.model, pd.DataFrame([pose]))
    assert "degrees" not in caplog.text
    xd.compensate(identified.model, pd.DataFrame([pose | {"rx_rad": np.degrees(1.2)}]))
    assert "targets: rx_rad would be 68.8 rad, i.e. 3.94e+03°. Is it in degrees?" in caplog.text


@pytest.mark.parametrize(
    ("change", "part"),
    [
        ({"px_m": 0.1, "py_m": 0.1, "pz_m": 0.1}, "a position and a pose"),
        ({"measured_rx_rad": None}, "three angles"),
        ({"measured_rx_rad": 120.0}, "cannot be an angle in rad"),
        ({"kind": "posture"}, "neither `pose` nor `position`"),
    ],
)
def test_wrong_rows(change: dict[str, float | str | None], part: str) -> None:
    frame = mixed(12)
    for name, value in change.items():
        frame[name] = frame[name].astype(object)
        frame.loc[0, name] = value
    with pytest.raises(xd.InputError, match=part):
        xd.identify(ROBOT, frame)


@pytest.mark.slow
def test_intervals_cover_the_truth() -> None:
    """200 experiments of 120 positions, with zeros, lengths and angles drawn: 95 ± 1.5 % of all intervals."""
    robot = read_robot(ROBOT)
    assert isinstance(robot, SerialRobot)
    rows = recordings_of(measured(120))
    effect = CalibratedGeometryError(robot, GEOMETRY)
    generator = np.random.default_rng(11)
    start = calibrate(robot, rows, "both")
    reading = start.fit.chain.reading
    chain = Chain(robot, (effect,), reading=reading)
    kept = [int(i) for i in start.minimal.kept if i >= chain.base]
    inside, total = 0, 0
    for _ in range(200):
        truth = start.fit.values.copy()
        truth[: chain.compliances] = np.exp(generator.normal(0.0, 0.3, chain.compliances))
        for index in kept:
            name = chain.parameters[index].name
            size = 4e-4 if name.endswith("_m") else 1.5e-3 if "_offset_" in name else 8e-4
            truth[index] = generator.normal(0.0, size)
        read = chain.predict(row_data(rows, robot), truth) + NOISE * generator.standard_normal(rows.deflections.shape)
        found = calibrate(robot, replace(rows, deflections=read), "both")
        deviation = np.sqrt(np.diag(found.fit.covariance))
        told = [i for i in [*range(chain.compliances), *kept] if found.told_apart[i]]
        inside += int((np.abs(found.fit.values - truth)[told] <= 1.96 * deviation[told]).sum())
        total += len(told)
    assert abs(inside / total - 0.95) < 0.015, inside / total

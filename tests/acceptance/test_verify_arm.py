"""The certificate of an arm: tips that a tracker finds at compensated commands, with pinocchio as the machine."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pinocchio as pin
import pytest

import expdesign as xd
from expdesign.coordinates import SPATIAL
from expdesign.errors import ArgumentError, InputError
from tests.acceptance.verified import commands, model
from tests.acceptance.verified import measured as measured_by_legs
from tests.plant import HIGH, INSTRUMENT, JOINTS, LOW, PLACES, ROBOT, TARGETS, Arm, Faults, configuration, measured
from tests.plant import PLAIN as FAULTS

NOISE = 1e-5
Checks = dict[bool, pd.DataFrame]


@pytest.fixture(scope="module")
def identified() -> xd.IdentificationResult:
    commands = np.random.default_rng(3).uniform(LOW, HIGH, (40, 6))
    return xd.identify(ROBOT, measured(Arm(FAULTS), commands, 1))


def values_of(identified: xd.IdentificationResult) -> dict[str, float]:
    fit = identified.result.fit
    return dict(zip((p.name for p in fit.chain.parameters), fit.values.tolist(), strict=True))


def stand_of(identified: xd.IdentificationResult) -> pin.SE3:
    """The identified instrument in the base's frame."""
    values = values_of(identified)
    turn = pin.rpy.rpyToMatrix(*(values[f"instrument r{axis}_rad"] for axis in "xyz"))
    return pin.SE3(turn, np.array([values[f"instrument {axis}_m"] for axis in "xyz"]))


def checked(identified: xd.IdentificationResult, faults: Faults = FAULTS, *, compensated: bool = True) -> pd.DataFrame:
    """Readings of the tip's pose in the base's frame at the commands, ten of every target.

    Where the base is, is where the identified instrument says: the first joint's frame is the instrument's.
    """
    arm, random = Arm(faults), np.random.default_rng(7)
    frame = pd.concat([xd.compensate(identified, configuration(20)).frame] * 10, ignore_index=True)
    if not compensated:
        frame[JOINTS] = np.tile(TARGETS, (10, 1))
    values, stand = values_of(identified), stand_of(identified)
    markers = np.array([[values[f"marker {name} {axis}_m"] for axis in "xyz"] for name in PLACES])
    for row, command in enumerate(frame[JOINTS].to_numpy()):
        seen = np.array([stand.act(arm.position(command, place)) for place in PLACES.values()])
        left, _, right = np.linalg.svd((seen - seen.mean(axis=0)).T @ (markers - markers.mean(axis=0)))
        turn = left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right
        place = seen.mean(axis=0) - turn @ markers.mean(axis=0) + NOISE * random.standard_normal(3)
        for axis, value in zip("xyz", place, strict=True):
            frame.loc[row, f"measured_{axis}_m"] = value
        turn = pin.exp3(1e-4 * random.standard_normal(3)) @ turn
        for axis, value in zip("xyz", pin.rpy.matrixToRpy(turn), strict=True):
            frame.loc[row, f"measured_r{axis}_rad"] = value
    frame[["sx_m", "sy_m", "sz_m"]] = NOISE
    frame[["srx_rad", "sry_rad", "srz_rad"]] = 1e-4
    return frame.assign(sequence=range(1, len(frame) + 1), series=range(1, len(frame) + 1))


@pytest.fixture(scope="module")
def checks(identified: xd.IdentificationResult) -> Checks:
    """Of the arm that was identified, at compensated commands or not; tests change copies of them."""
    return {compensated: checked(identified, compensated=compensated) for compensated in (True, False)}


def test_an_arm_passes_with_its_commands_and_fails_without(identified: xd.IdentificationResult, checks: Checks) -> None:
    assert np.isfinite(INSTRUMENT.translation).all()
    config = configuration(20)
    passed = xd.verify(identified, checks[True], config=config).result
    assert passed.verdict == "pass"
    assert passed.consistent
    failed = xd.verify(identified, checks[False], config=config).result
    assert failed.verdict == "fail"
    assert failed.consistent  # the model knows where the arm goes at the nominal commands


def test_another_arm_is_not_what_the_model_predicts(identified: xd.IdentificationResult, checks: Checks) -> None:
    other = replace(FAULTS, zeros=FAULTS.zeros + 1e-3)
    verified = xd.verify(identified, checked(identified, other), config=configuration(20))
    found = verified.result
    assert found.verdict == "fail"
    assert not found.consistent
    assert "give the frame `instrument`" in verified.said.notes[-1]
    good = xd.verify(identified, checks[True], config=configuration(20))
    assert not any("--frame" in note for note in good.said.notes)


def test_targets_in_a_base_whose_turn_no_reading_shows_say_so(identified: xd.IdentificationResult) -> None:
    """U of a target is of the tip as seen from joint 1 as drawn; the instrument's frame needs no such word."""
    said = [xd.compensate(identified, configuration(20), frame=frame).said for frame in ("base", "instrument")]
    assert ["as drawn" in "".join(one.lines) for one in said] == [True, False]


def test_an_orientation_has_three_angles(identified: xd.IdentificationResult, checks: Checks) -> None:
    frame = checks[True].drop(columns=["measured_rx_rad"])
    with pytest.raises(InputError, match="three angles"):
        xd.verify(identified, frame, config=configuration(20))


def in_instrument(frame: pd.DataFrame, stand: pin.SE3) -> pd.DataFrame:
    """Targets and measured poses seen from the instrument."""
    found = frame.copy()
    for kind in ("target", "measured"):
        names = [f"{kind}_{name}" for name in SPATIAL.pose]
        poses = frame[names].to_numpy()
        seen = [stand.actInv(pin.SE3(pin.rpy.rpyToMatrix(*pose[3:]), pose[:3])) for pose in poses]
        found[names] = [[*one.translation, *pin.rpy.matrixToRpy(one.rotation)] for one in seen]
    return found


def test_targets_of_joints_are_written_in_the_frame_that_is_asked_for(
    identified: xd.IdentificationResult, checks: Checks
) -> None:
    """They had the poses of the base's frame in it, which `verify` then refused."""
    found = xd.compensate(identified, configuration(20), frame="instrument").frame
    base = checks[True].iloc[: len(found)]
    names = [f"target_{name}" for name in SPATIAL.pose]
    seen = in_instrument(base, stand_of(identified))
    np.testing.assert_allclose(found[names], seen[names], atol=1e-11)
    np.testing.assert_allclose(found[JOINTS], base[JOINTS], atol=1e-11)


@pytest.mark.parametrize("compensated", [True, False])
def test_a_certificate_in_the_instruments_frame_is_that_in_the_base(
    identified: xd.IdentificationResult, checks: Checks, compensated: bool
) -> None:
    config, stand = configuration(20), stand_of(identified)
    in_base = checks[compensated]
    base = xd.verify(identified, in_base, config=config)
    seen = in_instrument(in_base, stand)
    assert np.abs(seen["target_x_m"] - in_base["target_x_m"]).min() > 0.1
    found = xd.verify(identified, seen, config=config, frame="instrument")
    assert found.result.verdict == base.result.verdict == ("pass" if compensated else "fail")
    one, other = found.result.comparison, base.result.comparison
    np.testing.assert_allclose(one.attained, other.attained, atol=1e-11)
    # The place of the target rests on the instrument's, which the base's axes do not show.
    np.testing.assert_allclose(one.predicted, other.predicted, atol=1e-11)
    np.testing.assert_allclose(one.noise, other.noise, atol=1e-15)
    assert found.result.consistent
    assert found.record["frame"] == "instrument"
    assert "frame" not in base.record
    # The standard deviations are along the axes of the instrument, those of the errors along the base's.
    uneven = np.array([1e-5, 2e-5, 4e-5])
    seen[["sx_m", "sy_m", "sz_m"]] = uneven
    turned = xd.verify(identified, seen, config=config, frame="instrument").result.targets[0]
    expected = np.sqrt(np.diag(stand.rotation @ np.diag(uneven**2) @ stand.rotation.T) / 10.0)
    np.testing.assert_allclose(turned.uncertainty[:3], expected, rtol=1e-9)


def test_positions_alone_are_verified_in_the_instruments_frame(
    identified: xd.IdentificationResult, checks: Checks
) -> None:
    in_base = checks[True]
    angles = [f"measured_r{axis}_rad" for axis in "xyz"]
    base = xd.verify(identified, in_base.drop(columns=angles)).result
    seen = in_instrument(in_base, stand_of(identified)).drop(columns=angles)
    found = xd.verify(identified, seen, frame="instrument").result
    np.testing.assert_allclose(found.comparison.attained, base.comparison.attained, atol=1e-11)
    with pytest.raises(InputError, match="three coordinates"):
        xd.verify(identified, seen.drop(columns="measured_z_m"), frame="instrument")


def test_frames_that_cannot_be_meant(identified: xd.IdentificationResult, checks: Checks) -> None:
    check = checks[True]
    with pytest.raises(ArgumentError, match="`tracker` is not known"):
        xd.verify(identified, check, frame="tracker")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="m from its target in the frame of the instrument"):
        xd.verify(identified, check, frame="instrument")
    with pytest.raises(InputError, match="m from its target in the frame of the base"):
        xd.verify(identified, in_instrument(check, stand_of(identified)))
    names = [name for name in check if str(name).startswith("measured_")]
    deflections = check.drop(columns=names).assign(dx_m=0.0, dy_m=0.0, dz_m=0.0)
    with pytest.raises(ArgumentError, match="only measured poses"):
        xd.verify(identified, deflections, frame="instrument")
    with pytest.raises(ArgumentError, match="the model knows no instrument"):
        xd.verify(model(), measured_by_legs(commands(1), np.random.default_rng(1)), frame="instrument")


def test_cartesian_targets_are_verified_as_joint_targets_are(
    identified: xd.IdentificationResult, checks: Checks
) -> None:
    """Commands for the poses that the nominal arm has at the targets; tolerances stand in the file of targets."""
    robot = identified.result.fit.chain.robot
    places, turns = robot.position(TARGETS), robot.jacobians(TARGETS).rotation
    angles = np.array([pin.rpy.matrixToRpy(turn) for turn in turns])
    names = ["x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad"]
    frame = pd.DataFrame(np.column_stack([places, angles]), columns=names)
    frame[JOINTS] = TARGETS  # the posture
    tolerances = dict.fromkeys(("tolerance_dx_m", "tolerance_dy_m", "tolerance_dz_m"), 1e-4)
    frame = frame.assign(sequence=range(1, 4), series=range(1, 4), **tolerances)
    commands = xd.compensate(identified, frame).frame
    np.testing.assert_allclose(commands[[f"target_q{k}_rad" for k in range(1, 7)]], TARGETS, atol=1e-8)
    by_joints = checks[True]
    own = [*JOINTS, *(f"target_{name}" for name in names)]
    np.testing.assert_allclose(commands[own], by_joints[own][:3], atol=1e-7)
    readings = [str(name) for name in by_joints if str(name).startswith("measured_")]
    check = commands.assign(**{name: by_joints[name][:3].to_numpy() for name in readings})
    check = check.assign(**dict.fromkeys(("sx_m", "sy_m", "sz_m"), NOISE))
    check = check.assign(**dict.fromkeys(("srx_rad", "sry_rad", "srz_rad"), 1e-4))
    found = xd.verify(identified, check).result
    assert found.consistent
    assert found.verdict == "pass"

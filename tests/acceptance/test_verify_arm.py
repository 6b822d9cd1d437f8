"""The certificate of an arm: tips that a tracker finds at compensated commands, with pinocchio as the machine."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pinocchio as pin
import pytest
from benchmarks.arms.plans import HIGH, LOW, ROBOT, TARGETS, configuration, measured
from benchmarks.arms.plant import INSTRUMENT, PLACES, Arm, usual_faults

import expdesign as xd
from expdesign.errors import InputError

FAULTS = replace(usual_faults(3, tool=0.0), periodic=(0.0, 0.0))
NOISE = 1e-5


@pytest.fixture(scope="module")
def identified() -> xd.IdentificationResult:
    commands = np.random.default_rng(3).uniform(LOW, HIGH, (40, 6))
    return xd.identify(ROBOT, measured(Arm(FAULTS), commands, 1))


def checked(identified: xd.IdentificationResult, faults: object, *, compensated: bool = True) -> pd.DataFrame:
    """Readings of the tip's pose in the base's frame at the commands, ten of every target.

    Where the base is, is where the identified instrument says: the first joint's frame is the instrument's.
    """
    arm, random = Arm(faults), np.random.default_rng(7)  # type: ignore[arg-type]
    frame = pd.concat([xd.compensate(identified, configuration(20)).frame] * 10, ignore_index=True)
    if not compensated:
        frame[[f"q{k}_rad" for k in range(1, 7)]] = np.tile(TARGETS, (10, 1))
    fit = identified.result.fit
    values = dict(zip((p.name for p in fit.chain.parameters), fit.values, strict=True))
    stand = pin.SE3(
        pin.rpy.rpyToMatrix(*(values[f"instrument r{axis}_rad"] for axis in "xyz")),
        np.array([values[f"instrument {axis}_m"] for axis in "xyz"]),
    )
    markers = np.array([[values[f"marker {name} {axis}_m"] for axis in "xyz"] for name in PLACES])
    for row, command in enumerate(frame[[f"q{k}_rad" for k in range(1, 7)]].to_numpy()):
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


def test_an_arm_passes_with_its_commands_and_fails_without(identified: xd.IdentificationResult) -> None:
    assert np.isfinite(INSTRUMENT.translation).all()
    config = configuration(20)
    passed = xd.verify(identified, checked(identified, FAULTS), config=config).result
    assert passed.verdict == "pass"
    assert passed.consistent
    failed = xd.verify(identified, checked(identified, FAULTS, compensated=False), config=config).result
    assert failed.verdict == "fail"
    assert failed.consistent  # the model knows where the arm goes at the nominal commands


def test_another_arm_is_not_what_the_model_predicts(identified: xd.IdentificationResult) -> None:
    other = replace(FAULTS, zeros=FAULTS.zeros + 1e-3)
    found = xd.verify(identified, checked(identified, other), config=configuration(20)).result
    assert found.verdict == "fail"
    assert not found.consistent


def test_an_orientation_has_three_angles(identified: xd.IdentificationResult) -> None:
    frame = checked(identified, FAULTS).drop(columns=["measured_rx_rad"])
    with pytest.raises(InputError, match="three angles"):
        xd.verify(identified, frame, config=configuration(20))


def test_cartesian_targets_are_verified_as_joint_targets_are(identified: xd.IdentificationResult) -> None:
    """Commands for the poses that the nominal arm has at the targets; tolerances stand in the file of targets."""
    robot = identified.result.fit.chain.robot
    places, turns = robot.position(TARGETS), robot.jacobians(TARGETS).rotation
    angles = np.array([pin.rpy.matrixToRpy(turn) for turn in turns])
    names = ["x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad"]
    frame = pd.DataFrame(np.column_stack([places, angles]), columns=names)
    frame[[f"q{k}_rad" for k in range(1, 7)]] = TARGETS  # the posture
    tolerances = dict.fromkeys(("tolerance_dx_m", "tolerance_dy_m", "tolerance_dz_m"), 1e-4)
    frame = frame.assign(sequence=range(1, 4), series=range(1, 4), **tolerances)
    commands = xd.compensate(identified, frame).frame
    np.testing.assert_allclose(commands[[f"target_q{k}_rad" for k in range(1, 7)]], TARGETS, atol=1e-8)
    by_joints = checked(identified, FAULTS)
    own = [*(f"q{k}_rad" for k in range(1, 7)), *(f"target_{name}" for name in names)]
    np.testing.assert_allclose(commands[own], by_joints[own][:3], atol=1e-7)
    readings = [str(name) for name in by_joints if str(name).startswith("measured_")]
    check = commands.assign(**{name: by_joints[name][:3].to_numpy() for name in readings})
    check = check.assign(**dict.fromkeys(("sx_m", "sy_m", "sz_m"), NOISE))
    check = check.assign(**dict.fromkeys(("srx_rad", "sry_rad", "srz_rad"), 1e-4))
    found = xd.verify(identified, check).result
    assert found.consistent
    assert found.verdict == "pass"

"""Groups of an arm's errors: their sizes, and corrections that no machine needs (pinocchio is the machine)."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import expdesign as xd
from expdesign.errors import InputError
from expdesign.estimation.arm_options import Held
from expdesign.report.identification_report import IdentificationResult
from expdesign.report.words import size
from tests.plant import PLAIN, ROBOT, Faults, recordings, usual_faults

EVERYTHING = replace(usual_faults(4, tool=0.0), periodic=(0.0, 0.0))


ZEROS = replace(EVERYTHING, placements=np.zeros((6, 6)))


def identified(faults: Faults, *hold: Held) -> IdentificationResult:
    """From 80 positions of three markers, noise of 30 µm, and 40 others that are held out."""
    frame = recordings(faults, 120, 8, loads=False)
    return xd.identify(ROBOT, frame.assign(split=np.where(np.arange(120) < 80, "train", "test")), hold=hold)


def level(found: IdentificationResult, name: str) -> float:
    """Size of a group in that with which arms are made."""
    (one,) = [each for each in found.result.arm.levels if each.name == name]
    return one.size / one.made


@pytest.fixture(scope="module")
def zeros() -> IdentificationResult:
    return identified(ZEROS)


def test_a_group_in_which_nothing_is_wrong_stays_at_the_drawing(zeros: IdentificationResult) -> None:
    wrong, right = identified(EVERYTHING), zeros
    for name in ("lengths", "angles"):
        assert level(right, name) < 0.05
        assert level(wrong, name) > 0.1
    assert level(right, "zeros") == pytest.approx(0.1, abs=0.08)  # 1 mrad of 10
    assert level(right, "compliances") == pytest.approx(0.2 / 3.0, abs=0.08)
    assert any(line.startswith("Size of the errors by group") for line in right.lines)


def test_what_the_others_show_says_nothing_of_a_joint_that_carries_nothing(zeros: IdentificationResult) -> None:
    """Joint 1 stands upright: gravity does not turn it, and its compliance is known as well as it was drawn."""
    upright, loaded = np.sqrt(np.diag(zeros.model.covariance))[:2]
    assert loaded < 0.2
    assert upright == pytest.approx(3.0, rel=0.05)


def test_a_held_group_is_as_drawn_and_says_so() -> None:
    found = identified(ZEROS, "lengths", "angles")
    frame = found.geometry
    assert frame is not None
    held = np.array(["offset" not in name for name in frame.index])
    assert (frame["estimate"].to_numpy()[held] == 0.0).all()
    assert (frame["estimate"].to_numpy()[~held] != 0.0).sum() >= 4
    record = found.record["arm"]
    assert {each["status"] for each in record["parameters"] if "offset" not in each["name"]} == {"held"}
    assert [each["size"] for each in record["groups"] if each["name"] in ("lengths", "angles")] == [0.0, 0.0]
    accuracy = found.result.arm.accuracy["held out", "position"]
    assert accuracy.after.rms < 6e-5
    assert accuracy.before.rms > 5e-4


def test_compliances_are_held_at_the_robot_file() -> None:
    found = identified(replace(ZEROS, softness=np.ones(6)), "compliances")
    np.testing.assert_allclose(found.result.fit.values[:6], 1.0)


def test_what_cannot_be_held_is_refused() -> None:
    with pytest.raises(InputError, match="`masses` is not in the list"):
        xd.identify(ROBOT, recordings(ZEROS, 30, 8, loads=False), hold=["masses"])  # type: ignore[list-item]


@cache
def read(zero: float) -> xd.IdentificationResult:
    """Joint 3's mark is off by `zero` (rad)."""
    zeros = PLAIN.zeros + zero * (np.arange(6) == 2)
    return xd.identify(ROBOT, recordings(replace(PLAIN, zeros=zeros), 90, 7, markers=2, loads=False))


def test_a_zero_beyond_manufacture_comes_first_and_into_no_urdf(tmp_path: Path) -> None:
    found = read(0.12)
    first = found.said.sentences[0]
    assert first.startswith("Corrections beyond manufacture: joint 3's zero 119 mrad")
    assert found.refused
    found.save(tmp_path / "out")
    assert not (tmp_path / "out/robot.urdf").exists()
    assert (tmp_path / "out/model.yaml").exists()


def test_corrections_that_are_accepted_are_written(tmp_path: Path) -> None:
    found = replace(read(0.12), accepted=True)
    assert not found.refused
    found.save(tmp_path / "out")
    assert (tmp_path / "out/robot.urdf").exists()
    assert found.said.sentences[0].startswith("Corrections beyond manufacture")


def test_usual_errors_of_manufacture_are_written() -> None:
    found = read(0.0)
    assert not found.refused
    assert found.urdf is not None
    assert "beyond manufacture" not in " ".join(found.said.sentences)


@pytest.mark.parametrize(("value", "says"), [(0.976, "976 mrad"), (-1.02, "-1.02 rad"), (2e-5, "20 µrad")])
def test_a_radian_is_no_thousand_milliradians(value: float, says: str) -> None:
    assert size(value, "rad") == says

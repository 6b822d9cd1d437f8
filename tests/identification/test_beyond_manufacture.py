"""Corrections that no machine needs are named before anything else, and written where somebody accepts them."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import expdesign as xd
from expdesign.report.words import size
from tests.plant import PLAIN, ROBOT, recordings


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

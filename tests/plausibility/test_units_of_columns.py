"""One column of readings in another unit is asked about where it moves as much as that unit says, and only there."""

from dataclasses import replace

import numpy as np
import pytest

from expdesign.assurance.plausibility.evidence import evidence_of
from expdesign.assurance.plausibility.mistakes.columns import units_of_readings
from expdesign.assurance.plausibility.recordings import recordings_findings
from tests.identification.experiments import experiment


@pytest.mark.parametrize(("factor", "asked"), [(1.0, False), (5.0, False), (1e3, True)])
def test_a_column_is_asked_about_by_how_far_it_moves(factor: float, asked: bool) -> None:
    made = experiment("H1", 24, seed=3)
    deflections = made.noisy(np.random.default_rng(1))
    deflections[:, 0] *= factor
    evidence = evidence_of(made.recordings(deflections), made.robot)
    assert ("Is dx_m in mm?" in {each.sentence for each in units_of_readings(evidence)}) == asked


def test_a_drift_of_an_axis_that_hardly_moves_is_no_unit() -> None:
    made = experiment("H1", 24, seed=3)
    deflections = made.noisy(np.random.default_rng(1))
    deflections[:, 0] = 60.0 * np.abs(deflections[:, 1:3]).max() * np.linspace(-0.02, 0.02, len(deflections))
    findings = recordings_findings(made.recordings(deflections), made.robot)
    assert not [finding for finding in findings if "dx_m in" in finding.likely]


def test_the_unit_is_that_of_the_numbers_in_the_file() -> None:
    """µm that were typed into a column named for mm are asked about as µm, whatever the reader has made of them."""
    made = experiment("H1", 24, seed=3)
    deflections = made.noisy(np.random.default_rng(1))
    deflections[:, :3] *= 1e3
    recordings = made.recordings(deflections)
    for written, question in (
        ({}, "Are the translations in mm? Write the unit into the columns' names, as in `dx_mm`."),
        (
            {f"d{axis}_m": f"reading_{axis}_mm" for axis in "xyz"},
            "Are the translations in µm? Write the unit into the columns' names, as in `reading_x_µm`.",
        ),
    ):
        findings = recordings_findings(replace(recordings, written=written), made.robot)
        assert [finding.likely for finding in findings if finding.likely.startswith(question)]

"""One column of readings in another unit is asked about where it moves as much as that unit says, and only there."""

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

"""Appendix B: what G_C makes of errors, whatever root of the covariance is taken."""

import numpy as np
import pytest

from research.studies.making import prepare
from research.studies.scaled_errors import ScaledErrors, corrected_limit
from research.studies.tests.kept import CONFIGURATIONS, kept, problem_of

STUDY = ScaledErrors.name()


def test_correlations_are_the_expected_ones() -> None:
    rows = kept(STUDY, "correlations")
    score = (rows["correlation"] - rows["correlation_expected"]) / rows["correlation_se"]
    assert np.abs(score).max() < corrected_limit(len(rows))
    assert 0.8 < score.std() < 1.2
    white = rows[rows["scaling"] == "G_C"]
    assert (white["correlation_expected"] == 0.0).all()
    # The whole set at once: N·Σr² of independent components is χ² with one degree of freedom per pair.
    samples = prepare(STUDY, CONFIGURATIONS).settings.samples
    statistic = samples * (white["correlation"] ** 2).sum()
    assert abs(statistic - len(white)) < 3.0 * np.sqrt(2.0 * len(white))


def test_standard_deviations_alone_leave_the_correlations_of_shared_readings() -> None:
    rows = kept(STUDY, "correlations").query("scaling == 'G_U'").set_index(["first", "second"])["correlation_expected"]
    for axis in ("dx", "dy", "dz", "drx", "dry", "drz"):
        assert rows[f"{axis} 1", f"{axis} 2"] == pytest.approx(0.5, abs=1e-4)  # half the variance is common
        assert rows[f"{axis} 1", f"{axis} 3"] == 0.0
    assert np.abs(rows).max() > 0.8


def test_any_root_gives_the_same_estimate() -> None:
    """G is defined up to a rotation: GᵀG = V⁻¹ is all that the estimator sees (theory.md 3, remark i)."""
    problem = problem_of(STUDY)
    pose = np.array([0.01, -0.02, 0.0, 0.1, -0.05, 0.1])
    whitener = problem.noise.whitener_at(problem.loaded.robot.jacobians(pose).pose)
    covariance = np.linalg.inv(whitener.T @ whitener)
    values, vectors = np.linalg.eigh(covariance)
    other = (vectors / np.sqrt(values)).T
    np.testing.assert_allclose(other @ covariance @ other.T, np.eye(6), atol=1e-9)
    np.testing.assert_allclose(whitener @ covariance @ whitener.T, np.eye(6), atol=1e-9)
    assert np.abs(other - whitener).max() > 1e-3 * np.abs(whitener).max()
    load = np.array([26.5, 0.05, 0.02, 0.1, 0.0, 0.0, -9.80665])
    regressor = problem.loaded.measure(pose, load).observation
    reading = np.array([1e-6, -2e-6, 3e-6, 4e-6, 5e-6, -6e-6])
    estimates = [np.linalg.lstsq(g @ regressor, g @ reading)[0] for g in (whitener, other)]
    np.testing.assert_allclose(estimates[0], estimates[1], rtol=1e-8)


def test_limit_for_many_comparisons() -> None:
    assert corrected_limit(1) == pytest.approx(3.0)
    assert corrected_limit(306) == pytest.approx(4.45, abs=0.02)

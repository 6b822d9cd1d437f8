"""Load errors that a configuration declares are no missing physics (theory.md 5.6)."""

from typing import Any

import numpy as np
import pytest
from tests.acceptance.test_acceptance import plan_for
from tests.design.problems import BIPOD, HEXAPOD, problem

import expdesign as xd
from expdesign.estimation.identify import identify
from expdesign.estimation.whitening import Whitening
from expdesign.planning.plan import plan_frame

LARGE = [
    {"source": "mass", "std": 0.5, "shared": True},
    {"source": "com", "std": [0.02, 0.02, 0.02], "shared": False},
]
"""Errors that move the readings by many times their noise."""
CASES: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "bipod-wrench": (BIPOD, {"experiment.measurements": 6}),
    "hexapod-payload": (HEXAPOD, {"experiment.measurements": 6, "experiment.load_error": LARGE}),
}


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("shared_reference", [False, True])
def test_chi2_is_that_of_generalised_least_squares(name: str, shared_reference: bool) -> None:
    base, changes = CASES[name]
    case = problem(base, changes)
    recorded = xd.simulate(case, plan_frame(plan_for(case, 2), case.loaded, False), seed=3).frame
    result = xd.identify(base["robot"], recorded, shared_reference=shared_reference).result
    train = result.recordings.rows(result.fitted)
    whitening = Whitening(result.noise.deviations, references=train.references)
    errors = case.load_errors
    fell = errors.explained(result.fit, train, whitening)

    # The covariance of all readings written out, and the same model fitted with it.
    count, readings = train.deflections.shape
    size = count * readings
    inverse_root = whitening.apply(np.eye(size).reshape(count, readings, size)).reshape(size, size)
    covariance = np.linalg.inv(inverse_root.T @ inverse_root)
    for source, moved in zip(case.loaded.sources, errors.readings(result.fit, train), strict=True):
        for component in moved.transpose(2, 0, 1):
            if source.shared:
                covariance += np.outer(component.ravel(), component.ravel())
            else:
                covariance += sum(np.outer(row, row) for row in _alone(component))
    root = np.linalg.cholesky(covariance)
    whitened = result.fit.sensitivities.reshape(size, -1)
    sensitivities = np.linalg.solve(root, np.linalg.solve(inverse_root, whitened))
    target = np.linalg.solve(root, train.deflections.ravel())
    remaining = target - sensitivities @ np.linalg.lstsq(sensitivities, target, rcond=None)[0]
    assert remaining @ remaining == pytest.approx(float((result.fit.residuals**2).sum()) - fell, rel=1e-6)
    assert fell > 0.0


def _alone(component: np.ndarray[tuple[int, int], np.dtype[np.float64]]) -> np.ndarray[Any, Any]:
    """Each row of (N, k) with zeros for the others, flattened: (N, N·k)."""
    count, readings = component.shape
    rows = np.zeros((count, count, readings))
    rows[np.arange(count), np.arange(count)] = component
    return rows.reshape(count, -1)


def test_declared_errors_do_not_refute_a_model() -> None:
    """With exact loads χ²/ν is far above 1, with the declared errors 1 within 4 standard errors (24 repetitions)."""
    base, changes = CASES["hexapod-payload"]
    case = problem(base, changes)
    plan = plan_frame(plan_for(case, 2), case.loaded, False)
    exact, allowing = [], []
    for seed in range(24):
        recorded = xd.identify(base["robot"], xd.simulate(case, plan, seed=seed).frame).result.recordings
        goodness = identify(case.loaded.robot, recorded, load_errors=case.load_errors).goodness
        assert goodness.chi2 is not None
        assert goodness.without_load_errors is not None
        exact.append(goodness.without_load_errors / goodness.dof)
        allowing.append(goodness.chi2 / goodness.dof)
    assert np.mean(exact) > 3.0
    assert np.mean(allowing) == pytest.approx(1.0, abs=4.0 * np.sqrt(2.0 / (24 * goodness.dof)))


def test_a_diagnosis_looks_for_nothing_that_declared_errors_account_for() -> None:
    base, changes = CASES["hexapod-payload"]
    case = problem(base, changes)
    recorded = xd.simulate(case, plan_frame(plan_for(case, 2), case.loaded, False), seed=3).frame
    found = xd.diagnose(base["robot"], recorded, targets=case)
    assert found.record["verdict"] == "consistent"
    assert found.result.before.without_load_errors is not None
    assert xd.identify(base["robot"], recorded).result.goodness.refuted

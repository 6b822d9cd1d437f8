"""Study 2 against the closed form of one measurement, Z = −J_D·diag(c·τ_D/τ_M)·J_Mᵀ (theory.md 5.1)."""

import numpy as np
import pytest

from expdesign.assurance.validation.simulation import simulate
from research.studies.bipod_feir import BipodFeir
from research.studies.position_maps import plan_at
from research.studies.tests.kept import kept, problem_of

STUDY = BipodFeir.name()
BASE, LOAD = np.array([[-0.5, 0.0], [0.5, 0.0]]), np.array([0.0, -1000.0])
COMPLIANCE = np.array([1e-7, 1.0 / 1.3e7])


def jacobian(point: np.ndarray) -> np.ndarray:
    vectors = point - BASE
    return np.linalg.inv(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


def sensitivity(x: float, y: float) -> np.ndarray:
    target, here = jacobian(np.array([0.10, 0.60])), jacobian(np.array([x, y + 0.65]))
    ratio = COMPLIANCE * (target.T @ LOAD) / (here.T @ LOAD)
    return -target @ np.diag(ratio) @ here.T


def test_maps_are_the_closed_form() -> None:
    for row in kept(STUDY, "map").iloc[::41].itertuples():
        zeta = 1e6 * 5.0 * np.linalg.norm(sensitivity(row.x_m, row.y_m), axis=1)  # type: ignore[arg-type]
        assert (row.zeta1_um, row.zeta2_um) == pytest.approx(tuple(zeta), rel=1e-4)


def test_at_the_target_only_its_own_compliance_is_left() -> None:
    """X_M = X_D: Z = −D_D, whose entries are the test vector of theory.md 11."""
    row = kept(STUDY, "montecarlo").query("x_m == 0.1 and y_m == -0.05").iloc[0]
    compliance = np.array([[0.112, 0.008], [0.008, 0.072]])  # µm/N
    zeta = 5.0 * np.linalg.norm(compliance, axis=1)
    assert (row["x_um_predicted"], row["y_um_predicted"]) == pytest.approx(tuple(zeta), rel=1e-5)


def test_uniform_errors_stay_within_the_bound_and_come_near_it() -> None:
    problem = problem_of(STUDY)
    plan = plan_at(problem, np.array([-0.25, -0.25]))
    result = simulate(problem, plan, 20_000, 1, noise=False, distribution="uniform")
    bound = np.abs(sensitivity(-0.25, -0.25)) @ np.full(2, 5.0 * np.sqrt(3.0))
    largest = np.abs(result.errors[:, 0]).max(axis=0)
    assert (largest <= bound * (1.0 + 1e-3)).all()  # the compensation is exact, the bound of first order
    assert (largest >= 0.95 * bound).all()

"""Study 1 against the closed form of one measurement (theory.md 4.2) and against the reconstruction's figures."""

import numpy as np
import pytest

from expdesign.mechanics.robots.parallel import ParallelRobot
from research.studies.bipod_duir import BipodDuir
from research.studies.position_maps import plan_at
from research.studies.tests.kept import kept, problem_of
from tests import oracle

STUDY = BipodDuir.name()


def test_map_is_the_closed_form() -> None:
    """U = Θ·Θᵀ with Θ = J_D·diag(τ_D/τ_M)·J_M⁻¹."""
    base, load = np.array([[-0.5, 0.0], [0.5, 0.0]]), np.array([0.0, -1000.0])

    def legs(point: np.ndarray) -> np.ndarray:
        vectors = point - base
        return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)

    target = np.linalg.inv(legs(np.array([0.10, 0.60])))
    for row in kept(STUDY, "map").iloc[::37].itertuples():
        inverse = legs(np.array([row.x_m, row.y_m + 0.65]))
        ratio = (target.T @ load) / (np.linalg.inv(inverse).T @ load)
        theta = target @ np.diag(ratio) @ inverse
        assert row.u11 == pytest.approx((theta @ theta.T)[0, 0], rel=1e-4)


def test_figures_of_the_reconstruction() -> None:
    u11 = kept(STUDY, "best").set_index("criterion")["u11"]
    assert u11["u11"] == pytest.approx(0.679, abs=5e-4)
    assert [round(u11[name], 3) for name in ("o1", "o3", "o5")] == [0.884] * 3
    assert [round(u11[name], 3) for name in ("o2", "o4")] == [1.002] * 2
    assert u11["o_tp"] == u11["o_mv"] == pytest.approx(0.885, abs=6e-4)
    stated = kept(STUDY, "montecarlo").dropna(subset="theory_um")
    assert len(stated) == 4
    np.testing.assert_allclose(stated["std_um_predicted"], stated["theory_um"], atol=6e-4)


def test_oracle_agrees_at_a_position() -> None:
    """The assessment of the study's problem beside the dense oracle of the tests."""
    problem = problem_of(STUDY)
    plan = plan_at(problem, np.array([-0.2, -0.1]))
    robot = problem.loaded.robot
    assert isinstance(robot, ParallelRobot)
    a = oracle.observation(robot, plan.configurations, plan.loads)[0]
    target = problem.targets.observation[0]
    expected = target @ np.linalg.inv(a.T @ a * 1e12) @ target.T
    root = problem.assess(plan.configurations[None], plan.loads[None]).noise_root[0, 0]
    np.testing.assert_allclose(root @ root.T, expected, rtol=1e-9)

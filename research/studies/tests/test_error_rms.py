"""Appendices E and F: the identity by its own algebra, and what the trace is of."""

import numpy as np
import pytest

from expdesign.assurance.validation.simulation import simulate
from expdesign.planning.problem_file import read_problem
from research.studies.error_rms import ErrorRms, Settings, _plans
from research.studies.making import prepare
from research.studies.tests.kept import CONFIGURATIONS, kept


def test_trace_is_that_of_u_and_of_z() -> None:
    """√tr(tA_D·M⁻¹·tA_Dᵀ) and √tr(tZ·Σ_F·tZᵀ) from the matrices of the evaluation, beside the kept table."""
    here = prepare(ErrorRms.name(), CONFIGURATIONS)
    assert isinstance(here.settings, Settings)
    problem = read_problem(here.document.folder / here.settings.configuration)
    plan = _plans(problem, here.settings)[1]
    assessment = problem.assess(plan.configurations[None], plan.loads[None], plan.series[None])
    a = problem.loaded.measure(plan.configurations, plan.loads).observation
    weight = np.linalg.inv(problem.noise.covariance)
    target = problem.targets.observation[0]
    information = np.einsum("mip,ij,mjq->pq", a, weight, a)
    scale = 1.0 / np.sqrt(np.diag(information))
    inverse = np.linalg.inv(information * np.outer(scale, scale)) * np.outer(scale, scale)
    covariance = target @ inverse @ target.T
    z = assessment.force_sensitivity()[0, 0]
    rotation = problem.loaded.robot.jacobians(plan.configurations).rotation
    spread = np.zeros((z.shape[1], z.shape[1]))
    for source, error in zip(problem.loaded.sources, problem.loaded.load_errors(rotation, plan.loads)):
        stacked = error.reshape(-1, error.shape[-1])
        block = stacked @ stacked.T
        if not source.shared:
            same = np.kron(np.eye(len(plan)), np.ones((6, 6)))
            block = block * same
        spread += block
    rows = kept(ErrorRms.name(), "rms")
    table = rows[rows["plan"] == 2].set_index(["cause", "part"])["rms_predicted"]
    for part, axes in (("translation", slice(0, 3)), ("rotation", slice(3, 6))):
        noise = 1e6 * np.sqrt(np.trace(covariance[axes, axes]))
        load = 1e6 * np.sqrt(np.trace((z @ spread @ z.T)[axes, axes]))
        assert table["noise", part] == pytest.approx(noise, rel=1e-5)
        assert table["normal load errors", part] == pytest.approx(load, rel=1e-5)
        assert table["uniform load errors", part] == table["normal load errors", part]


def test_identity_holds_for_every_set_of_errors() -> None:
    """mean ‖e‖² = tr Cov + ‖mean‖² exactly, so that RMS and trace differ by the mean alone."""
    here = prepare(ErrorRms.name(), CONFIGURATIONS)
    assert isinstance(here.settings, Settings)
    problem = read_problem(here.document.folder / here.settings.configuration)
    errors = simulate(problem, _plans(problem, here.settings)[0], 2000, 3).errors[:, 1, :3]
    centred = errors - errors.mean(axis=0)
    trace = (centred**2).mean(axis=0).sum()
    assert (errors**2).sum(axis=1).mean() == pytest.approx(trace + (errors.mean(axis=0) ** 2).sum(), rel=1e-12)

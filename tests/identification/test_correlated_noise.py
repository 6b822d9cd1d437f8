"""A configuration's covariance of the noise is one for plan, fit and the next measurement."""

from functools import cache

import numpy as np
import pandas as pd
import pytest

import expdesign as xd
from expdesign.app.api.recorded import correlated, referenced
from expdesign.chain.recordings.reader import recordings_from_table
from expdesign.io.output import csv_text
from expdesign.io.table import parse_table
from expdesign.planning.plan import Plan, plan_frame
from expdesign.planning.problem import DesignProblem
from expdesign.planning.sequential import recorded_knowledge
from tests.design.problems import HEXAPOD, plan_for, problem
from tests.oracle import Array

SPREAD = np.array([5e-7] * 3 + [2e-6] * 3)


def correlation(generator: np.random.Generator, size: int) -> Array:
    """Of some readings, far from the identity."""
    root = generator.standard_normal((size, size))
    covariance = root @ root.T + 2.0 * np.eye(size)
    scale = np.sqrt(np.diag(covariance))
    return covariance / np.outer(scale, scale)


def case(*, shared_reference: bool) -> DesignProblem:
    covariance = correlation(np.random.default_rng(0), 6) * np.outer(SPREAD, SPREAD)
    noise = {"covariance": covariance.tolist(), "shared_reference": shared_reference}
    changes = {"experiment.measurements": 8, "experiment.load_error": [], "experiment.deflection_noise": noise}
    # Nothing is asked here of what the recordings may hide.
    return problem(HEXAPOD, {**changes, "model_error": {"physics": ["instrument_scale"]}})


@cache
def plan_of(*, shared_reference: bool) -> pd.DataFrame:
    """Random measurements, two of them at every pose where these have a reference in common."""
    here = case(shared_reference=shared_reference)
    plan = plan_for(here)
    if shared_reference:
        pairs = np.repeat(np.arange(len(plan) // 2), 2)
        plan = Plan(plan.configurations[pairs], plan.loads, pairs + 1)
    return plan_frame(plan, here.loaded, here.space.tilts)


@pytest.mark.parametrize("shared_reference", [False, True])
def test_the_fit_has_the_u_of_the_plan(shared_reference: bool) -> None:
    here = case(shared_reference=shared_reference)
    plan = plan_of(shared_reference=shared_reference)
    recorded = xd.simulate(here, plan, noise=False).frame
    identified = xd.identify(HEXAPOD["robot"], recorded, targets=here)
    assert identified.acceptance is not None
    expected = xd.evaluate(here, plan).record["acceptance"]["targets"]
    for target, axes in enumerate(expected):
        columns = identified.acceptance.budget.axes
        for axis in axes["axes"]:
            found = identified.acceptance.budget.expanded[target, columns.index(axis["axis"])]
            assert found == pytest.approx(axis["expanded_uncertainty"], rel=1e-6)
    plain = xd.identify(HEXAPOD["robot"], recorded).result.fit
    assert np.abs(np.sqrt(np.diag(plain.covariance) / np.diag(identified.result.fit.covariance)) - 1.0).max() > 0.05


def test_levels_that_are_estimated_are_those_of_components() -> None:
    """What is said without a configuration's covariance stays: no row states how the readings scatter."""
    here = case(shared_reference=False)
    recorded = xd.simulate(here, plan_of(shared_reference=False)).frame.drop(
        columns=["sx_m", "sy_m", "sz_m", "srx_rad", "sry_rad", "srz_rad"]
    )
    with_targets, without = (xd.identify(HEXAPOD["robot"], recorded, targets=each) for each in (here, None))
    np.testing.assert_array_equal(with_targets.result.fit.values, without.result.fit.values)


def test_the_next_measurement_follows_the_same_noise() -> None:
    here = case(shared_reference=False)
    plan = plan_of(shared_reference=False)
    recorded = parse_table(csv_text(xd.simulate(here, plan).frame), "rec.csv")
    measured = correlated(referenced(recordings_from_table(recorded, here.loaded.robot), None, here), here)
    known = recorded_knowledge(here, measured, None, None)
    loads = np.concatenate([np.asarray(measured.payload), measured.gravity], axis=1)
    planned = here.assess(measured.configurations[None], loads[None]).information
    targets = here.targets.observation
    np.testing.assert_allclose(known.variances(targets)[0], planned.variances(targets)[0][0], rtol=1e-8)


def test_chi2_has_the_degrees_of_freedom_that_it_states() -> None:
    here = case(shared_reference=True)
    plan, found = plan_of(shared_reference=True), []
    for seed in range(10):
        identified = xd.identify(HEXAPOD["robot"], xd.simulate(here, plan, seed=seed).frame, targets=here)
        assert identified.chi2 is not None
        found.append(identified.chi2 / identified.result.goodness.dof)
    assert np.mean(found) == pytest.approx(1.0, abs=4.0 * np.sqrt(2.0 / (10 * 42)))

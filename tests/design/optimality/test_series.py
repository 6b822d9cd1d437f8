"""Series that share a reference: their information, the most sensitive one, and the bound they give."""

from itertools import combinations_with_replacement
from typing import Any

import numpy as np
import pytest

from expdesign.planning.optimality.measurement_maps import MeasurementMaps
from expdesign.planning.optimality.pool import Pool, takes_series
from expdesign.planning.optimality.series import longer, quadratic, sizes
from expdesign.planning.optimality.weights import Dual, dual_of
from expdesign.planning.problem import DesignProblem
from tests.design.problems import BIPOD, HEXAPOD, problem
from tests.oracle import Array

SHARED: dict[str, Any] = {"experiment.deflection_noise.shared_reference": True, "experiment.measurements": 3}
CASES: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "bipod": (BIPOD, SHARED),
    "hexapod": (HEXAPOD, {**SHARED, "experiment.load.gravity": {"tilt_x_rad": 0.0}}),
}


def pool_and_dual(here: DesignProblem, factor: float) -> tuple[Pool, Dual, Array]:
    information = MeasurementMaps(here, factor)
    assert takes_series(information)
    pool = Pool(information, 100)
    candidates = pool.first(None)
    relaxation, count = information.relaxation(), len(candidates)
    dual = dual_of(relaxation, pool.rows(candidates), np.full(count, 1.0 / count), np.ones(len(relaxation.targets)))
    return pool, dual, candidates[sizes(candidates) == 3][:6]


@pytest.mark.parametrize("name", CASES)
def test_a_series_tells_what_its_rows_tell_together(name: str) -> None:
    here = problem(*CASES[name])
    pool, _, three = pool_and_dual(here, 0.0)
    rows = pool.rows(three)
    whitened = here.assess(*here.space.decode(three)).whitened * here.loaded.scale
    expected = whitened.swapaxes(1, 2) @ whitened
    np.testing.assert_allclose(3.0 * rows.swapaxes(1, 2) @ rows, expected, atol=1e-12 * np.abs(expected).max())
    # One reading alone has its reference to itself, and is a measurement like any other.
    single = three.copy()
    single[:, 1:] = np.nan
    alone = pool.rows(single)
    plain, _ = here.whitened(*here.space.decode(three[:, 0]))
    expected = (plain * here.loaded.scale).swapaxes(1, 2) @ (plain * here.loaded.scale)
    np.testing.assert_allclose(alone.swapaxes(1, 2) @ alone, expected, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("factor", [0.0, 1.3])
@pytest.mark.parametrize("name", CASES)
def test_sensitivity_of_a_series_and_its_gradient(name: str, factor: float) -> None:
    here = problem(*CASES[name])
    pool, dual, three = pool_and_dual(here, factor)
    values, gradient = pool.sensitivity(dual, three)
    np.testing.assert_allclose(values, dual.sensitivities(pool.rows(three)), rtol=1e-10)
    step = 1e-6
    for decision in np.flatnonzero(here.space.of_pose):
        moved = np.where(here.space.of_pose & (np.arange(here.space.decisions) == decision), step, 0.0)
        high, low = (dual.sensitivities(pool.rows(three + sign * moved)) for sign in (1.0, -1.0))
        assert np.abs((high - low) / (2.0 * step) - gradient[:, decision]).max() < 1e-6 * np.abs(gradient).max()


@pytest.mark.parametrize("factor", [0.0, 1.0])
@pytest.mark.parametrize("name", CASES)
def test_the_most_sensitive_series_is_the_best_of_all(name: str, factor: float) -> None:
    here = problem(*CASES[name])
    pool, dual, three = pool_and_dual(here, factor)
    loads = pool.multisets.options
    poses = three[:, 0]
    at_corners = np.repeat(poses[:, None], loads, axis=1)
    index = MeasurementMaps(here, factor).load_variables()
    at_corners[..., index.index] = index.vertices
    listed = []
    for n in (1, 2, 3):
        for chosen in combinations_with_replacement(range(loads), n):
            series = np.full(three.shape, np.nan)
            series[:, :n] = at_corners[:, list(chosen)]
            listed.append(dual.sensitivities(pool.rows(series)))
    best = np.array(listed).max(axis=0)
    maps = pool.maps(at_corners)
    found = pool.multisets.best(dual, maps)
    np.testing.assert_allclose(found.values, best, rtol=1e-9)
    np.testing.assert_allclose(found.bound, best, rtol=1e-9)
    # Shares that need not be whole tell at least as much as any series that is as long or longer.
    gains, interactions = quadratic(dual, maps)
    by_size = [np.array(listed[:loads]).max(axis=0), np.array(listed[loads:]).max(axis=0)]
    assert (longer(gains, interactions(1), 1) >= by_size[0] * (1.0 - 1e-9)).all()
    assert (longer(gains, interactions(2), 2) >= by_size[1] * (1.0 - 1e-9)).all()

"""What a deviation from the plan costs: derivatives against the criterion's own code and against random deviations."""

from typing import Any

import numpy as np
import pytest

from expdesign.arrays import FloatArray
from expdesign.planning.criteria.accuracy import Total
from expdesign.planning.front import Front
from expdesign.planning.optimality.deviations import evaluations, plan_deviations
from expdesign.report.design_data import DELICATE, deviation_sentences
from tests.design.problems import BIPOD, HEXAPOD, changed, problem
from tests.design.refined import refined

CASES = {"bipod": BIPOD, "hexapod": HEXAPOD, "maximum": changed(HEXAPOD, {"aggregate": "max"})}


def total(case: Any, quantities: FloatArray) -> FloatArray:
    """Total of designs given by all quantities (b, m, z), by the criterion's own code."""
    n = case.space.n_pose
    loads, tilt = np.split(quantities[..., n:], [case.space.n_load], axis=-1)
    if case.space.gravity is not None:
        x, y = tilt[..., 0], tilt[..., 1]
        down = -np.stack([np.sin(y) * np.cos(x), -np.sin(x), np.cos(y) * np.cos(x)], axis=-1)  # Ry·Rx·(0, 0, -1)
        loads = np.concatenate([loads, 9.80665 * down], axis=-1)
    return Total().values(case.assess(quantities[..., :n], loads))


@pytest.fixture(params=list(CASES), scope="module")
def polished(request: pytest.FixtureRequest) -> Any:
    """A problem and a design at a local optimum, where some first derivatives vanish and others push into bounds."""
    case = problem(CASES[request.param])
    generator = np.random.default_rng(8)
    start = np.stack([case.space.sample(case.space.measurements, generator) for _ in range(30)])
    decisions = refined(case, start)
    values = total(case, case.space.quantities(decisions))
    return case, decisions[int(np.nanargmin(values))][None]


def test_an_allowed_deviation_costs_what_it_says(polished: Any) -> None:
    case, decisions = polished
    found = plan_deviations(case, decisions)
    quantities = case.space.quantities(decisions)
    before = float(total(case, quantities)[0])
    np.testing.assert_allclose(found.total[0], before, rtol=1e-9)
    growth = 0.002
    allowed = found.allowed(growth)[0]
    checked = 0
    for measurement, quantity in np.argwhere(np.isfinite(allowed)):
        moved = np.repeat(quantities, 2, axis=0)
        moved[0, measurement, quantity] += allowed[measurement, quantity]
        moved[1, measurement, quantity] -= allowed[measurement, quantity]
        worse = float(total(case, moved).max()) / before - 1.0
        # The third order is left out: small where the deviation is small beside the quantity's scale.
        if allowed[measurement, quantity] < 0.05 * found.scale[quantity]:
            assert 0.8 * growth < worse < 1.25 * growth, (found.names[quantity], measurement, worse)
            checked += 1
    assert checked > 2


def test_the_gradient_and_the_curvature_are_those_of_the_criterion(polished: Any) -> None:
    case, decisions = polished
    found = plan_deviations(case, decisions)
    quantities = case.space.quantities(decisions)
    for quantity in range(len(found.names)):
        step = 2e-4 * found.scale[quantity]
        moved = np.repeat(quantities, 3, axis=0)
        moved[1, 0, quantity] += step
        moved[2, 0, quantity] -= step
        here, above, below = total(case, moved)
        size = float(here) / found.scale[quantity]
        slope, bend = (above - below) / (2.0 * step), (above + below - 2.0 * here) / step**2
        assert abs(found.gradient[0, 0, quantity] - slope) < 1e-4 * size
        assert abs(found.curvature[0, 0, quantity] - bend) < 2e-2 * size / found.scale[quantity]


def test_random_deviations_change_total_as_predicted() -> None:
    case = problem(HEXAPOD)
    decisions = case.space.sample(3, np.random.default_rng(4))[None]
    found = plan_deviations(case, decisions)
    mean, spread = (float(part[0]) for part in found.growth(found.stated))
    generator = np.random.default_rng(6)
    count = 20_000
    quantities = np.repeat(case.space.quantities(decisions), count, axis=0)
    kept = len(found.names)
    quantities[..., :kept] += found.stated * generator.standard_normal((count, 3, kept))
    growth = total(case, quantities) / found.total[0] - 1.0
    standard_error = float(growth.std()) / np.sqrt(count)
    assert abs(float(growth.mean()) - mean) < 4.0 * standard_error + 0.05 * abs(mean)
    assert abs(float(growth.std()) / spread - 1.0) < 0.05


def test_a_design_that_identifies_nothing_has_no_derivatives() -> None:
    case = problem(HEXAPOD)
    one = case.space.sample(1, np.random.default_rng(4))
    blind = problem(HEXAPOD, {"experiment.deflection_noise": {"std": {"dz_m": 1e-6}}})
    found = plan_deviations(blind, np.repeat(one, 3, axis=0)[None])
    assert np.isnan(found.total).all()
    assert np.isnan(found.allowed(0.01)).all()


@pytest.mark.parametrize(("count", "said"), [(3, "of measurement"), (50, "recommended design only"), (600, "so many")])
def test_long_plans_are_judged_for_fewer_designs_or_none(count: int, said: str) -> None:
    case = problem(HEXAPOD, {"experiment.measurements": count})
    designs = case.space.sample(2 * count, np.random.default_rng(4)).reshape(2, count, -1)
    one = np.ones(2)
    front = Front(designs, {"total": one}, ("total",), 0, 1, one, 1.0, one, 2)
    deviations = deviation_sentences(case, front)
    assert said in " ".join(deviations[1])
    assert evaluations(case, count) * (count <= 50) <= DELICATE

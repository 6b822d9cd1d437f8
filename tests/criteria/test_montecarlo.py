"""DUIR, FEIR and total against Monte-Carlo of the whole method with the exact non-linear compensation (theory.md 8).

The repetitions are those of `validation`, which is held against an independent implementation in
tests/compensation/test_monte_carlo.py.
"""

import numpy as np
import pytest

from expdesign.assurance.validation.repeated import mean
from expdesign.assurance.validation.simulation import simulate
from expdesign.planning.criteria.criterion import known_criteria
from tests.cases import ALL_ERRORS, ROBOTS, setup

SAMPLES = 100_000
MEASUREMENTS = 4


def check(name: str, kind: str, criterion: str, errors: tuple[tuple[str, bool], ...], noise: bool, seed: int) -> None:
    here = setup(name, kind, "covariance", errors)
    plan = here.plan(np.random.default_rng(21), MEASUREMENTS)
    result = simulate(here.problem(), plan, SAMPLES, seed, noise=noise, load_errors=bool(errors))
    predicted = float(known_criteria()[criterion].values(result.assessment)[0]) ** 2
    weights = here.targets.weights / here.targets.weights.sum()
    squares = mean((result.errors**2 * here.targets.importance).sum(axis=-1) @ weights)
    assert squares.standard_error < 0.01 * predicted
    assert abs(squares.value - predicted) < 3.0 * squares.standard_error


@pytest.mark.parametrize("name", ["bipod", "irregular"])
def test_duir(name: str) -> None:
    check(name, "wrench", "duir", (), True, 1)


@pytest.mark.parametrize("shared", [True, False], ids=["shared", "independent"])
@pytest.mark.parametrize("source", ["com", "mass", "direction", "wrench"])
@pytest.mark.parametrize("name", ["bipod", "irregular"])
def test_feir(name: str, source: str, shared: bool) -> None:
    if source == "com" and name == "bipod":
        assert setup(name, "payload", errors=((source, shared),)).loaded.sources == ()
        return
    check(name, "payload", "feir", ((source, shared),), False, 2)


@pytest.mark.parametrize("name", [name for name in ROBOTS if name in {"bipod-unequal", "moving-xyz"}])
def test_total(name: str) -> None:
    """Noise and all four load errors at once."""
    check(name, "payload", "total", ALL_ERRORS, True, 3)

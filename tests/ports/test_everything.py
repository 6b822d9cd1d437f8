"""All small effects at once: groups sized by evidence, switched off where they are absent, intervals that cover."""

import numpy as np
import pytest

from expdesign.arrays import FloatArray
from expdesign.chain.ports.everything import GONE, Linearised, Priors, chosen_groups, everything, few_suffice

_ROWS, _MEMBERS = 240, 6


def _problem(sizes: tuple[float, ...], seed: int, curvature: float = 0.0) -> tuple[Linearised, Priors, FloatArray]:
    """Readings with unit noise of groups of `_MEMBERS` effects each, N(0, size²), besides two that are unknown."""
    rng = np.random.default_rng(seed)
    count = 2 + _MEMBERS * len(sizes)
    slopes = rng.normal(size=(_ROWS, count))
    truth = np.concatenate([[3.0, -7.0], *(size * rng.normal(size=_MEMBERS) for size in sizes)])

    def predicted(values: FloatArray) -> FloatArray:
        linear: FloatArray = slopes @ values
        return linear + curvature * linear**2

    readings = predicted(truth) + rng.normal(size=_ROWS)

    def linearised(values: FloatArray) -> tuple[FloatArray, FloatArray]:
        linear = slopes @ values
        return readings - predicted(values), slopes * (1.0 + 2.0 * curvature * linear)[:, None]

    group = np.concatenate([[-1, -1], np.repeat(np.arange(len(sizes)), _MEMBERS)])
    deviation = np.where(group < 0, np.inf, 1.0)
    bound = np.full(count, np.inf)
    return linearised, Priors(np.zeros(count), deviation, group, -bound, bound), truth


def test_what_readings_do_not_move_changes_nothing() -> None:
    """A parameter without any effect, and one that is held: values, noise and left-out errors of the others stay."""
    linearised, priors, _ = _problem((1.0, 0.5), seed=1)
    held, count = np.random.default_rng(3).normal(size=(_ROWS, 1)), len(priors.mean)

    def wider(values: FloatArray) -> tuple[FloatArray, FloatArray]:
        residuals, slopes = linearised(values[:count])
        return residuals - held[:, 0] * values[-1], np.hstack([slopes, np.zeros((_ROWS, 1)), held])

    more = Priors(
        np.append(priors.mean, [0.5, 0.0]), np.append(priors.deviation, [1.0, 1e-8]), np.append(priors.group, [-1, -1]),
        np.append(priors.low, [-np.inf] * 2), np.append(priors.high, [np.inf] * 2),
    )  # fmt: skip
    alone = everything(linearised, priors, np.zeros(count))
    found = everything(wider, more, np.append(np.zeros(count), [0.5, 0.0]))
    np.testing.assert_allclose(found.values[:count], alone.values, rtol=1e-8)
    np.testing.assert_allclose(found.values[count:], [0.5, 0.0], atol=1e-8)
    np.testing.assert_allclose(found.noise, alone.noise, rtol=1e-8)
    deviations = np.sqrt(np.diag(found.covariance))[count:]
    np.testing.assert_allclose(deviations, [1.0, 1e-8], rtol=1e-6)
    blocks = np.arange(_ROWS) // 24
    np.testing.assert_allclose(found.left_out(blocks, more), alone.left_out(blocks, priors), rtol=1e-6, atol=1e-9)


def test_absent_groups_are_switched_off_and_noise_is_learnt() -> None:
    linearised, priors, _ = _problem((1.0, 0.0, 0.5, 0.0), seed=1)
    found = everything(linearised, priors, np.zeros(len(priors.mean)))
    assert found.factors[0] > 0.4
    assert found.factors[2] > 0.2
    assert found.factors[[1, 3]].max() < 0.15
    # The deviation of an estimated standard deviation is 1/sqrt(2·M), here 0.046.
    assert found.noise == pytest.approx(1.0, abs=0.14)


def test_left_out_blocks_are_predicted_to_the_noise_with_the_groups_that_are_there() -> None:
    linearised, priors, _ = _problem((1.0, 0.0, 0.5, 0.0), seed=2)
    blocks = np.arange(_ROWS) // 24
    found, chosen = chosen_groups(linearised, priors, np.zeros(len(priors.mean)), blocks)
    there = set(chosen.group[chosen.group >= 0].tolist())
    assert {0, 2} <= there
    assert all(found.factors[group] > GONE for group in there)
    assert float(np.sqrt((found.left_out(blocks, chosen) ** 2).mean())) < 1.15


@pytest.mark.parametrize("length", [8, 24])
def test_left_out_errors_are_those_of_fits_without_the_block(length: int) -> None:
    """Blocks shorter and longer than the fourteen parameters."""
    linearised, priors, _ = _problem((1.0, 0.5), seed=3)
    blocks = np.arange(_ROWS) // length
    found = everything(linearised, priors, np.zeros(len(priors.mean)))
    slopes, precision = found.slopes, np.zeros(len(priors.mean))
    own = priors.group >= 0
    precision[own] = (found.noise / found.factors[priors.group[own]]) ** 2
    readings = found.residuals + slopes @ found.values
    inside = blocks == 4
    rest = slopes[~inside]
    without = np.linalg.solve(rest.T @ rest + np.diag(precision), rest.T @ readings[~inside])
    expected = readings[inside] - slopes[inside] @ without
    np.testing.assert_allclose(found.left_out(blocks, priors)[inside], expected, atol=1e-5)


def test_intervals_cover() -> None:
    inside, count = 0, 0
    for seed in range(30):
        linearised, priors, truth = _problem((1.0, 0.3), seed=100 + seed)
        found = everything(linearised, priors, np.zeros(len(priors.mean)))
        half = 1.96 * np.sqrt(found.covariance.diagonal())
        inside += int((np.abs(found.values - truth) <= half).sum())
        count += len(truth)
    # 420 intervals that are nearly independent: the standard error of their share is 0.011.
    assert inside / count == pytest.approx(0.95, abs=0.035)


def test_curvature_is_followed() -> None:
    linearised, priors, truth = _problem((0.3,), seed=5, curvature=0.005)
    found = everything(linearised, priors, np.zeros(len(priors.mean)))
    np.testing.assert_allclose(found.values, truth, atol=0.5)
    assert found.noise < 1.2


def test_a_bound_is_not_a_cut() -> None:
    """Parameters that a bound stops leave the others to fit what they can: as in a fit without them."""
    linearised, priors, _ = _problem((1.0,), seed=6)
    high = np.where(np.arange(len(priors.mean)) == 0, 1.0, np.inf)
    bounded = Priors(priors.mean, priors.deviation, priors.group, priors.low, high)
    found = everything(linearised, bounded, np.zeros(len(high)))
    assert found.values[0] == 1.0
    gradient = found.slopes.T @ found.residuals
    precision = np.where(priors.group >= 0, (found.noise / found.factors[0]) ** 2, 0.0)
    np.testing.assert_allclose((gradient - precision * found.values)[1:], 0.0, atol=1e-3)


def test_few_groups_suffice_where_few_are_there() -> None:
    blocks = np.arange(_ROWS) // 24
    for sizes, few in (((1.0, 0.0, 0.0, 0.0), True), ((1.0, 1.0, 1.0, 1.0), False)):
        linearised, priors, _ = _problem(sizes, seed=7)
        found = everything(linearised, priors, np.zeros(len(priors.mean)))
        assert few_suffice(found, priors, blocks) is few

"""Rows that stand out, and whether they stand out alone."""

import numpy as np
import pytest

from expdesign.arrays import FloatArray
from expdesign.diagnosis.outliers import in_common, returning_distances, row_distances, standing_out
from tests.diagnosis.samples import base_fit, sample_of, simulated

SERIES = np.repeat(np.arange(30), 6)
DRIVERS: dict[str, FloatArray] = {
    f"driver {i}": np.random.default_rng(i).standard_normal(len(SERIES)) for i in range(12)
}


@pytest.mark.parametrize("name", ["irregular", "bipod-unequal"])
def test_the_distance_of_a_row_is_what_chi_squared_falls_by_without_it(name: str) -> None:
    recordings = simulated(name, seed=3)
    sample = sample_of(name, recordings)
    base = base_fit(name, sample)
    distances, *_ = row_distances(base.residuals, base.sensitivities, base.estimable.generalised)
    for row in range(len(recordings)):
        left = base_fit(name, sample.restricted(np.arange(len(recordings)) != row))
        assert distances[row] == pytest.approx(base.chi2 - left.chi2, rel=1e-6, abs=1e-6)


def test_a_row_that_alone_determines_a_leg_has_no_finite_evidence_against_it() -> None:
    """Full leverage: the residual is zero, and so is the distance."""
    sensitivities = np.zeros((3, 2, 1))
    sensitivities[0, 0, 0] = 1.0
    residuals = np.array([[0.0, 0.3], [1.0, 1.0], [0.5, 0.5]])
    distances, *_ = row_distances(residuals, sensitivities, np.eye(1))
    np.testing.assert_allclose(distances, [0.09, 2.0, 0.5], rtol=1e-6)


def test_rows_stand_out_one_after_the_other_as_refits_show_them() -> None:
    """A large mistake spoils the rows about it, until it is set aside."""
    name = "irregular"
    recordings = simulated(name, seed=3)
    wrong = {4: 300.0, 9: 40.0, 15: 9.0}
    for row, size in wrong.items():
        recordings.deflections[row] += size * np.array(recordings.deviations)[row]
    sample, price = sample_of(name, recordings), 45.0
    base, nothing = base_fit(name, sample), np.zeros(len(recordings), dtype=bool)
    flagged, refits = nothing, base
    while True:
        distances, *_ = row_distances(refits.residuals, refits.sensitivities, refits.estimable.generalised)
        distances[flagged] = 0.0
        if distances.max() < price:
            break
        flagged = flagged | (distances == distances.max())
        refits = base_fit(name, sample.restricted(~flagged))
    assert set(np.flatnonzero(flagged)) == set(wrong)
    np.testing.assert_array_equal(standing_out(base, nothing, price, 10), flagged)
    assert standing_out(base, nothing, price, 2).sum() == 2


def mistakes(seed: int, rows: int = 6) -> tuple[np.ndarray, np.ndarray]:  # type: ignore[type-arg]
    """Residuals of noise, and rows with large errors in random directions at random places."""
    generator = np.random.default_rng(seed)
    residuals = generator.standard_normal((len(SERIES), 6))
    chosen = generator.permutation(len(SERIES))[:rows]
    residuals[chosen] += 20.0 * generator.standard_normal((rows, 6))
    outliers = np.zeros(len(SERIES), dtype=bool)
    outliers[chosen] = True
    return residuals, outliers


def test_random_mistakes_stand_alone() -> None:
    """Three tests at the level of 0.0025 each: of 40 sets no more than 2 (mean 0.3, standard deviation 0.55)."""
    accepted = [not in_common(*mistakes(seed), SERIES, DRIVERS) for seed in range(40)]
    assert sum(accepted) >= 38


def test_mistakes_of_one_direction_do_not() -> None:
    residuals, outliers = mistakes(0)
    residuals[outliers] = np.array([1.0, 2.0, -1.0, 0.5, 0.0, 1.0]) + 0.2 * residuals[outliers] / 20.0
    assert in_common(residuals, outliers, SERIES, {})


def test_mistakes_of_one_series_do_not() -> None:
    residuals, _ = mistakes(0)
    outliers = (SERIES == 7) & (np.arange(len(SERIES)) % 6 < 4)
    residuals[outliers] *= 20.0
    assert not in_common(residuals, mistakes(0)[1], SERIES, DRIVERS)
    assert in_common(residuals, outliers, SERIES, {})


@pytest.mark.parametrize("rows", [0, 1, 2])
def test_one_or_two_rows_say_nothing_of_each_other(rows: int) -> None:
    residuals, outliers = mistakes(1, rows)
    residuals[outliers] = 10.0
    assert not in_common(residuals, outliers, SERIES, DRIVERS)


@pytest.mark.parametrize("reverse", [False, True])
def test_mistakes_that_depend_on_something_do_not_stand_alone(reverse: bool) -> None:
    """Eight of the ten largest (smallest) loads, among twelve quantities of which eleven say nothing."""
    residuals, _ = mistakes(2, 0)
    load = DRIVERS["driver 7"] * (-1.0 if reverse else 1.0)
    chosen = np.argsort(load)[-10:][[0, 1, 3, 4, 5, 6, 8, 9]]
    outliers = np.zeros(len(SERIES), dtype=bool)
    outliers[chosen] = True
    residuals[chosen] = 20.0 * np.random.default_rng(5).standard_normal((8, 6))
    assert in_common(residuals, outliers, SERIES, DRIVERS) == "they depend on driver 7"


def test_mistakes_in_the_middle_of_something_do_not_stand_alone() -> None:
    residuals, _ = mistakes(2, 0)
    outliers = np.argsort(np.argsort(np.abs(DRIVERS["driver 3"] - np.median(DRIVERS["driver 3"])))) < 8
    residuals[outliers] = 20.0 * np.random.default_rng(5).standard_normal((8, 6))
    assert in_common(residuals, outliers, SERIES, DRIVERS) == "they depend on driver 3"


def test_more_than_a_few_mistakes_are_none() -> None:
    """Of 180 rows 9 are usual, and 20 happen in 1 of 1000 experiments."""
    assert not in_common(*mistakes(4, 12), SERIES, DRIVERS)
    assert in_common(*mistakes(4, 20), SERIES, DRIVERS) == "they are too many"


def test_a_row_set_aside_returns_at_the_price_that_leaving_it_out_saved() -> None:
    recordings = simulated("bipod-unequal", seed=3)
    sample = sample_of("bipod-unequal", recordings)
    whole = base_fit("bipod-unequal", sample)
    for row in (0, 7, 13):
        outliers = np.arange(len(recordings)) == row
        left = base_fit("bipod-unequal", sample.restricted(~outliers))
        price = returning_distances(left, sample, outliers)
        assert price[row] == pytest.approx(whole.chi2 - left.chi2, rel=1e-6, abs=1e-6)
        assert price.sum() == price[row]

"""Rows that stand out, whether they stand out alone, and rows that do not count."""

import numpy as np
import pytest

from expdesign.arrays import FloatArray
from expdesign.chain.chain import Chain
from expdesign.diagnosis.evidence.state import Present, linearised
from expdesign.diagnosis.outliers import (
    in_common,
    outlier_price,
    returning,
    single_mistakes,
    standing_out,
)
from expdesign.estimation.fit import fit
from tests.cases import robot
from tests.diagnosis.samples import base_fit, effect, sample_of, simulated

SERIES = np.repeat(np.arange(30), 6)


DRIVERS: dict[str, FloatArray] = {
    f"driver {i}": np.random.default_rng(i).standard_normal(len(SERIES)) for i in range(12)
}


def test_a_row_that_alone_determines_a_leg_has_no_finite_evidence_against_it() -> None:
    """Full leverage: what it reads says nothing, however much it is; the row beside it has no say in the leg."""
    base = np.zeros((20, 1))
    base[0] = 1.0
    readings = np.zeros(20)
    readings[[0, 5]] = 1e3, 20.0
    found, _ = standing_out(Present(base, np.zeros(1), readings), 2, 5)
    np.testing.assert_array_equal(found, [2])


@pytest.mark.parametrize("scale", [1.0, 7.0])
@pytest.mark.parametrize("name", ["irregular", "bipod-unequal"])
def test_rows_stand_out_one_after_the_other_as_refits_show_them(name: str, scale: float) -> None:
    """A large mistake spoils the rows about it, until it is set aside; χ² falls by what each is said to bring.

    Noise that is not as stated is what remains, and then changes nothing.
    """
    recordings = simulated(name, seed=3, noise=scale)
    wrong = {4: 300.0, 9: 60.0, 15: 30.0}
    for row, size in wrong.items():
        recordings.deflections[row] += scale * size * np.array(recordings.deviations)[row]
    sample, rows, axes = sample_of(name, recordings), len(recordings), len(recordings.axes)
    kept, chi2 = np.ones(rows, dtype=bool), base_fit(name, sample).chi2
    refitted: list[int] = []
    while True:
        left = {
            int(r): base_fit(name, sample.restricted(kept & (np.arange(rows) != r))).chi2 for r in np.flatnonzero(kept)
        }
        worst = min(left, key=lambda row: left[row])
        if chi2 - left[worst] < outlier_price(rows * axes, axes, rows) * scale**2:
            break
        refitted, chi2 = [*refitted, worst], left[worst]
        kept[worst] = False
    assert set(refitted) == set(wrong)
    state = linearised(base_fit(name, sample), sample, known_noise=scale == 1.0)
    assert standing_out(state, axes, 10)[0].tolist() == refitted
    assert standing_out(state, axes, 2)[0].tolist() == refitted[:2]


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


def test_rows_that_stand_out_alike_are_no_single_mistakes() -> None:
    """Four rows wrong in random directions are set aside; wrong by the same on every axis they are something else."""
    name, rows = "irregular", [2, 9, 15, 22]
    errors = np.random.default_rng(3).standard_normal((4, 6))
    for wrong, common in ((60.0 * np.sign(errors), ""), (np.full((4, 6), 60.0), "they point the same way")):
        recordings = simulated(name, seed=3, series=12)
        recordings.deflections[rows] += wrong * np.array(recordings.deviations)[rows]
        sample = sample_of(name, recordings)
        found = single_mistakes(linearised(base_fit(name, sample), sample), sample, robot(name))
        assert found.common == common
        assert np.flatnonzero(found.rows).tolist() == ([] if common else rows)
        assert (found.worth > 0.0) != bool(common)


def test_rows_that_fit_after_all_return() -> None:
    name = "irregular"
    recordings = simulated(name, seed=3)
    recordings.deflections[4] += 60.0 * np.array(recordings.deviations)[4]
    sample, aside = sample_of(name, recordings), np.isin(np.arange(len(recordings)), [4, 11])
    left = base_fit(name, sample.restricted(~aside))
    assert np.flatnonzero(returning(left, sample, aside, known_noise=True)).tolist() == [11]


COUNTS = np.random.default_rng(0).random(24) < 0.7


@pytest.mark.parametrize("name", ["irregular", "bipod-unequal"])
def test_rows_that_do_not_count_might_as_well_not_be_there(name: str) -> None:
    recordings = simulated(name)
    masked = base_fit(name, sample_of(name, recordings, COUNTS))
    shorter = base_fit(name, sample_of(name, recordings.rows(COUNTS)))
    np.testing.assert_allclose(masked.values, shorter.values, rtol=1e-12)
    np.testing.assert_allclose(masked.covariance, shorter.covariance, rtol=1e-9)
    assert masked.chi2 == pytest.approx(shorter.chi2, rel=1e-12)
    np.testing.assert_array_equal(masked.residuals[~COUNTS], 0.0)


def test_readings_and_restrictions() -> None:
    sample = sample_of("irregular", simulated("irregular"), COUNTS)
    assert sample.readings == 6 * int(COUNTS.sum())
    other = np.arange(24) % 2 == 0
    np.testing.assert_array_equal(sample.restricted(other).counts, COUNTS & other)
    whitened = sample.whiten(np.ones((24, 6, 3)))
    np.testing.assert_array_equal(whitened[~COUNTS], 0.0)
    expected = 1.0 / np.array(sample.recordings.deviations)[COUNTS]
    np.testing.assert_allclose(whitened[COUNTS], np.repeat(expected[..., None], 3, axis=2))


def test_a_row_set_aside_stays_in_the_history_of_its_series() -> None:
    """Friction: what a row reads depends on the load of the row before, whether or not that one counts."""
    friction = effect("irregular", "friction_hysteresis", "all legs", "rigid")
    recordings = simulated("irregular", friction, parameters=[30.0], noise=0.0)
    chain = Chain(robot("irregular"), (friction,))
    counts = np.arange(24) % 4 != 1
    sample = sample_of("irregular", recordings, counts)
    truth = np.append(np.ones(6), 30.0)
    assert np.abs(sample.residuals(chain, truth)).max() < 1e-6
    without = sample_of("irregular", recordings.rows(counts))
    assert np.abs(without.residuals(chain, truth)).max() > 1.0
    found = fit(chain, sample, np.append(np.ones(6), 10.0))
    assert found.values[-1] == pytest.approx(30.0, rel=1e-6)

"""What is left out together: stations, series, or rows in a row."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.stats import norm

from expdesign.diagnosis.cross_validation import LeftOut, blocks_of, last_part, readings_of
from expdesign.diagnosis.held_out import HeldOut
from expdesign.diagnosis.options import OPTIONS
from expdesign.estimation.fit import Data
from tests.chain.bodies import BODY, recordings
from tests.fitting import data_of


def sample(count: int, series: int, stations: int = 0) -> Data:
    """Rows in blocks of one series, and of one station where there are some."""
    points = recordings(count=count, axes=(3, 4))
    points = replace(points, series=np.arange(count) * series // count)
    if stations:
        points = replace(points, extra=pd.DataFrame({"station": np.arange(count) * stations // count}))
    return data_of(points, BODY).counting(np.ones(count, dtype=bool))


def test_no_series_and_no_station_is_divided() -> None:
    for chosen, groups in ((sample(60, 12), 12), (sample(60, 2, 6), 6)):
        assert len(np.unique(blocks_of(chosen))) == groups
        whole = np.arange(60) * groups // 60
        for most in (OPTIONS.groups, 6):
            blocks = blocks_of(chosen, most)
            assert len(np.unique(blocks)) == most
            assert all(len(np.unique(blocks[whole == group])) == 1 for group in range(groups))


def test_few_series_are_divided_into_rows_in_a_row_of_equal_number_among_those_that_count() -> None:
    counts = np.arange(60) < 40
    blocks = blocks_of(sample(60, 2).restricted(counts), 10)
    assert (np.diff(blocks) >= 0).all()
    assert np.bincount(blocks[counts]).tolist() == [4] * 10


def test_every_reading_of_a_row_has_its_block() -> None:
    chosen = sample(20, 10).restricted(np.arange(20) >= 4)
    assert readings_of(blocks_of(chosen), chosen).tolist() == np.repeat(np.arange(20) // 2, 2)[8:].tolist()


def test_the_last_part_of_a_campaign_is_whole_series_where_there_are_several() -> None:
    last, before = last_part(sample(60, 12), 5)
    assert np.flatnonzero(last).tolist() == list(range(45, 60))
    assert np.flatnonzero(before).tolist() == list(range(45))
    last, before = last_part(sample(60, 1), 5)
    assert np.flatnonzero(last).tolist() == list(range(48, 60))
    assert (last ^ before).all()


def test_what_comes_later_refutes_only_where_it_is_clearly_worse_and_no_noise() -> None:
    """The base model predicts the last rows to the noise where these do not show what the others show."""
    for later, refuted in (((1.0, 1.25), False), ((3.0, 3.2), False), ((3.0, 3.4), True), ((1.0, 1.5), True)):
        errors = HeldOut(6.0, 1.0, 6.0, 1.0, 1.0, "", later_before=later[0], later_after=later[1])
        assert errors.refuted is refuted
    assert HeldOut(6.0, 1.0, 6.0, 6.1, 1.0, "").refuted


@pytest.mark.parametrize(("k", "q"), [(4.0, 1e-5), (1.0, 0.01), (3.0, 0.02)])
def test_what_left_out_errors_ask_for_is_found_again(k: float, q: float) -> None:
    """Errors drawn with a covariance k times too small, and a share q of the prior that no row takes away."""
    generator = np.random.default_rng(0)
    own, priors = generator.uniform(0.0, 1.0, 4000), generator.uniform(0.0, 100.0, 4000)
    errors = generator.standard_normal(4000) * np.sqrt(1.0 + k * own + q * priors)
    factor, share = LeftOut(errors, errors, np.arange(4000)).widened(1.0 + own, priors)
    assert factor == pytest.approx(k, rel=0.2, abs=0.2)
    assert share == pytest.approx(q, rel=0.2, abs=1e-3)


def test_a_named_form_is_wrong_by_a_tenth_where_nothing_tells_and_less_where_many_rows_do() -> None:
    """Oracle: the mean of q where √q ~ |N(0, 0.1²)| is 0.01; rows that leave nothing beside the noise lower it."""
    nothing = LeftOut(np.zeros(10), np.zeros(10), np.arange(10)).widened(np.ones(10), np.zeros(10), 0.1)[1]
    assert nothing == pytest.approx(0.01, rel=0.1)
    errors = np.random.default_rng(0).standard_normal(2000)
    told = LeftOut(errors, errors, np.arange(2000)).widened(np.ones(2000), np.full(2000, 25.0), 0.1)[1]
    assert told < 0.003


def test_left_out_errors_that_tell_nothing_leave_the_factor_at_its_mean_beforehand() -> None:
    """Oracle: ∫ eˣ·2φ(x) dx over x > 0 is 2·√e·Φ(1), 1.6 % of it beyond the largest factor."""
    factor, _ = LeftOut(np.ones(10), np.ones(10), np.arange(10)).widened(np.ones(10), np.zeros(10))
    assert factor == pytest.approx(2.0 * np.sqrt(np.e) * norm.cdf(1.0), rel=0.05)

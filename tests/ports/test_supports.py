"""What a body stands on or is guided by: laws of the whole load, chosen by stations that are left out."""

from dataclasses import replace
from functools import cache

import numpy as np
import pandas as pd
import pytest

from expdesign.arrays import FloatArray, rms
from expdesign.chain.chain import Chain
from expdesign.chain.component import BASE
from expdesign.chain.ports.law import Law, form_data, form_of
from expdesign.chain.ports.quantities import Quantity, evaluate
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.row import row_data, row_symbols
from expdesign.coordinates import SPATIAL
from expdesign.diagnosis.cross_validation import blocks_of
from expdesign.diagnosis.findings import Finding
from expdesign.diagnosis.group_library import groups_of
from expdesign.diagnosis.groups import Groups, grouped
from expdesign.diagnosis.law_findings import group_findings
from expdesign.estimation.fit import Data, fit
from tests.chain.bodies import BODY, recordings
from tests.fitting import data_of
from tests.identification.experiments import read

_NOISE, _ENDS, _GAP, _WIDTH, _SOFT = 2e-5, 4.2, 6e-4, 25.0, 4e-6
_HEIGHTS = (2.0, 2.7, 3.2, 3.8)


def tilt(moment: FloatArray | float, height: float, at: float) -> FloatArray:
    """Springs, and a clearance that tilts a column by gap/overlap, taken up around a moment: no kernel's shape."""
    result: FloatArray = _SOFT * moment + _GAP / (_ENDS - height) * (2.0 / np.pi) * np.arctan((moment - at) / _WIDTH)
    return result


def column_rows(seed: int = 0) -> pd.DataFrame:
    """A column at four heights, two stations of other loads each and a third one that is held out."""
    generator = np.random.default_rng(seed)
    frames, station = [], 0
    for series, height in enumerate(_HEIGHTS, start=1):
        loads = generator.uniform([-110.0, -40.0], [110.0, 200.0], (45, 2))
        reference = loads[0] = np.array([-20.0, 150.0])
        frame = pd.DataFrame({"series": series, "station": station + np.repeat([1, 2, 3], 15)}, index=range(45))
        station += 3
        frame["split"] = np.repeat(["train", "train", "test"], 15)
        for i, name in enumerate(SPATIAL.pose):
            frame[name] = height if i == 2 else 0.0
        for i, name in enumerate(SPATIAL.wrench):
            whole = loads[:, i - 3] if i in (3, 4) else np.zeros(45)
            frame[name] = whole - whole[0]
            frame[f"abs_{name}"] = whole
        for i, at in enumerate((30.0, 10.0)):
            change = tilt(loads[:, i], height, at) - tilt(reference[i], height, at)
            read_off = change + _NOISE * generator.standard_normal(45)
            frame[SPATIAL.deflection[3 + i]] = np.where(np.arange(45) == 0, 0.0, read_off)
            frame[SPATIAL.deviation[3 + i]] = _NOISE
        frames.append(frame)
    table = pd.concat(frames, ignore_index=True)
    table["sequence"] = np.arange(1, len(table) + 1)
    table["time_s"] = 8.0 * np.arange(len(table))
    return table


@cache
def column(seed: int = 0) -> Recordings:
    """`column_rows` as the reader gives them."""
    return read(column_rows(seed), BODY)


def sample_of(points: Recordings) -> Data:
    return data_of(points, BODY).counting(~points.test)


@cache
def found() -> Groups:
    sample = sample_of(column())
    base = fit(Chain(BODY), sample)
    groups = grouped(BODY, sample, base, groups_of(BODY, sample, base, ()))
    assert groups is not None
    return groups


@cache
def guide() -> Finding:
    return next(f for f in group_findings(found(), BODY, ()) if f.variant == "guide")


def test_a_column_whose_guides_have_clearance_is_predicted_at_stations_that_were_held_out() -> None:
    points = column()
    every = sample_of(points).counting(np.ones(len(points), dtype=bool))
    before = rms(every.residuals(Chain(BODY), np.zeros(0)), points.test)
    after = rms(every.residuals(found().fit.chain, found().fit.values), points.test)
    assert before > 10.0
    assert after < 0.1 * before
    assert found().after == pytest.approx(after, rel=0.4)


def test_the_guides_are_among_what_is_found_and_end_where_they_do() -> None:
    group = next(one for one in found().found if one.group.form == "guide")
    overlap = group.laws[0].form.channels[0].amplitude
    assert overlap.setting[0] == pytest.approx(_ENDS, abs=0.3)
    assert guide().component == str(BASE)
    assert "the moment about x" in guide().sentence


def test_the_drawn_law_has_the_play_within_its_band() -> None:
    """Of the laws of the load together at the median height, relative to the load of the reference, along mx."""
    curve = guide().curve
    chosen = (np.array(curve.output) == "drx_rad") & (np.array(curve.varied) == 0)
    moment = curve.inputs[chosen, 0]
    truth = tilt(moment, 0.5 * (_HEIGHTS[1] + _HEIGHTS[2]), 30.0) - _SOFT * moment
    slope = np.polyfit(truth, curve.mean[chosen], 1)[0]
    assert slope == pytest.approx(1.0, abs=0.5)


def test_under_the_load_of_the_reference_no_law_of_the_load_moves_the_body() -> None:
    points = column()
    chain, values = found().fit.chain, found().fit.values
    predicted = chain.predict(row_data(points, BODY), values)
    first = np.flatnonzero(~points.wrenches.any(axis=1))
    assert len(first) == len(_HEIGHTS)
    assert np.abs(predicted[first]).max() < 1e-12


def test_laws_of_a_support_come_back_from_a_model_file() -> None:
    points = column()
    chain, values = found().fit.chain, found().fit.values
    laws = [effect for effect in chain.effects if isinstance(effect, Law)]
    again = tuple(Law(BODY, form_of(form_data(law.form), BASE), law.number) for law in laws)
    rows = row_data(points, BODY)
    np.testing.assert_allclose(Chain(BODY, again).predict(rows, values), chain.predict(rows, values), atol=1e-15)


def test_whole_stations_are_left_out_where_they_are_stated_and_series_elsewhere() -> None:
    points = column()
    blocks = blocks_of(sample_of(points))
    assert len(np.unique(blocks)) == 3 * len(_HEIGHTS)
    plain = sample_of(recordings())
    assert len(np.unique(blocks_of(plain))) == 5


def test_a_support_that_does_not_yield_has_no_laws() -> None:
    """Noise alone, as much as is stated."""
    generator = np.random.default_rng(3)
    still = recordings(count=80)
    assert still.deviations is not None
    noise = still.deviations * generator.standard_normal(still.deflections.shape)
    noisy = replace(still, deflections=noise)
    sample = sample_of(noisy)
    base = fit(Chain(BODY), sample)
    assert grouped(BODY, sample, base, groups_of(BODY, sample, base, ())) is None


def test_an_overlap_is_what_is_left_of_a_guide() -> None:
    row = row_symbols(BODY)
    far, near = (
        evaluate([Quantity("overlap", 2, setting)], row_data(column(), BODY), row, BODY)[:, 0]
        for setting in ((_ENDS, 1.0), (1.5, -1.0))
    )
    heights = column().configurations[:, 2]
    np.testing.assert_allclose(far, 1.0 / (_ENDS - heights))
    np.testing.assert_allclose(near, 1.0 / (heights - 1.5))

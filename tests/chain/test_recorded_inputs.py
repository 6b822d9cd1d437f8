"""Beyond the recorded times and temperatures, physics that is declared to hold stays as it is at the nearest end."""

from dataclasses import replace

import numpy as np
import pytest

from expdesign.chain.chain import Chain
from expdesign.chain.declaration import Beyond
from expdesign.chain.effect import Effect
from expdesign.chain.models.effect_entry import EffectSection, effect_entry, effect_of
from expdesign.chain.recorded_inputs import INPUTS, ranges_of
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.row import row_data, row_symbols
from expdesign.diagnosis.frame import framed
from expdesign.diagnosis.stages import unheard
from tests.chain.places import BEYOND_LEGS, ON_LEGS, Place, away_from_neutral, recordings

EVERY = [*ON_LEGS, *BEYOND_LEGS]
FIRST = 2
HOLDING = [place for place in EVERY if place.effect().beyond is Beyond.HOLDS]


def fitted(place: Place, recorded: Recordings) -> Effect:
    """The effect with what was recorded in the first rows."""
    effect, rows = place.effect(), row_data(recorded, place.robot)
    effect.recorded = ranges_of(rows, np.arange(len(rows)) < FIRST, row_symbols(place.robot))
    return effect


@pytest.mark.parametrize("place", EVERY, ids=str)
def test_what_holds_sees_nothing_beyond_its_range(place: Place) -> None:
    """As in rows whose times and temperatures are clipped by hand; all else goes on as without a range."""
    points, free = recordings(place.name), place.chain
    effect, rows = fitted(place, points), row_data(points, place.robot)
    values = away_from_neutral(free)
    expected = rows
    if effect.beyond is Beyond.HOLDS:
        clipped = rows.values.copy()
        for name in INPUTS:
            part = row_symbols(place.robot).columns(name)
            early = clipped[:FIRST, part]
            clipped[:, part] = np.clip(clipped[:, part], early.min(axis=0), early.max(axis=0))
        expected = replace(rows, values=clipped)
    held = Chain(place.robot, (effect,))
    np.testing.assert_allclose(held.predict(rows, values), free.predict(expected, values), rtol=1e-12, atol=1e-18)
    if place in HOLDING:
        assert np.abs(free.predict(rows, values) - held.predict(rows, values))[FIRST:].max() > 1e-9


def test_physics_that_holds_is_among_them() -> None:
    assert {str(place.component).split()[0] for place in HOLDING} >= {"leg", "environment", "link"}


@pytest.mark.parametrize("place", HOLDING, ids=str)
def test_a_model_file_keeps_the_range(place: Place) -> None:
    effect = fitted(place, recordings(place.name))
    entry = effect_entry(effect, effect.neutral().tolist())
    again = effect_of(EffectSection.model_validate(entry), place.robot)
    assert again.recorded == effect.recorded


def test_a_diagnosis_offers_drifts_with_the_range_of_the_fitted_rows() -> None:
    points = recordings("irregular")
    late = np.arange(len(points)) >= 10
    frame = framed(HOLDING[0].robot, replace(points, test=late), without=frozenset(), report=unheard)
    drifts = [entry.effect for entry in frame.names.library if entry.effect.beyond is Beyond.HOLDS]
    assert drifts
    assert points.time is not None
    for drift in drifts:
        assert drift.recorded is not None
        assert drift.recorded["time_s"] == (points.time[0], points.time[9])

"""What may be named: no imitation by a drift, no physics at its limits, nothing that a tenth of the rows turns over."""

from dataclasses import replace
from functools import cache

import numpy as np

from expdesign.chain.chain import Chain
from expdesign.chain.effect import Effect
from expdesign.chain.effects.instrument.frame import InstrumentDrift
from expdesign.chain.effects.joints.geometry import GeometricError
from expdesign.chain.readings.choice import reading_of
from expdesign.chain.readings.position import MarkerPosition
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.row import row_data
from expdesign.diagnosis.confirmation import confirmed, stability
from expdesign.diagnosis.cross_validation import blocks_of
from expdesign.diagnosis.evidence.search import Search
from expdesign.diagnosis.library import candidates, library
from expdesign.diagnosis.names import NamedModel, Names
from expdesign.diagnosis.options import OPTIONS
from expdesign.diagnosis.remarks import ConfoundedTime
from expdesign.estimation.fit import fit
from expdesign.mechanics.robots.serial import SerialRobot
from expdesign.report.remark_texts import sentence
from tests.cases import robot
from tests.chain.arms import INSTRUMENT, PLACE, configurations, recordings_of
from tests.diagnosis.samples import base_fit, effect, sample_of, simulated
from tests.fitting import data_of
from tests.oracle import Array

NAME = "bipod-unequal"
PLAY = effect(NAME, "leg_backlash", "leg 1", "middle")
FRICTION = effect(NAME, "friction_hysteresis", "leg 2", "rigid")
ZEROS = "joint_position_error / all joints"
DRIFT = "thermal_drift / instrument / shift"
NOISE = 5e-5


def positions(arm: SerialRobot, q: Array, moved: Array, test: Array | None = None) -> Recordings:
    """Rows a minute apart of an arm with zeros that are off, its marker displaced by `moved` (N, 3) and noise."""
    zeros = GeometricError.from_text(arm, "all joints")
    chain = Chain(arm, (zeros,), reading=MarkerPosition(("ball",), {}, None, np.array([*INSTRUMENT, *PLACE])))
    rows = replace(recordings_of(arm, q, np.zeros((len(q), 3)), test), time=60.0 * np.arange(len(q)))
    values = np.concatenate([chain.start()[: chain.base], [0.0, 0.0, 2e-4, -3e-4, 2e-4, 0.0, 0.0]])
    noise = NOISE * np.random.default_rng(1).standard_normal((len(q), 3))
    read = chain.predict(row_data(rows, arm), values) + moved + noise
    return replace(rows, deflections=read, deviations=np.full(read.shape, NOISE))


def search_of(arm: SerialRobot, recordings: Recordings) -> Search:
    """Zeros of all joints or a drift of the instrument: nothing else is in the library."""
    sample = data_of(recordings, arm, reading_of(arm, recordings)).counting(~recordings.test)
    base = fit(Chain(arm, reading=sample.reading), sample)
    effects: list[Effect] = [
        GeometricError.from_text(arm, "all joints"), InstrumentDrift.from_text(arm, "instrument", "shift")
    ]  # fmt: skip
    return Search.over(Names(arm, sample, candidates(effects, sample, arm, base.values), known_noise=True))


def found(search: Search) -> tuple[Names, NamedModel]:
    """What may be named, and the best model."""
    return search.known_names, next(search.ends()).model


def by_lift(count: int) -> Array:
    """Configurations of which the lift only grows with time, in eight steps."""
    q = configurations(count, 2)
    q[:, 0] = 0.1 * (np.arange(count) * 8 // count)
    return q


def test_what_changes_with_the_lift_is_no_drift_because_lifts_were_visited_in_order(arm: SerialRobot) -> None:
    q = by_lift(160)
    bend = np.outer(q[:, 0] ** 2, [2e-3, 0.0, 0.0])
    names, model = found(search_of(arm, positions(arm, q, bend)))
    assert model.keys == (ZEROS,)
    (remark,) = names.confounded_time(model)
    assert isinstance(remark, ConfoundedTime)
    assert (remark.name, remark.imitations) == ("q1_m", (DRIFT,))
    assert remark.share > 0.98
    assert "is not named" in sentence(remark)


def test_a_drift_is_named_where_it_shows_at_one_lift_as_well(arm: SerialRobot) -> None:
    drifting = np.outer(np.linspace(0.0, 2e-3, 160), [1.0, 0.0, 0.0])
    names, model = found(search_of(arm, positions(arm, by_lift(160), drifting)))
    assert DRIFT in model.keys
    (remark,) = names.confounded_time(model)
    assert isinstance(remark, ConfoundedTime)
    assert remark.imitations == ()
    assert "also shows among rows with the same" in sentence(remark)


def test_where_time_is_not_confounded_nothing_is_said(arm: SerialRobot) -> None:
    drifting = np.outer(np.linspace(0.0, 2e-3, 160), [1.0, 0.0, 0.0])
    names, model = found(search_of(arm, positions(arm, configurations(160, 2), drifting)))
    assert DRIFT in model.keys
    assert names.confounded_time(model) == ()


def test_one_effect_that_held_out_rows_refute_does_not_take_the_others_with_it(arm: SerialRobot) -> None:
    """Fitted rows drift by what the held-out rows do not: the zeros of the joints stay, the drift goes."""
    test = np.arange(160) % 4 == 0
    moved = np.outer(np.where(test, 0.0, np.linspace(0.0, 2e-3, 160)), [1.0, 0.0, 0.0])
    search = search_of(arm, positions(arm, configurations(160, 2), moved, test))
    names, model = search.known_names, next(search.ends()).model
    assert set(model.keys) == {ZEROS, DRIFT}
    kept, errors = confirmed(names, model, names.base.fit, test)
    assert kept.keys == (ZEROS,)
    assert errors.test_after < errors.test_before
    worse = names.without(model, model.keys.index(ZEROS))
    assert confirmed(names, worse, names.base.fit, test)[0].keys == ()


def bipod_search(effects: list[Effect] | None, *parts: Effect, parameters: list[float]) -> Search:
    recordings = simulated(NAME, *parts, parameters=parameters, series=20)
    sample, here = sample_of(NAME, recordings), robot(NAME)
    chosen = library(here, recordings) if effects is None else effects
    entries = candidates(chosen, sample, here, base_fit(NAME, sample).values)
    return Search.over(Names(here, sample, entries, known_noise=True))


def test_physics_at_its_limit_is_no_name() -> None:
    """A gap of 15 µm where no gap may exceed 5 µm: the search goes on without it, and says so."""
    narrow = effect(NAME, "leg_backlash", "leg 1", "middle")
    narrow.parameters = (replace(narrow.parameters[0], high=5e-6), *narrow.parameters[1:])
    names, model = found(bipod_search([narrow, FRICTION], PLAY, parameters=[1.5e-5]))
    assert narrow.key not in model.keys
    assert names.at_limit(model) == "gap_m of leg 1"
    assert any(entry["step"] == "limits" for entry in names.log.entries)


def test_an_effect_by_which_left_out_rows_do_not_gain_goes() -> None:
    """Play is there; friction of another leg beside it only describes the noise of the rows that were fitted."""
    names, model = found(bipod_search(None, PLAY, parameters=[1.5e-5]))
    none = np.zeros(len(names.sample.counts), dtype=bool)
    names.known_noise = False

    def kept(one: NamedModel) -> NamedModel:
        return confirmed(names, one, names.base.fit, none)[0]

    assert kept(model) is model
    further = next(one for one in names.library if one.effect.key == FRICTION.key)
    parts = [*names.parts(model, model.candidates), further.starts[0]]
    assert kept(names.model([*model.candidates, further], parts, model)).keys == model.keys


@cache
def clear() -> Search:
    """Of two effects of clear size."""
    return bipod_search(None, FRICTION, PLAY, parameters=[60.0, 2e-5])


def test_clear_effects_are_named_by_every_nine_tenths() -> None:
    stable = stability(*found(clear()))
    assert stable is not None
    assert (stable.refits, stable.same, stable.shares) == (OPTIONS.refits, 1.0, (1.0, 1.0))


def test_refits_on_reduced_normal_equations_name_what_searches_on_the_rows_name() -> None:
    """Shares of a play near the threshold against ten full searches, each without its tenth: alike to one in ten."""
    search = bipod_search(None, PLAY, parameters=[2.4e-6])
    names, model = found(search)
    assert model.keys == (PLAY.key,)
    stable = stability(names, model)
    assert stable is not None
    assert 0.0 < stable.same < 1.0
    blocks, named = blocks_of(names.sample, OPTIONS.refits), []
    for tenth in range(OPTIONS.refits):
        part = Search.over(names.of_rows(names.sample.restricted(blocks != tenth)))
        named.append(next(part.ends()).model.keys == model.keys)
    assert abs(float(np.mean(named)) - stable.same) <= 0.1 + 1e-9


def test_names_do_not_hang_on_whether_rows_are_marked_for_testing() -> None:
    """Two effects of clear size, named from all series and from three quarters of them."""
    search = clear()
    names = search.known_names
    marked = Search.over(names.of_rows(names.sample.restricted(names.sample.rows.series % 4 != 0)))
    assert next(marked.ends()).model.keys == next(search.ends()).model.keys == (FRICTION.key, PLAY.key)

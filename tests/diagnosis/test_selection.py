"""What the search for physics charges, keeps and says of its alternatives."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from expdesign.chain.chain import Chain
from expdesign.chain.effect import Effect
from expdesign.chain.models.estimable import Estimable
from expdesign.chain.recordings.recordings import Recordings
from expdesign.diagnosis import library as library_module
from expdesign.diagnosis.diagnose import diagnose
from expdesign.diagnosis.evidence.search import Search
from expdesign.diagnosis.findings import findings, reported
from expdesign.diagnosis.frame import framed
from expdesign.diagnosis.held_out import held_out
from expdesign.diagnosis.library import candidates, library
from expdesign.diagnosis.names import NamedModel, Names
from expdesign.diagnosis.options import OPTIONS
from expdesign.diagnosis.posterior import standing
from expdesign.diagnosis.stages import unheard
from expdesign.estimation.fit import Fit, fit
from tests.cases import robot
from tests.diagnosis.samples import base_fit, effect, sample_of, simulated

NAME = "bipod-unequal"
FRICTION = effect(NAME, "friction_hysteresis", "leg 2", "rigid")
PLAY = effect(NAME, "leg_backlash", "leg 1", "middle")


def search_of(recordings: Recordings, *, known_noise: bool = True, effects: list[Effect] | None = None) -> Search:
    sample, here = sample_of(NAME, recordings), robot(NAME)
    chosen = library(here, recordings) if effects is None else effects
    entries = candidates(chosen, sample, here, base_fit(NAME, sample).values)
    return Search.over(Names(here, sample, entries, known_noise=known_noise))


@cache
def found() -> tuple[Search, NamedModel]:
    """Of play alone, searched once."""
    search = search_of(simulated(NAME, PLAY, parameters=[1.5e-5]))
    return search, next(search.ends()).model


def test_the_search_keeps_what_it_needs_and_nothing_else() -> None:
    search, model = found()
    assert [effect.physics for effect in model.effects] == ["leg_backlash"]
    assert search.known_names.base.misfit - model.misfit > 2.0 * OPTIONS.alarm
    assert model.fit.values[-1] == pytest.approx(1.5e-5, rel=0.2)
    kept = [entry for entry in search.known_names.log.entries if entry["kept"]]
    assert kept
    for entry in search.known_names.log.entries:
        assert set(entry) == {"step", "effects", "chi2", "penalised_misfit", "kept", "reason"}


def test_models_beside_laws_are_not_among_those_of_named_effects() -> None:
    """A diagnosis that is ended compares misfits, and a law beside a model takes its share of them."""
    names = search_of(simulated(NAME, PLAY, parameters=[1.5e-5]), effects=[PLAY]).known_names
    direction = np.ones((names.sample.readings, 1))
    beside = names.model((), [], names.base, [(0, direction, 1.0)])
    assert beside is not names.base
    assert names.models == [names.base]


def test_an_effect_costs_its_parameters_and_the_places_where_it_was_looked_for() -> None:
    """−2·log evidence + 2·ln(places) + 2·ln(kinds): the same effect costs more in a larger library."""
    recordings = simulated(NAME, PLAY, parameters=[1.5e-5])
    everywhere = [e for e in library(robot(NAME), recordings) if e.physics == "leg_backlash"]
    alone = [e for e in everywhere if e.key == PLAY.key]
    few, many = (next(search_of(recordings, effects=effects).ends()).model for effects in (alone, everywhere))
    assert few.keys == many.keys
    assert many.fit.chi2 == pytest.approx(few.fit.chi2, rel=1e-9)
    assert many.misfit - few.misfit == pytest.approx(2.0 * np.log(len(everywhere)), rel=1e-6)


def test_with_an_unknown_noise_the_scale_of_the_deviations_does_not_matter() -> None:
    search = search_of(simulated(NAME, PLAY, parameters=[1.5e-5]), known_noise=False)
    assert next(search.ends()).model.keys == found()[1].keys


def test_removing_an_effect_of_two_leaves_the_other() -> None:
    search = search_of(simulated(NAME, FRICTION, PLAY, parameters=[60.0, 2e-5]))
    model = next(search.ends()).model
    assert {effect.physics for effect in model.effects} == {"friction_hysteresis", "leg_backlash"}
    for index, candidate in enumerate(model.candidates):
        smaller = search.known_names.without(model, index)
        assert candidate not in smaller.candidates
        assert len(smaller.candidates) == 1
        assert smaller.fit.chi2 > model.fit.chi2


def test_the_standing_of_an_effect() -> None:
    """Strong evidence leaves no doubt; a rival counts by exp(−½·Δ/temperature)."""
    search, model = found()
    without = search.known_names.without(model, 0)
    stands = standing(model, 0, [without, *search.instead(model, 0, 60.0)[0]])
    assert stands.probability > 0.95
    assert "leg_backlash" not in stands.indistinguishable
    alone = standing(model, 0, [without])
    assert alone.probability == pytest.approx(
        OPTIONS.surest / (1.0 + np.exp(-0.5 / OPTIONS.temperature * (without.misfit - model.misfit)))
    )
    assert alone.probability >= stands.probability


def test_a_law_of_no_declared_form_in_the_place_of_a_name_counts_as_the_physics_that_it_is() -> None:
    """Of an equally likely law P(name) is half; one of the same port and inputs is the same physics."""
    search, model = found()
    without = search.known_names.without(model, 0)
    alone = standing(model, 0, [without])
    own = model.effects[0].component
    other = standing(model, 0, [without], {(own, "friction_hysteresis"): 0.0})
    assert other.probability == pytest.approx(0.5 * OPTIONS.surest, rel=0.01)
    assert other.indistinguishable == ("friction_hysteresis",)
    same = standing(model, 0, [without], {(own, "leg_backlash"): 0.0})
    assert same.probability >= alone.probability
    assert not same.indistinguishable
    nameless = standing(model, 0, [without], {(own, "law"): -1.0, (own, "creep"): -20.0})
    assert nameless.probability == pytest.approx(OPTIONS.surest / (1.0 + np.exp(-1.0 / OPTIONS.temperature)), rel=0.01)
    assert not nameless.indistinguishable


def test_laws_in_the_place_of_a_name_are_told_by_their_port_and_inputs() -> None:
    """Play at a leg is a step of its force there; that such a law has no form of its own is not charged to it."""
    here = robot(NAME)
    frame = framed(here, simulated(NAME, PLAY, parameters=[1.5e-5]), without=frozenset(), report=unheard)
    model = found()[1]
    again = frame.search.known_names.model(model.candidates, [model.fit.values[-1:]])
    laws = frame.search.instead(again, 0, 60.0)[1]
    (own,) = (gain for (where, physics), gain in laws.items() if physics == PLAY.physics and where == PLAY.component)
    assert own > -10.0
    assert all(gain < own for (_, physics), gain in laws.items() if physics != PLAY.physics)


def test_two_names_for_one_thing_share_the_probability() -> None:
    """In the plane a base that shifts and a mount that shifts move the tool alike: neither can be told."""
    base = effect(NAME, "base_compliance", "base", "diagonal")
    mount = effect(NAME, "platform_compliance", "platform", "diagonal")
    recordings = simulated(NAME, base, parameters=[2e-8, 0.0])
    search = search_of(recordings, effects=[base, mount])
    model = next(search.ends()).model
    (finding,) = findings(search, model)
    assert finding.probability == pytest.approx(0.5 * OPTIONS.surest, abs=0.01)
    assert len(finding.indistinguishable) == 1
    assert {finding.physics, *finding.indistinguishable} == {"base_compliance", "platform_compliance"}
    assert finding.rival is not None


def fitted(values: list[float], covariance: np.ndarray) -> Fit:  # type: ignore[type-arg]
    nothing = np.zeros((1, 1))
    known = Estimable.from_covariance(covariance)
    return Fit(None, np.array(values), known, nothing, nothing[None], 0.0, 1, 2)  # type: ignore[arg-type]


def test_reported_intervals_are_those_of_the_delta_method() -> None:
    """Amplitude of a sine and a cosine: its standard deviation against a draw of 10⁵, to 4 standard errors (1 %)."""
    screw = effect(NAME, "encoder_periodic_error", "leg 1")
    mean, covariance = np.array([3e-6, 4e-6, 1e-2]), np.diag([1e-14, 4e-14, 1e-10])
    covariance[0, 1] = covariance[1, 0] = 1e-14
    found = reported(screw, fitted(mean.tolist(), covariance), slice(0, 3), 1.0)
    draws = np.random.default_rng(0).multivariate_normal(mean, covariance, 100_000)
    amplitude = np.hypot(draws[:, 0], draws[:, 1])
    estimate, low, high = found["amplitude_m"]
    assert estimate == pytest.approx(5e-6)
    assert (high - low) / (2 * 1.959964) == pytest.approx(amplitude.std(), rel=0.01)
    wider = reported(screw, fitted(mean.tolist(), covariance), slice(0, 3), 4.0)["amplitude_m"]
    assert wider[2] - wider[1] == pytest.approx(2.0 * (high - low))


def test_a_parameter_that_the_recordings_do_not_determine_has_no_interval() -> None:
    scale = effect(NAME, "instrument_scale", "instrument")
    covariance = np.array([[1e-4, np.inf], [np.inf, np.inf]])
    found = reported(scale, fitted([0.1, 0.2], covariance), slice(0, 2), 1.0)
    assert found["scale_x"][2] == pytest.approx(0.1 + 1.96 * 0.01, rel=1e-3)
    # All that is possible: a reading between a tenth and ten times the truth.
    assert found["scale_y"] == (pytest.approx(0.2), -0.9, 9.0)


def test_an_interval_ends_where_the_parameter_does() -> None:
    """An estimate at its bound: 0 to x, not -x to x."""
    found = reported(PLAY, fitted([0.0], np.array([[1e-12]])), slice(0, 1), 1.0)
    assert found["gap_m"] == (0.0, 0.0, pytest.approx(1.96e-6, rel=1e-3))


@pytest.mark.parametrize("marked", [False, True])
def test_held_out_rows_are_not_fitted(marked: bool) -> None:
    """Noise of known size: √(1 + p/M) on rows that were not fitted, √(1 − p/M) on those that were, and no surprise."""
    squares = np.zeros(3)
    count, rows = 60, np.arange(24)
    test = rows % 4 == 0 if marked else np.zeros(24, dtype=bool)
    first = sample_of(NAME, simulated(NAME), ~test)
    for seed in range(count):
        sample = replace(first, recordings=simulated(NAME, seed=seed))
        base = base_fit(NAME, sample)
        errors = held_out(base, base, sample, test)
        assert errors.test_after == pytest.approx(errors.test_before, rel=1e-9)
        squares += [errors.train_before**2, errors.test_before**2, errors.test_surprise**2]
    readings = 2 * int((~test).sum())
    train, held, surprise = squares / count
    assert train == pytest.approx(1.0 - 2.0 / readings, abs=4.0 * np.sqrt(2.0 / (readings * count)))
    held_readings = 2 * int(test.sum()) if marked else readings
    assert held > train
    # The leverage of held-out rows is about p/M of the fitted ones, at most a few times that.
    assert 1.0 - 4.0 * np.sqrt(2.0 / (held_readings * count)) < held < 1.0 + 6.0 * 2.0 / readings
    assert surprise == pytest.approx(1.0, abs=4.0 * np.sqrt(2.0 / (held_readings * count)))


def test_ignorance_excuses_held_out_errors_up_to_the_size_of_the_noise() -> None:
    test = np.arange(24) % 4 == 0
    sample = sample_of(NAME, simulated(NAME), ~test)
    base = base_fit(NAME, sample)
    vague = base.known_as(base.estimable.scaled(1e12))
    errors = held_out(base, vague, sample, test)
    assert errors.test_surprise == pytest.approx(errors.test_after / np.sqrt(2.0), rel=1e-6)


def test_a_base_that_imitates_what_one_law_says_is_not_named() -> None:
    """With a coupling of two legs left out, a base that yields in all directions brings the recordings to the noise."""
    coupling = effect("irregular", "leg_coupling", "leg 2", "shared with leg 5")
    recordings = simulated("irregular", coupling, parameters=[2.5e-8], series=16)
    result = diagnose(robot("irregular"), recordings, without=frozenset({"leg_coupling"}))
    assert str(result.findings[0].component) == "leg 2"
    assert "base_compliance" not in {finding.physics for finding in result.findings}
    listed = diagnose(robot("irregular"), recordings)
    assert [finding.physics for finding in listed.findings] == ["leg_coupling"]


def test_an_effect_without_memory_is_looked_at_beside_one_with_memory() -> None:
    """Its directions beside it are those of the chain with both."""
    recordings = simulated(NAME, FRICTION, parameters=[0.02])
    sample, here = sample_of(NAME, recordings), robot(NAME)
    base = base_fit(NAME, sample).values
    (candidate,) = candidates([PLAY], sample, here, base)
    present = fit(Chain(here, (FRICTION,)), sample, np.append(base, FRICTION.neutral()))
    found = library_module.beside(candidate, present, sample, here)
    values = np.concatenate([present.values, candidate.starts[0]])
    slopes = Chain(here, (FRICTION, PLAY)).predict_with_sensitivities(sample.rows, values)[1]
    expected = sample.whiten(slopes[:, sample.recordings.axes, -1:]).reshape(-1, 1)
    np.testing.assert_allclose(found.directions[0].matrix(), expected, rtol=1e-9, atol=1e-12)

"""Bodies: a base model that does not deflect, and the physics of what they stand on."""

from dataclasses import replace

import numpy as np
import pytest

from expdesign.chain import chain as chain_module
from expdesign.chain.chain import Chain
from expdesign.chain.effect import Effect
from expdesign.chain.effects.structure.compliance import BaseCompliance
from expdesign.chain.effects.support.history import SupportCreep, SupportFriction
from expdesign.chain.effects.support.statics import SupportCompliance, SupportNonlinearity, SupportPlay, SupportRocking
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.row import row_data
from expdesign.coordinates import SPATIAL
from expdesign.diagnosis.diagnose import diagnose
from expdesign.diagnosis.library import library
from expdesign.diagnosis.result import Diagnosis
from expdesign.estimation.fit import Fit, fit, summarise
from expdesign.estimation.shared_noise import SharedNoise
from tests.chain.bodies import BODY, DEVIATIONS, recordings, rows
from tests.fitting import data_of
from tests.identification.experiments import read
from tests.oracle import Array

LIFTING = recordings(lifting=True)


def test_an_error_of_a_weight_is_offered_only_where_weights_were_put_on() -> None:
    """Wrenches that somebody measured, changes or not, hold no weight that could be forgotten or off its centre."""
    frame = rows().drop(columns=[f"abs_{name}" for name in SPATIAL.wrench])
    of_weights = {"payload_mass_error", "payload_com_offset"}
    assert not of_weights & {effect.physics for effect in library(BODY, read(frame, BODY))}
    weights = frame.drop(columns=list(SPATIAL.wrench)).assign(mass_kg=np.resize([0.0, 5.0, 9.0], len(frame)))
    weights = weights.assign(com_x_m=0.1, com_y_m=0.0, com_z_m=0.2)
    assert of_weights <= {effect.physics for effect in library(BODY, read(weights, BODY))}


def predicted(effects: tuple[Effect, ...], values: Array | list[float], points: Recordings) -> Array:
    return Chain(BODY, effects).predict(row_data(points, BODY), np.asarray(values, dtype=float))


def test_the_base_model_does_not_deflect_at_all() -> None:
    assert not predicted((), np.zeros(0), LIFTING).any()


def test_a_long_series_in_few_calls_is_the_same_as_row_by_row(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(chain_module, "_LARGEST_CALL", 16)
    effects = (SupportFriction.from_text(BODY, "base", "oblique"), SupportCreep.from_text(BODY, "base"))
    values = np.array([2e-6, 1e-6, 30.0, 0.7, *(1e-6 * np.arange(1.0, 7.0)), 40.0])
    data = row_data(LIFTING, BODY)
    chain = Chain(BODY, effects)
    whole = chain.predict_with_sensitivities(data, values)
    assert max(count for _, count, _ in chain._several_rows) == 16 < np.bincount(data.series).max()
    plain = Chain(BODY, effects).predict(data, values)
    monkeypatch.setattr(chain_module, "_LARGEST_CALL", 1)
    for found, expected in zip(whole, Chain(BODY, effects).predict_with_sensitivities(data, values), strict=True):
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-18)
    np.testing.assert_allclose(plain, whole[0], rtol=1e-12, atol=1e-18)


def test_a_centre_of_rotation_is_a_full_compliance_about_that_point() -> None:
    """Oracle: C_O = Xᵀ·blkdiag(0, C)·X of a rotation about a point, moved to the origin of O by hand."""
    centre = np.array([0.2, 0.4, -0.5])
    rotation = np.array([[3.0, 0.4, -0.2], [0.4, 2.0, 0.3], [-0.2, 0.3, 1.0]]) * 1e-6
    upper = [rotation[0, 1], rotation[0, 2], rotation[1, 2]]
    found = predicted(
        (SupportCompliance.from_text(BODY, "base", "centre"),), [*np.diag(rotation), *upper, *centre], LIFTING
    )
    for row in range(0, len(LIFTING), 7):
        position = BODY.home + LIFTING.configurations[row, :3]
        force, moment = LIFTING.wrenches[row, :3], LIFTING.wrenches[row, 3:]
        turn = rotation @ (moment + np.cross(position - centre, force))
        np.testing.assert_allclose(found[row], [*np.cross(turn, position - centre), *turn], rtol=1e-12, atol=1e-20)


def test_play_jumps_by_its_gap_and_only_where_the_whole_load_changes_sign() -> None:
    found = predicted((SupportPlay.from_text(BODY, "base", "about y"),), [1e-4, 0.0, 1e-2], LIFTING)
    whole, before = LIFTING.absolute[:, 4], (LIFTING.absolute - LIFTING.wrenches)[:, 4]
    jump = 0.5e-4 * (np.sign(whole) - np.sign(before))
    far = np.abs(whole) > 1.0
    np.testing.assert_allclose(found[far, 4], jump[far], rtol=0.0, atol=1e-8)
    assert (jump[far] != 0.0).any()
    assert not found[:, [0, 1, 2, 3, 5]].any()


def test_rocking_turns_about_a_line_and_jumps_where_the_moment_about_that_line_changes_sign() -> None:
    """Oracle: the points of the line stay, and the origin of P moves on a circle about it."""
    gap, across, height = 1e-4, 0.3, -0.2
    found = predicted(
        (SupportRocking.from_text(BODY, "base", "rocking about y"),), [gap, across, height, 0.0, 1e-2], LIFTING
    )
    arm = BODY.home + LIFTING.configurations[:, :3] - np.array([across, 0.0, height])
    arm[:, 1] = 0.0
    loads = (LIFTING.absolute, LIFTING.absolute - LIFTING.wrenches)
    whole, before = (load[:, 4] + arm[:, 2] * load[:, 0] - arm[:, 0] * load[:, 2] for load in loads)
    turn = 0.5 * gap * (np.sign(whole) - np.sign(before))
    far = (np.abs(whole) > 1.0) & (np.abs(before) > 1.0)
    assert (turn[far] != 0.0).any()
    expected = np.column_stack([turn * arm[:, 2], 0.0 * turn, -turn * arm[:, 0], 0.0 * turn, turn, 0.0 * turn])
    np.testing.assert_allclose(found[far], expected[far], rtol=0.0, atol=1e-8)


def test_friction_follows_the_play_operator() -> None:
    friction, compliance = 25.0, 3e-6
    found = predicted((SupportFriction.from_text(BODY, "base", "about x"),), [compliance, friction], LIFTING)
    carried = 0.0
    for row, load in enumerate(LIFTING.wrenches[:, 3]):
        carried = min(max(carried, load - friction), load + friction)
        np.testing.assert_allclose(found[row, 3], compliance * carried, rtol=1e-12, atol=1e-20)


def test_lift_off_adds_compliance_beyond_a_load_alone() -> None:
    found = predicted((SupportNonlinearity.from_text(BODY, "base", "lift-off about x"),), [1e-6, 40.0], LIFTING)
    whole, before = LIFTING.absolute[:, 3], (LIFTING.absolute - LIFTING.wrenches)[:, 3]
    expected = 1e-6 * (np.maximum(whole - 40.0, 0.0) - np.maximum(before - 40.0, 0.0))
    np.testing.assert_allclose(found[:, 3], expected, rtol=1e-12, atol=1e-20)


_SPRINGS = [2e-8, 2e-8, 1e-8, 2e-7, 3e-7, 1e-7]


def diagnosed(
    effects: tuple[Effect, ...], values: list[float], axes: tuple[int, ...], *, count: int, stated: bool = True
) -> Diagnosis:
    """Diagnosis of simulated recordings with the noise that they state (or do not), a third of the rows held out."""
    points = recordings(count=count, axes=axes)
    exact = predicted(effects, np.array(values), points)[:, list(axes)]
    noise = np.random.default_rng(3).standard_normal(exact.shape) * np.array(DEVIATIONS)[list(axes)]
    test = np.arange(count) // 10 % 3 == 1
    deviations = points.deviations if stated else None
    return diagnose(BODY, replace(points, deflections=exact + noise, deviations=deviations, test=test))


def test_a_base_model_without_parameters_is_judged_beside_laws_as_any_other() -> None:
    """What laws beside it share is whitened, and there are no derivatives to whiten."""
    points = recordings(count=12, axes=(3, 4))
    sample = data_of(points, BODY).counting(np.ones(12, dtype=bool))
    shared = SharedNoise.of(np.ones((24, 1)))
    residuals, slopes = replace(sample, shared=shared).residuals_with_sensitivities(Chain(BODY), np.zeros(0))
    assert slopes.shape == (12, 2, 0)
    np.testing.assert_allclose(residuals.ravel(), shared.whitened(sample.residuals(Chain(BODY), np.zeros(0)).ravel()))


def test_a_body_on_springs_is_on_springs() -> None:
    """All that is read is what a linear support does; no law of a platform takes the place of its name."""
    result = diagnosed((BaseCompliance.from_text(BODY, "base", "diagonal"),), _SPRINGS, tuple(range(6)), count=60)
    assert result.verdict == "explained"
    assert [f.physics for f in result.findings] == ["base_compliance"]


@pytest.mark.slow
def test_play_on_a_compliant_support_is_found_with_unmeasured_axes() -> None:
    effects = (SupportCompliance.from_text(BODY, "base", "axes"), SupportPlay.from_text(BODY, "base", "about y"))
    result = diagnosed(effects, [2e-6, 3e-6, 1e-6, 2e-4, 0.0, 5.0], (3, 4), count=150)
    assert result.verdict == "explained"
    assert {f.physics for f in result.findings} == {"base_compliance", "joint_backlash"}
    play = next(f for f in result.findings if f.physics == "joint_backlash")
    assert play.parameters["gap_rad"][1] < 2e-4 < play.parameters["gap_rad"][2]
    assert result.errors.test_after < 1.2
    assert result.errors.test_before > 5.0
    compliance = next(f for f in result.findings if f.physics == "base_compliance")
    assert compliance.parameters["compliance_rz_rz_rad_per_Nm"][2] > 1e299, "what was not measured is not known"


@pytest.mark.slow
def test_play_of_a_foot_is_found_as_rocking_about_a_line_on_the_ground() -> None:
    """The line is 0.25 m to the side of the body's origin and below it, so that forces change the play over too."""
    effects = (
        BaseCompliance.from_text(BODY, "base", "diagonal"),
        SupportRocking.from_text(BODY, "base", "rocking about y"),
    )
    result = diagnosed(effects, [*_SPRINGS, 2e-4, 0.25, 0.0, 0.0, 1.0], (0, 2, 4), count=150)
    assert result.verdict == "explained"
    assert {f.physics for f in result.findings} == {"base_compliance", "joint_backlash"}
    play = next(f for f in result.findings if f.physics == "joint_backlash")
    for name, truth in {"gap_rad": 2e-4, "axis_x_m": 0.25, "axis_z_m": 0.0}.items():
        estimate, low, high = play.parameters[name]
        assert estimate - 2.0 * (estimate - low) < truth < estimate + 2.0 * (high - estimate), name
    assert result.errors.test_after < 1.2


def test_a_body_without_standard_deviations_is_judged_by_the_noise_that_the_explanation_leaves() -> None:
    """No compliance is fitted at first: all that was read is what the base model leaves."""
    effects = (SupportCompliance.from_text(BODY, "base", "axes"),)
    values = [2e-6, 3e-6, 1e-6]
    known = diagnosed(effects, values, (3, 4), count=60)
    estimated = diagnosed(effects, values, (3, 4), count=60, stated=False)
    assert estimated.verdict == "explained"
    assert [f.physics for f in estimated.findings] == ["base_compliance"]
    assert estimated.errors.train_after == pytest.approx(1.0, abs=0.1)
    assert estimated.errors.test_after == pytest.approx(known.errors.test_after, rel=0.2)
    assert estimated.errors.test_before == pytest.approx(known.errors.test_before, rel=0.2)


def test_moments_of_a_weight_do_not_determine_single_elements_of_a_compliance() -> None:
    """M·g = 0 in all rows hides λ·g·gᵀ in C: a level body's C_zz alone, and more elements of one that is tilted.

    Oracle: a compliance changed that way turns alike. With one moment along gravity all is determined.
    """
    effect, data = SupportCompliance.from_text(BODY, "base", "rotation"), recordings(count=80, axes=(3, 4, 5))
    for gravity in (np.array([0.0, 0.0, -1.0]), np.array([0.6, 0.0, -0.8])):
        points = replace(data, wrenches=_across(data.wrenches, gravity), absolute=_across(data.absolute, gravity))
        values = np.array([2e-6, 3e-6, 1e-6, 2e-7, 0.0, 0.0])
        hidden = 1e-6 * np.array([*gravity**2, *(gravity[i] * gravity[j] for i, j in ((0, 1), (0, 2), (1, 2)))])
        np.testing.assert_allclose(
            predicted((effect,), values + hidden, points), predicted((effect,), values, points), rtol=1e-9, atol=1e-14
        )
        for moment, determined in ((0.0, False), (5.0, True)):
            loaded = points.wrenches.copy()
            loaded[7, 3:] += moment * gravity
            assert _fitted(effect, values, replace(points, wrenches=loaded)).determined[2] == determined
    tilted = replace(data, wrenches=_across(data.wrenches, np.array([0.6, 0.0, -0.8])))
    undetermined = ~_fitted(effect, values, tilted).determined
    np.testing.assert_array_equal(undetermined, [True, False, True, False, True, False])


def test_what_a_weight_does_not_tell_stays_small_and_serves_other_loads() -> None:
    """On a floor that leans by 0.5° M_z is 0.009 M_y, and C_yz·M_z would do what C_yy·M_y does.

    The body leans otherwise in the second file, where a compliance that is shared out wrongly misses by far.
    """
    effects = (
        SupportCompliance.from_text(BODY, "base", "rotation"),
        SupportNonlinearity.from_text(BODY, "base", "lift-off about x"),
    )
    truth = np.array([2e-6, 3e-6, 0.0, 2e-7, 0.0, 0.0, 1e-6, 40.0])
    first, second = np.array([0.0, 0.009, -1.0]), np.array([0.015, -0.01, -1.0])
    data = recordings(count=80, axes=(3, 4))
    points, others = (
        replace(data, wrenches=_across(data.wrenches, g), absolute=_across(data.absolute, g))
        for g in (first / np.linalg.norm(first), second / np.linalg.norm(second))
    )
    points = replace(points, deflections=predicted(effects, truth, points)[:, 3:5])
    fitting = data_of(points, BODY)
    chain = Chain(BODY, effects)
    found = fit(chain, fitting, np.array([*np.zeros(6), 1e-6, 20.0]))
    assert not found.determined.all()
    assert found.chi2 < 1e-3
    miss = (predicted(effects, found.values, others) - predicted(effects, truth, others))[:, 3:5]
    assert np.sqrt((miss**2).mean()) < 0.5 * DEVIATIONS[3]


def _across(wrenches: Array, gravity: Array) -> Array:
    """Wrenches (N, 6) without the moment along gravity."""
    along = np.outer(wrenches[:, 3:] @ gravity, gravity)
    return np.hstack([wrenches[:, :3], wrenches[:, 3:] - along])


def _fitted(effect: Effect, values: Array, points: Recordings) -> Fit:
    return summarise(Chain(BODY, (effect,)), data_of(points, BODY), values)

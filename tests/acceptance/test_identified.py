"""Acceptance after identification: the planned budget where the noise is as planned, and what recordings may hide."""

from dataclasses import replace
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import expdesign as xd
from expdesign.assurance.acceptance import hidden_risk
from expdesign.assurance.acceptance.decision import Decision
from expdesign.assurance.acceptance.hidden_risk import joint_model, left_out_by, left_out_risk
from expdesign.assurance.model_error.physics import offsets
from expdesign.assurance.model_error.recorded import Shown
from expdesign.assurance.model_error.settings import Assumptions
from expdesign.diagnosis.dispersion import with_share
from expdesign.estimation.whitening import Whitening
from expdesign.planning.plan import plan_frame
from expdesign.report.acceptance_texts import acceptance_record, sentences
from expdesign.report.at_targets import AtTargets
from tests.acceptance.test_acceptance import ERRORS, copies, decision
from tests.design.problems import HEXAPOD, plan_for, plan_table, problem, recorded

CASE = {"experiment.load.gravity": ..., "experiment.measurements": 6}
FEW = CASE | {"model_error": {"physics": ["leg_coupling"]}, "experiment.estimator": "weighted"}
"""Where what the recordings may hide is not what a test is about."""


@cache
def accepted() -> Decision:
    """The decision about a robot that is as its model says, with all physics that its recordings may hide."""
    case = problem(HEXAPOD, CASE)
    measured = recorded(case, load_errors=False)
    found = xd.identify(HEXAPOD["robot"], measured, targets=case).acceptance
    assert found is not None
    return found


def test_the_budget_is_the_planned_one_where_the_noise_is_as_planned() -> None:
    case = problem(HEXAPOD, FEW)
    plan = plan_for(case, 2)
    # Without noise the identified stiffness is that of the plan, about which load errors are linearised.
    measured = recorded(case, noise=False, load_errors=False)
    planned = decision(case, plan).budget
    found = xd.identify(HEXAPOD["robot"], measured, targets=case).acceptance
    assert found is not None
    names = [one.name for one in planned.contributions]
    assert [one.name for one in found.budget.contributions] == names
    np.testing.assert_allclose(found.budget.expanded, planned.expanded, rtol=1e-7)


@pytest.mark.parametrize(("estimator", "within"), [("generalised", 0.06), ("weighted", 1e-9)])
@pytest.mark.parametrize("errors", ERRORS)
def test_what_repeated_recordings_will_say_is_what_they_say(estimator: str, within: float, errors: str) -> None:
    """To within what more recordings change of the scale of generalised load errors."""
    case = problem(HEXAPOD, {**FEW, **ERRORS[errors], "experiment.estimator": estimator})
    found = []
    for count in (1, 4):
        rows = plan_frame(copies(plan_for(case, 2), count), case.loaded, False)
        recordings = xd.simulate(case, rows, noise=False, load_errors=False).frame
        decided = xd.identify(HEXAPOD["robot"], recordings, targets=case).acceptance
        assert decided is not None
        found.append(decided.budget)
    once, four = found
    np.testing.assert_allclose(once.repeated(4.0), four.expanded, rtol=within)
    assert (four.expanded < 0.8 * once.expanded).any()


def test_a_prior_is_known_once_however_often_the_plan_is_repeated() -> None:
    """Readings of which a prior of the stiffness decides say more when there are more of them, but not as √k."""
    changes = {f"experiment.deflection_noise.std.{axis}_m": 2e-5 for axis in ("dx", "dy", "dz")}
    changes |= {f"experiment.deflection_noise.std.{axis}_rad": 1e-4 for axis in ("drx", "dry", "drz")}
    case, found = problem(HEXAPOD, {**FEW, **ERRORS["none"], **changes}), []
    for count in (1, 4):
        rows = plan_frame(copies(plan_for(case, 2), count), case.loaded, False)
        recordings = xd.simulate(case, rows, noise=False, load_errors=False).frame
        decided = xd.identify(HEXAPOD["robot"], recordings, targets=case, prior=0.2).acceptance
        assert decided is not None
        found.append(decided.budget)
    once, four = found
    np.testing.assert_allclose(once.repeated(4.0), four.expanded, rtol=1e-6)
    assert (four.expanded > 0.55 * once.expanded).any()


def test_estimated_noise_has_degrees_of_freedom() -> None:
    case = problem(HEXAPOD, FEW)
    measured = recorded(case, load_errors=False)
    measured = measured.drop(
        columns=[n for n in measured if n in ("sx_m", "sy_m", "sz_m", "srx_rad", "sry_rad", "srz_rad")]
    )
    found = xd.identify(HEXAPOD["robot"], measured, targets=case).acceptance
    assert found is not None
    assert np.isfinite(found.budget.degrees).all()
    assert (found.budget.factor > 2.0).all()


def test_nothing_is_decided_with_a_model_that_its_recordings_refute(tmp_path: Path) -> None:
    case = problem(HEXAPOD, FEW)
    measured = recorded(case, load_errors=False)
    measured["dz_m"] += np.where(np.arange(len(measured)) % 2 == 0, 1e-5, -1e-5)
    identified = xd.identify(HEXAPOD["robot"], measured, targets=case)
    assert identified.acceptance is not None
    assert identified.acceptance.verdict == "not decided"
    record = identified.record["acceptance"]
    assert record["verdict"] == "not decided"
    assert record["passes"] is None
    for target in record["targets"]:
        assert target["passes"] is None
        for axis in target["axes"]:
            assert axis["passes"] is None
            assert axis["probability_beyond_tolerance"] is None
    (said,) = sentences(identified.acceptance)
    assert "not decided" in said
    assert "expdesign diagnose" in said
    identified.save(tmp_path / "out")
    page = (tmp_path / "out" / "report.html").read_text()
    assert '<dt>Acceptance</dt>\n<dd><span class="value">not decided</span></dd>' in page
    assert "The probability that any axis" not in page


def test_a_decision_counts_what_the_recordings_may_hide() -> None:
    """The parts of the risk add up, one sentence states them, and a robot that they endanger does not pass."""
    found = accepted()
    hidden = found.left_out
    assert hidden is not None
    assert 0.0 < hidden.nothing < 1.0
    matters = found.budget.matters
    right = replace(found, left_out=None)
    expected = hidden.nothing * right.axis_risk + found.hidden_axis_risk.sum(axis=0)
    np.testing.assert_allclose(found.axis_risk[matters], expected[matters])
    text = " ".join(sentences(found))
    assert "physics that these recordings may hide" in text
    # The same recordings against tolerances above U: the model alone passes, with what is hidden it does not.
    tight = replace(found.budget, tolerance=1.3 * found.budget.expanded * np.where(matters, 1.0, np.nan))
    assert replace(found, budget=tight, left_out=None).verdict == "pass"
    assert replace(found, budget=tight).verdict == "not proven"
    assert "likelier than the coverage leaves" in " ".join(sentences(replace(found, budget=tight)))


def test_the_risk_is_that_of_the_whole_robot() -> None:
    """Any axis at any target, by 200,000 draws of what recordings leave open; axes that pass one by one can fail."""
    found = accepted()
    matters = found.budget.matters
    tight = replace(found.budget, tolerance=1.02 * found.budget.expanded * np.where(matters, 1.0, np.nan))
    decided = replace(found, budget=tight)
    hidden = decided.left_out
    assert hidden is not None
    generator = np.random.default_rng(3)
    which = generator.choice(len(hidden.probability) + 1, 200_000, p=[hidden.nothing, *hidden.probability])
    count, tolerance = int(matters.sum()), tight.tolerance[matters]
    own = np.linalg.cholesky(tight.covariance[matters][:, matters] + 1e-30 * np.eye(count))
    errors = generator.standard_normal((len(which), count)) @ own.T
    for one in np.unique(which[which > 0]) - 1:
        rows, root = which == one + 1, hidden.roots[one][matters]
        sizes = generator.standard_normal((int(rows.sum()), root.shape[1]))
        errors[rows] += hidden.mean[one][matters] + sizes @ root.T
    beyond = np.abs(errors) > tolerance
    assert decided.robot_risk == pytest.approx(float(beyond.any(axis=1).mean()), abs=0.005)
    np.testing.assert_allclose(decided.axis_risk[matters], beyond.mean(axis=0), atol=0.004)
    assert decided.axis_risk[matters].max() < decided.robot_risk < decided.axis_risk[matters].sum()
    # The model alone: each axis passes by itself, all together are likelier to fail than the coverage leaves.
    alone = replace(decided, left_out=None)
    assert alone.axis_passes.all()
    assert alone.verdict == "not proven"
    assert "Every axis passes by itself" in " ".join(sentences(alone))
    record = acceptance_record(decided)
    assert record["probability_of_any_beyond_tolerance"] == decided.robot_risk


def test_the_odds_of_what_is_hidden_are_those_of_integrating_over_its_size() -> None:
    """One effect by brute force: the likelihood of the residuals averaged over 100,000 draws of its size."""
    case = problem(HEXAPOD, FEW)
    measured = recorded(case, load_errors=False)
    identified = xd.identify(HEXAPOD["robot"], measured, targets=case)
    assert identified.acceptance is not None
    hidden = identified.acceptance.left_out
    assert hidden is not None
    fit, rows = identified.result.fit, identified.result.recordings
    whitening = Whitening(identified.result.noise.deviations, references=rows.references)
    found = Shown(case, rows, whitening, Assumptions(physics=frozenset({"leg_coupling"})))
    base, shown, physics = found.base, found.directions, found.meir.physics
    shown = shown - base @ np.linalg.lstsq(base, shown, rcond=None)[0]
    residuals, start = fit.residuals.ravel(), offsets(physics)
    generator = np.random.default_rng(1)
    odds = []
    for first, last in pairwise(start):
        for scale in (1.0, 3.0):  # the size is assumed: as likely three times as large
            sizes = scale * generator.standard_normal((100_000, last - first))
            left = residuals - sizes @ shown[:, first:last].T
            gain = np.exp(0.5 * (residuals @ residuals - (left**2).sum(axis=1))).mean()
            odds.append(gain / len(physics) / 2.0)
    expected = np.array(odds) / (1.0 + sum(odds))
    np.testing.assert_allclose(hidden.probability, expected, rtol=0.1)


def test_friction_is_integrated_over_its_size(monkeypatch: pytest.MonkeyPatch) -> None:
    """A few sizes stand for all: the same odds and the same risk with twenty times as many."""
    case = problem(HEXAPOD, CASE | {"model_error": {"physics": ["friction_hysteresis"]}})
    measured = recorded(case, load_errors=False)
    found = AtTargets.identified(case, xd.identify(HEXAPOD["robot"], measured).result)
    shown = left_out_by(case, found.model)
    assert shown is not None
    monkeypatch.setattr(hidden_risk, "SIZES", tuple(np.linspace(0.05, 9.0, 200)))
    exact = replace(found.acceptance, left_out=left_out_risk(case, found.model, shown))
    assert found.acceptance.left_out is not None
    assert exact.left_out is not None
    assert found.acceptance.left_out.nothing == pytest.approx(exact.left_out.nothing, rel=0.02)
    assert found.acceptance.robot_risk == pytest.approx(exact.robot_risk, rel=0.1)


def test_physics_of_several_prior_sizes_is_believed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Friction is assumed to be about 1 N: recordings that hint at 4 N are not held for noise as readily."""
    case = problem(HEXAPOD, CASE)
    hidden = "friction_hysteresis at leg 4, rigid, 4 N"
    measured = recorded(case, conceal=hidden, seed=0, load_errors=False)
    found = AtTargets.identified(case, xd.identify(HEXAPOD["robot"], measured).result)
    shown = left_out_by(case, found.model)
    assert shown is not None
    monkeypatch.setattr(hidden_risk, "SCALES", (1.0,))
    before = replace(found.acceptance, left_out=left_out_risk(case, found.model, shown))
    assert found.acceptance.robot_risk > 1.5 * before.robot_risk


def test_what_a_fit_takes_up_does_not_depend_on_how_sure_its_predictions_are() -> None:
    """A covariance that is widened is for predictions; what is hidden is taken up by the fit as it was made."""
    case = problem(HEXAPOD, CASE)
    measured = recorded(case, load_errors=False)
    model = AtTargets.identified(case, xd.identify(HEXAPOD["robot"], measured).result).model
    shown = left_out_by(case, model)
    assert shown is not None
    exact, widened = (
        left_out_risk(case, replace(model, fit=fitted), shown) for fitted in (model.fit, with_share(model.fit, 0.01))
    )
    np.testing.assert_allclose(widened.probability, exact.probability, rtol=1e-9)
    np.testing.assert_allclose(widened.mean, exact.mean, rtol=1e-9)


HIDDEN = {
    "experiment.load_error": [
        {"source": "com", "std": [0.02, 0.02, 0.02]},
        {"source": "direction", "std": [0.01, 0.01]},
    ],
    "experiment.measurements": 8,
    "experiment.load.gravity": ...,
    "targets.0.payload.same_as": "experiment",
    "model_error": {"physics": ["leg_coupling"]},
}


POSES = ["x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad"]


def test_a_bias_by_way_of_load_errors_is_what_commands_then_have() -> None:
    """The change of the commands with a concealed coupling of legs, against the bias that the decision expects."""
    case = problem(HEXAPOD, HIDDEN)
    plan = plan_table(case)
    commands, motions = [], []
    coupling = "leg_coupling at leg 2, force of leg 1, 2e-9"
    for conceal in ((), coupling):
        recorded = xd.simulate(case, plan, conceal=conceal, noise=False, load_errors=False).frame
        identified = xd.identify(HEXAPOD["robot"], recorded, targets=case)
        found = xd.compensate(identified, case).frame
        commands.append(found[POSES].to_numpy(dtype=float))
        there = found.assign(**{name: found[f"target_{name}"] for name in POSES})
        moved = xd.simulate(case, there, conceal=conceal, noise=False, load_errors=False).frame
        motions.append(moved[["dx_m", "dy_m", "dz_m", "drx_rad", "dry_rad", "drz_rad"]].to_numpy(dtype=float))
    attained = (commands[1] + motions[1]) - (commands[0] + motions[0])
    model = AtTargets.identified(case, identified.result).model
    shown = left_out_by(case, model)
    assert shown is not None
    places = [(str(entry.effect.component), str(entry.effect.variant)) for entry in shown.meir.physics]
    place = places.index(("leg 2", "force of leg 1"))
    base, start = joint_model(case, model), offsets(shown.meir.physics)
    part = slice(start[place], start[place + 1])
    rows = len(base.readings)
    readings = model.whitening.unshared(shown.directions[:rows, part])
    at = (shown.meir.motions[..., part] * shown.meir.deviations[part]).reshape(-1, part.stop - part.start)
    expected = base.unexplained(readings, at)
    scale = 2e-9 / shown.meir.deviations[part]
    bias = (expected * scale).sum(axis=1).reshape(attained.shape)
    assert bias == pytest.approx(attained, rel=0.15, abs=0.05 * np.abs(attained).max())

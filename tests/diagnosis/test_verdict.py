"""When a model is believed to explain, and when to imitate."""

from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from expdesign.chain.chain import Chain
from expdesign.chain.component import ALL_JOINTS, PLATFORM
from expdesign.chain.effects.joints.bearings import JointCompliance
from expdesign.chain.effects.load.payload import UnknownTool
from expdesign.chain.models.estimable import Estimable
from expdesign.diagnosis.dispersion import NONE
from expdesign.diagnosis.findings import reported
from expdesign.diagnosis.held_out import HeldOut
from expdesign.diagnosis.names import NamedModel, Names
from expdesign.diagnosis.possible import at_limit
from expdesign.diagnosis.result import Diagnosis
from expdesign.diagnosis.verdict import doubt, verdict_without
from expdesign.estimation.goodness import LackOfFit, StatementOfFit
from expdesign.report.fit_texts import diagnosed_fit_sentences
from tests.chain.arm_rows import six_axis
from tests.diagnosis.samples import effect, simulated
from tests.diagnosis.test_selection import FRICTION, NAME, PLAY, search_of

MOST_EFFECTS = 3
GOOD = HeldOut(1.0, 1.0, 2.0, 1.02, 1.02, "")


def doubted(
    model: NamedModel, before: tuple[float, int], after: tuple[float, int], errors: HeldOut, *, known_noise: bool
) -> str:
    """Where three effects may be sought on a machine that reaches 1.3 m."""
    names = SimpleNamespace(most_effects=MOST_EFFECTS, reach=1.3, known_noise=known_noise, at_limit=lambda model: "")
    return doubt(cast(Names, names), model, before, after, errors)


@pytest.fixture(scope="module")
def one() -> NamedModel:
    """Play of one leg."""
    return next(search_of(simulated(NAME, PLAY, parameters=[1.5e-5]), effects=[PLAY]).ends()).model


@pytest.fixture(scope="module")
def many() -> NamedModel:
    """As many effects as the search allows, each known as if it showed."""
    effects = [PLAY, FRICTION, effect(NAME, "load_direction_tilt", "payload")]
    names = search_of(simulated(NAME, PLAY, parameters=[1.5e-5]), effects=effects).known_names
    assert len(effects) == names.most_effects == MOST_EFFECTS
    parts = [each.effect.neutral() + 1e-7 for each in names.library]
    found = names.model(names.library, parts)
    return replace(found, fit=found.fit.known_as(found.fit.estimable.scaled(1e-12)))


def test_without_effects_chi_squared_decides() -> None:
    assert verdict_without(StatementOfFit.of_chi2(200.0, 200)) == "consistent"
    assert verdict_without(StatementOfFit.of_chi2(20.0, 200)) == "consistent"
    assert verdict_without(StatementOfFit.of_chi2(300.0, 200)) == "unexplained"
    estimated = StatementOfFit(None, 200, None, origin="residuals")
    assert verdict_without(estimated) == "consistent"
    assert verdict_without(replace(estimated, lack_of_fit=LackOfFit(5.0, 100, 100, 1e-5))) == "unexplained"


def test_one_effect_that_fits_explains(one: NamedModel) -> None:
    assert doubted(one, (800.0, 200), (200.0, 199), GOOD, known_noise=True) == ""
    assert doubted(one, (800.0, 200), (200.0, 199), GOOD, known_noise=False) == ""


def test_a_mismatch_that_remains_is_no_explanation(one: NamedModel) -> None:
    assert "remains" in doubted(one, (800.0, 200), (300.0, 199), GOOD, known_noise=True)
    # 4 % of a large mismatch: no library is exact.
    assert doubted(one, (8000.0, 200), (500.0, 199), GOOD, known_noise=True) == ""


def test_what_does_not_predict_is_no_explanation(one: NamedModel) -> None:
    bad = replace(GOOD, test_surprise=1.5)
    assert "not predicted" in doubted(one, (800.0, 200), (200.0, 199), bad, known_noise=True)


def test_many_effects_explain_only_a_mismatch_of_which_an_imitation_would_leave_something(many: NamedModel) -> None:
    """5 % of the excess against three standard deviations of χ²: 60 for 200 degrees of freedom, i.e. an excess of 6."""
    assert "imitate" in doubted(many, (7.0 * 200, 200), (200.0, 197), GOOD, known_noise=True)
    assert doubted(many, (7.5 * 200, 200), (200.0, 197), GOOD, known_noise=True) == ""
    assert "imitate" in doubted(many, (100.0 * 200, 200), (300.0, 197), GOOD, known_noise=True)
    assert "imitate" in doubted(many, (7.5 * 200, 200), (200.0, 197), GOOD, known_noise=False)


@pytest.mark.parametrize("variance", [1e6, np.inf])
def test_an_effect_that_may_have_any_size_is_no_explanation(one: NamedModel, variance: float) -> None:
    covariance = one.fit.covariance.copy()
    covariance[-1, -1] *= variance
    loose = replace(one, fit=replace(one.fit, estimable=Estimable.from_covariance(covariance)))
    assert "how large" in doubted(loose, (800.0, 200), (200.0, 199), GOOD, known_noise=True)


@pytest.mark.parametrize(("shown", "said"), [(1e-6, ""), (1e-3, "how large")])
def test_bearings_of_which_those_that_are_loaded_do_not_yield_are_no_explanation(
    one: NamedModel, shown: float, said: str
) -> None:
    """All joints tilt, and the moments of the rows reach all but the last: what it does is open, whatever it is."""
    arm = six_axis()
    bearings = JointCompliance(arm, ALL_JOINTS)
    chain = Chain(arm, (bearings,))
    values = np.concatenate([np.ones(chain.compliances), np.full(5, 1e-5), [2.5e-5]])
    covariance = np.diag(np.concatenate([np.full(chain.compliances, 1e-4), np.full(5, shown**2), [np.inf]]))
    fitted = replace(one.fit, chain=chain, values=values, estimable=Estimable.from_covariance(covariance))
    model = replace(one, candidates=(replace(one.candidates[0], effect=bearings),), fit=fitted)
    assert said in doubted(model, (800.0, 200), (200.0, 199), GOOD, known_noise=True)
    assert bool(said) == bool(doubted(model, (800.0, 200), (200.0, 199), GOOD, known_noise=True))
    sentence = bearings.sentence(reported(bearings, fitted, chain.slices[0], 1.0))
    assert sentence.endswith("and undetermined µrad per N·m.")
    assert "1e+06" not in sentence


def test_a_value_that_no_machine_has_is_no_explanation(one: NamedModel) -> None:
    assert at_limit(one.fit, 1.0) == ""
    values = one.fit.values.copy()
    values[-1] = PLAY.parameters[0].high
    absurd = replace(one, fit=replace(one.fit, values=values))
    assert "gap_m of leg 1" in doubted(absurd, (800.0, 200), (200.0, 199), GOOD, known_noise=True)
    values[-1] = 0.0  # vanishing is possible
    assert at_limit(replace(one.fit, values=values), 1.0) == ""


def test_a_tool_that_is_farther_away_than_the_arm_reaches_is_no_explanation(one: NamedModel) -> None:
    """0.4 kg whose first moment is that of 6.5 m, of an arm that reaches 1.3 m; 0.2 m are those of a gripper."""
    arm = six_axis()
    tool = UnknownTool(arm, PLATFORM)
    candidate = replace(one.candidates[0], effect=tool)
    chain = Chain(arm, (tool,))

    def with_centre(metres: float) -> NamedModel:
        values = np.concatenate([np.ones(chain.compliances), 0.4 * np.array([1.0, 0.1, 0.0, metres])])
        return replace(one, candidates=(candidate,), fit=replace(one.fit, chain=chain, values=values))

    assert at_limit(with_centre(6.5).fit, 1.3) == "tool_com_z_m of platform"
    assert at_limit(with_centre(0.2).fit, 1.3) == ""
    said = doubted(with_centre(6.5), (9.0, 9), (9.0, 9), GOOD, known_noise=False)
    assert "beyond the limit of what a machine can be" in said


@pytest.mark.parametrize("verdict", ["unexplained", "explained", "consistent"])
def test_where_something_is_unexplained_it_is_not_said_that_nothing_speaks_against_the_model(verdict: str) -> None:
    estimated = StatementOfFit(None, 200, None, origin="residuals")
    made = SimpleNamespace(verdict=verdict, before=estimated, after=replace(estimated), widening=NONE, loads=None)
    base, found = diagnosed_fit_sentences(cast(Diagnosis, made))
    assert ("what the diagnosis found speaks against the diagnosed model" in found) == (verdict == "unexplained")
    assert ("what the diagnosis found" in base) == (verdict != "consistent")

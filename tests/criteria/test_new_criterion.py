"""Criteria that are infinite, of a wrong shape or without a derivative; tests/docs has those of docs/extending.md."""

from dataclasses import replace

import numpy as np
import pytest

from expdesign.errors import InputError
from expdesign.mechanics.differentiation import is_recorded
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.criterion import Criterion, criterion_values, known_criteria
from expdesign.planning.optimality.kktpm import kktpm
from expdesign.planning.search import search
from tests.design.problems import BIPOD, HEXAPOD, designs, problem
from tests.oracle import Array


class Broken(Criterion):
    name = title = "broken"

    def values(self, assessment: Assessment) -> Array:
        return np.full(assessment.batch, np.inf)


class Misshapen(Criterion):
    name = title = "misshapen"

    def values(self, assessment: Assessment) -> Array:
        return assessment.noise_variance.sum(axis=-1)


class Kinked(Criterion):
    """A kink that is not stated: its derivative is not finite where the difference vanishes."""

    name = title = "kinked"

    def values(self, assessment: Assessment) -> Array:
        duir = known_criteria()["duir"].values(assessment)
        return duir + np.sqrt(duir - duir)


def test_what_is_not_finite_or_not_one_number_per_design_is_said() -> None:
    here = problem(BIPOD)
    with pytest.raises(InputError, match=r"`broken` is not finite") as raised:
        search(replace(here, objectives=(Broken(), known_criteria()["feir"])))
    assert "objectives" in str(raised.value)
    with pytest.raises(InputError, match=r"`misshapen`.*shape"):
        criterion_values(Misshapen(), here.assess(*here.space.decode(designs(here, 3))))


@pytest.mark.filterwarnings("error")
def test_a_kink_that_is_not_stated_has_no_kkt_proximity() -> None:
    here = replace(problem(BIPOD), objectives=(Kinked(), known_criteria()["feir"]))
    assert np.isnan(kktpm(here, designs(here, 4))).all()


class Readings(Criterion):
    """DUIR in whole thousandths of a tolerance, as a technician reads it: steps, which have no gradient."""

    name = "readings"
    title = "DUIR as read"
    unit = "tolerances"
    differentiable = False

    def values(self, assessment: Assessment) -> Array:
        if is_recorded(assessment.measurements.observation):
            raise AssertionError("a criterion that has no gradient was asked for one")
        found = np.full(assessment.batch, np.nan)
        known = assessment.identifies_targets
        found[known] = np.ceil(1e3 * known_criteria()["duir"].values(assessment)[known]) / 1e3
        return found


def test_a_criterion_without_derivative_spans_a_front_by_exchanges(monkeypatch: pytest.MonkeyPatch) -> None:
    """It comes near the least DUIR that gradients find; nothing descends towards it, and no optimality conditions are
    stated.
    """
    options = {"population": 30, "generations": 40, "seed": 1, "polish": True}
    smooth = search(problem(HEXAPOD, {"optimiser": options}))
    monkeypatch.setattr("expdesign.planning.start.relaxed_designs", lambda here: here.space.canonical(designs(here, 1)))
    here = problem(HEXAPOD, {"optimiser": options})
    here = replace(here, objectives=(Readings(), known_criteria()["feir"]), further=(Readings(),))
    front = search(here)
    assert np.isnan(front.kktpm).all()
    assert len(front) > 3
    drawn = known_criteria()["duir"].values(here.assessed(designs(here, 500)))
    least = front.criteria["readings"].min()
    assert smooth.criteria["duir"].min() - 1e-3 <= least < np.nanmin(drawn)
    assert least < 1.1 * smooth.criteria["duir"].min()
    np.testing.assert_array_equal(search(here).decisions, front.decisions)

"""A criterion without any derivative of its own spans a front, is refined by gradients and has a KKT proximity."""

from dataclasses import replace

import numpy as np
import pytest
from tests.design.problems import BIPOD, HEXAPOD, problem
from tests.oracle import Array

from expdesign.errors import InputError
from expdesign.mechanics.differentiation import is_recorded
from expdesign.planning.criteria import criterion as module
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.criterion import Criterion, criterion_values, known_criteria
from expdesign.planning.optimality.gradient_check import gradient_check
from expdesign.planning.optimality.kktpm import kktpm
from expdesign.planning.problem import DesignProblem
from expdesign.planning.search import search
from expdesign.planning.start import starting_designs


class WorstDirection(Criterion):
    """Largest standard deviation of the attained pose in any direction, in tolerances: √λ_max of W^½·U·W^½."""

    name = "worst_direction"
    title = "worst direction"
    unit = "tolerances"

    def values(self, assessment: Assessment) -> Array:
        importance = assessment.targets.importance
        rows = np.where(importance[..., None] > 0.0, assessment.noise_root * np.sqrt(importance)[..., None], 0.0)
        known = np.isfinite(rows).all(axis=(1, 2, 3))
        rows = np.where(known[:, None, None, None], rows, 0.0)
        largest = np.linalg.svd(rows, compute_uv=False)[..., 0]
        return np.where(known, assessment.largest(largest), np.nan)


@pytest.fixture
def known(monkeypatch: pytest.MonkeyPatch) -> None:
    everything = {**known_criteria(), WorstDirection.name: WorstDirection()}
    monkeypatch.setattr(module, "known_criteria", lambda: everything)
    for name in ("problem_file", "search", "optimality.gradient_check", "optimality.objectives"):
        monkeypatch.setattr(f"expdesign.planning.{name}.known_criteria", lambda: everything)


def designs(here: DesignProblem, count: int) -> Array:
    space = here.space
    return starting_designs(here, count, np.random.default_rng(0)).reshape(count, space.measurements, space.decisions)


@pytest.mark.usefixtures("known")
@pytest.mark.parametrize("base", [BIPOD, HEXAPOD])
def test_it_spans_a_front_is_polished_and_has_a_kkt_proximity(base: dict[str, object]) -> None:
    changes = {
        "objectives": ["worst_direction", "feir"],
        "optimiser": {"population": 16, "generations": 5, "seed": 1, "polish": True},
    }
    here = problem(base, changes)
    front = search(here)
    assert len(front) > 3
    assert np.isfinite(front.kktpm).any()
    assert np.nanmedian(front.kktpm) < 1e-3
    rough = search(replace(here, optimiser=replace(here.optimiser, polish=False)))
    assert np.isfinite(rough.kktpm).all()
    values = front.criteria["worst_direction"]
    assert values.min() <= rough.criteria["worst_direction"].min() * (1.0 + 1e-9)


@pytest.mark.usefixtures("known")
def test_its_gradient_is_that_of_differences() -> None:
    here = problem(HEXAPOD)
    table = gradient_check(here, designs(here, 1)[0], ["duir"])
    assert table["relative_error"].max() < 2e-8
    direction = designs(here, 2)[1] - (decisions := designs(here, 2)[0])
    from expdesign.planning.optimality.differentiated import Differentiated  # noqa: PLC0415

    direction = direction * ~here.space.discrete
    gradient = Differentiated.of_designs(here, decisions[None]).pieces(WorstDirection())[0].gradient()[0]
    high, low = (
        WorstDirection().values(here.assess(*here.space.decode((decisions + s * 1e-6 * direction)[None])))[0]
        for s in (1.0, -1.0)
    )
    assert (high - low) / 2e-6 == pytest.approx(float((gradient * direction).sum()), rel=1e-6)


class Broken(WorstDirection):
    name = "broken"

    def values(self, assessment: Assessment) -> Array:
        return np.full(assessment.batch, np.inf)


class Misshapen(WorstDirection):
    name = "misshapen"

    def values(self, assessment: Assessment) -> Array:
        return assessment.noise_variance.sum(axis=-1)


class Kinked(WorstDirection):
    """A kink that is not stated: its derivative is not finite where the difference vanishes."""

    name = "kinked"

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
    monkeypatch.setattr(
        "expdesign.planning.search.relaxed_designs", lambda here: here.space.canonical(designs(here, 1))
    )
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

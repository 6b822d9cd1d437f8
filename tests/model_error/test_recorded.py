"""What recordings hide: the same as the plan that they follow, less where they have more to show."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from expdesign.assurance.model_error.meir import Meir
from expdesign.assurance.model_error.physics import plan_points
from expdesign.assurance.model_error.recorded import Shown
from expdesign.assurance.model_error.settings import Assumptions
from expdesign.assurance.model_error.statement import WhatIsHidden
from expdesign.chain.recordings.recordings import Recordings
from expdesign.estimation.whitening import Whitening
from expdesign.planning.problem import DesignProblem
from tests.model_error.problems import FEW, ROBOTS, assessed, impact, plans, problem


def recorded(name: str, **changes: Any) -> tuple[Recordings, np.ndarray]:
    """Recordings that follow a random plan, and their standard deviations."""
    case = problem(name)
    configurations, loads = (array[0] for array in plans(name, 1))
    points = plan_points(case.loaded, configurations, loads)
    count, axes = len(points), case.noise.axes
    recordings = Recordings(
        **{**vars(points), **changes},
        axes=axes,
        deflections=np.zeros((count, len(axes))),
        deviations=None,
        test=np.zeros(count, dtype=bool),
    )
    return recordings, np.tile(np.sqrt(np.diag(case.noise.covariance)), (count, 1))


def hidden_by(
    case: DesignProblem, recordings: Recordings, deviations: np.ndarray, assumptions: Assumptions
) -> WhatIsHidden:
    return Shown(case, recordings, Whitening(deviations), assumptions).hidden()


@pytest.mark.parametrize("name", ROBOTS)
def test_as_planned(name: str) -> None:
    recordings, deviations = recorded(name)
    found = hidden_by(problem(name), recordings, deviations, Assumptions(physics=frozenset(FEW[name])))
    meir = impact(name)
    planned = meir.hidden(assessed(meir, *plans(name, 1)))
    assert found.freedom == planned.freedom[0]
    assert found.meir == pytest.approx(float(meir.values(assessed(meir, *plans(name, 1)))[0]), rel=1e-7)
    listed = {(p.physics, p.component, p.variant): p for p in found.physics}
    # Where masses may be any, what weights may be wrong depends on the weights at hand.
    for each in WhatIsHidden.of(meir, planned, "this plan").physics:
        same = listed.get((each.physics, each.component, each.variant))
        if same is not None:
            assert same.error == pytest.approx(each.error, rel=1e-6)
            assert same.noticed == pytest.approx(each.noticed, rel=1e-5)


def test_fewer_rows_show_less() -> None:
    recordings, deviations = recorded("hexapod-h1")
    assumptions = Assumptions(physics=frozenset({"leg_coupling"}))
    few = np.arange(len(recordings)) < 4
    fewer = hidden_by(problem("hexapod-h1"), recordings.rows(few), deviations[few], assumptions)
    assert fewer.freedom == 4 * 6 - 6
    assert fewer.meir > hidden_by(problem("hexapod-h1"), recordings, deviations, assumptions).meir


def test_friction_shows_in_a_series_that_loads_and_unloads() -> None:
    """Alone, each row starts relaxed and lags behind its force; the same loads in one series lag both ways."""
    case = problem("bipod")
    generator = np.random.default_rng(1)
    configurations, loads = case.space.decode(case.space.sample(1, generator))
    configurations = np.repeat(configurations, 7, axis=0)
    loads = np.repeat(loads, 7, axis=0) * np.array([0.2, 0.5, 0.8, 1.0, 0.8, 0.5, 0.2])[:, None]
    points = plan_points(case.loaded, configurations, loads)
    made: dict[str, Any] = {
        "axes": case.noise.axes,
        "deflections": np.zeros((7, 2)),
        "deviations": None,
        "test": np.zeros(7, bool),
    }
    deviations = np.full((7, 2), 1e-6)
    assumptions = Assumptions(physics=frozenset({"friction_hysteresis"}))
    alone = hidden_by(case, Recordings(**vars(points), **made), deviations, assumptions)
    points = replace(points, series=np.ones(7, dtype=np.int64))
    series = hidden_by(case, Recordings(**vars(points), **made), deviations, assumptions)
    for variant in ("rigid", "lag"):
        noticed = []
        for found in (alone, series):
            each = next(p for p in found.physics if p.variant == variant and p.component == "all legs")
            noticed.append(abs(each.parameters["friction_N"]) * each.noticed)
        assert noticed[1] < noticed[0], variant


def test_drift_is_sought_where_there_is_time() -> None:
    times = np.linspace(0.0, 3000.0, 6)
    recordings, deviations = recorded("hexapod-h1", time=times, series=np.ones(6, dtype=np.int64))
    found = hidden_by(problem("hexapod-h1"), recordings, deviations, Assumptions(physics=frozenset({"thermal_drift"})))
    assert found.physics
    # What drifts does not move the targets, where no time has passed, but it spoils the stiffness.
    assert 0.0 < found.meir < 10.0


def test_worst_combination_is_what_it_says() -> None:
    meir: Meir = impact("hexapod-h1")
    assessment = assessed(meir, *plans("hexapod-h1", 2))
    found = WhatIsHidden.of(meir, meir.hidden(assessment), "this plan").physics
    assert [p.error for p in found] == sorted((p.error for p in found), reverse=True)
    assert found[0].error == pytest.approx(float(meir.values(assessment)[0]))
    for each in found:
        assert 0.0 <= each.shown <= 1.0
        assert each.limited_by in ("size", "detection")
        assert each.parameters[each.parameter] >= 0.0
        assert each.error == 0.0 or each.tolerable * each.error == pytest.approx(1.0)


def test_an_arm_with_several_rows_in_a_series_hides_what_settles_late() -> None:
    """Loads that change within a series show creep, of which every form has a size."""
    recordings, deviations = recorded("ur5")
    series = np.repeat(np.arange(1, len(recordings)), 2)[: len(recordings)]
    only = Assumptions(physics=frozenset({"creep"}))
    found = hidden_by(problem("ur5"), replace(recordings, series=series), deviations, only)
    assert {each.physics for each in found.physics} == {"creep"}
    assert np.isfinite(found.meir)

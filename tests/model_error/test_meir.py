"""MEIR: directions of all effects at once, invariances and limits with known answers."""

from copy import copy
from dataclasses import replace

import numpy as np
import pytest

from expdesign.arrays import FloatArray
from expdesign.assurance.model_error.meir import Hidden, Meir
from expdesign.assurance.model_error.physics import (
    Directions,
    left_out,
    offsets,
    plan_points,
    sampled_points,
)
from expdesign.assurance.model_error.settings import Assumptions
from expdesign.chain.chain import Chain
from expdesign.chain.row import RowData, row_data
from expdesign.estimation.gaussian import Gaussian
from expdesign.planning.problem import DesignProblem
from tests.model_error.problems import ROBOTS, assessed, impact, plans, problem


def test_the_parameters_of_an_effect_may_be_named_in_any_units() -> None:
    meir = impact("hexapod-h1")
    configurations, loads = plans("hexapod-h1", 3)
    base, directions = meir.whitened(assessed(meir, configurations, loads))
    given = meir.hidden_from(base, directions).squares
    generator = np.random.default_rng(0)
    turn = np.linalg.qr(generator.normal(size=(base.shape[1],) * 2))[0]
    other, errors = copy(meir), meir.errors.copy()
    factors = np.array([3.0, 0.01, 7.0, 1.0, 50.0, 2.0])
    errors[:, : base.shape[2]] *= factors
    other.errors = errors
    assert np.allclose(given, other.hidden_from(turn @ (base * factors), turn @ directions).squares, rtol=1e-7)


def test_repeated_measurements_hide_less_but_take_up_the_same() -> None:
    meir = impact("hexapod-h1")
    configurations, loads = plans("hexapod-h1", 5)
    once = meir.hidden(assessed(meir, configurations, loads))
    twice = meir.hidden(assessed(meir, np.repeat(configurations, 2, axis=1), np.repeat(loads, 2, axis=1)))
    assert (twice.squares <= once.squares * (1.0 + 1e-9)).all()
    # Of a single parameter the readings have a share s, and twice as many leave 1/(1 + s) of its variance.
    single = [i for i, entry in enumerate(meir.physics) if len(entry.free) == 1]
    assert once.shown[:, single].max() > 0.5
    assert np.allclose(twice.squares[:, single], (once.squares / (1.0 + once.shown))[:, single])


def test_designs_with_measurements_in_common_are_judged_as_each_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    meir = impact("hexapod-h1")
    configurations, loads = (np.repeat(each, 4, axis=0) for each in plans("hexapod-h1", 1))
    other = plans("hexapod-h1", 1, seed=1)
    for design in range(4):  # as where one measurement is exchanged for another
        configurations[design, design], loads[design, design] = other[0][0, design], other[1][0, design]
    alone = [meir.values(assessed(meir, configurations[[d]], loads[[d]]))[0] for d in range(4)]
    made: list[int] = []
    at = Directions.at

    def counted(self: Directions, rows: RowData) -> FloatArray:
        made.append(len(rows.values))
        return at(self, rows)

    monkeypatch.setattr(Directions, "at", counted)
    np.testing.assert_allclose(meir.values(assessed(meir, configurations, loads)), alone, rtol=1e-9)
    assert made == [6 + 4]  # distinct measurements of 24


def test_what_is_hidden_is_by_how_much_the_error_rises_where_the_model_has_the_physics() -> None:
    """T·P·Tᵀ of the one model with each effect as a term, less that without it, load errors as terms of their own."""
    case = problem("hexapod-120kg")
    assert case.estimator == "generalised"
    meir = Meir(case, Assumptions(physics=frozenset({"platform_compliance", "leg_coupling", "leg_backlash"})))
    assessment = assessed(meir, *plans("hexapod-120kg", 2))
    found, ends, count = meir.hidden(assessment), offsets(meir.physics), len(meir.compliance)
    assert assessment.states is not None
    load = assessment.measurements.compliance @ assessment.measurements.load_errors
    assert all(assessment.shared)
    for design in range(2):
        base = assessment.white(assessment.measurements.observation)[design] * meir.compliance
        errors = assessment.white(load)[design]
        at_base = np.hstack([meir.errors[:, :count], np.zeros((len(meir.errors), errors.shape[1]))])
        known = np.append(np.full(count, np.inf), np.ones(errors.shape[1]))
        model = Gaussian(np.hstack([base, errors]), np.zeros(len(base)), known, at_targets=at_base)
        rows = plan_points(case.loaded, *(each[design] for each in assessment.states))
        moved = meir.directions.at(row_data(rows, case.loaded.robot))
        physics = assessment.white(np.broadcast_to(moved, (2, *moved.shape)))[design] * meir.deviations
        at_targets = meir.errors[:, count:] * meir.deviations
        for index in range(0, len(meir.physics), 7):
            part = slice(ends[index], ends[index + 1])
            wider = Gaussian(
                np.hstack([model.columns, physics[:, part]]),
                model.readings,
                np.append(known, np.ones(ends[index + 1] - ends[index])),
                at_targets=np.hstack([at_base, at_targets[:, part]]),
            )
            squares = [((each.at_targets @ each.root) ** 2).sum(axis=1) for each in (wider, model)]
            rise, joined = squares[0] - squares[1], model.joined(physics[:, part], at_targets[:, part], 1.0)[2]
            np.testing.assert_allclose(found.axes[design, index].ravel(), rise, rtol=1e-6, atol=1e-9)
            np.testing.assert_allclose((joined**2).sum(axis=1), rise, rtol=1e-6, atol=1e-9)


def test_a_plan_that_does_not_identify_the_stiffness_has_no_meir() -> None:
    configurations, loads = plans("hexapod-h1", 2)
    loads[1, :, 0] = 0.0  # no mass, no load
    values = impact("hexapod-h1").values(assessed(impact("hexapod-h1"), configurations, loads))
    assert np.isfinite(values[0])
    assert np.isnan(values[1])


def test_an_actuator_that_never_carries_anything_is_no_obstacle() -> None:
    # Joint 1 of the arm is vertical: no weight loads it, in the plan or at the targets.
    values = impact("ur5").values(assessed(impact("ur5"), *plans("ur5", 3)))
    assert np.isfinite(values).all()
    assert (values > 0.0).all()


def test_largest_target_instead_of_their_mean() -> None:
    name = "hexapod-h1"
    largest = replace(problem(name), targets=replace(problem(name).targets, aggregate="max"))
    assumptions = Assumptions(physics=frozenset({"leg_coupling", "platform_compliance"}))
    configurations, loads = plans(name, 3)

    def most_of(case: DesignProblem) -> Hidden:
        return Meir(case, assumptions).hidden(case.assess(configurations, loads))

    mean = most_of(problem(name)).squares
    most = most_of(largest).squares
    assert (most >= mean * (1.0 - 1e-9)).all()
    assert (most <= 2.0 * mean * (1.0 + 1e-9)).all()  # two targets of equal weight


def test_a_measurement_more_may_hide_more() -> None:
    """There is no lower bound by convex relaxation: what the base model takes up is no monotone function of the plan.

    The error that DUIR measures never grows when a measurement is added; the bias of a wrong model may.
    """
    meir = Meir(problem("bipod"), Assumptions(physics=frozenset({"leg_coupling"})))
    configurations, loads = plans("bipod", 40, measurements=4)
    squares = [meir.hidden(assessed(meir, configurations[:, :m], loads[:, :m])).squares for m in (3, 4)]
    assert (squares[1] > 1.05 * squares[0]).any()


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("instrument", [True, False])
def test_every_effect_as_alone_on_the_chain(name: str, instrument: bool) -> None:
    few = frozenset({"joint_position_error", "friction_hysteresis", "encoder_periodic_error", "instrument_scale"})
    loaded = problem(name).loaded
    physics = left_out(problem(name), sampled_points(problem(name)), Assumptions(physics=few))
    configurations, loads = (array[0] for array in plans(name, 1))
    n_p = len(loaded.robot.stiffness)
    directions = Directions(Chain(loaded.robot), np.ones(n_p), physics)
    rows = row_data(plan_points(loaded, configurations, loads), loaded.robot)
    found = directions.at(rows, platform=not instrument)
    for entry, start in zip(physics, offsets(physics)[:-1], strict=True):
        chain = Chain(loaded.robot, (entry.effect,), instrument=instrument)
        values = np.concatenate([np.ones(n_p), entry.start])
        if entry.step:
            ends = [chain.predict(rows, np.concatenate([np.ones(n_p), v])) for v in (entry.at(entry.step), entry.start)]
            assert np.allclose(found[..., start], (ends[0] - ends[1]) / entry.step, rtol=1e-7, atol=1e-15)
            continue
        alone = chain.predict_with_sensitivities(rows, values)[1][:, :, n_p:][:, :, entry.free]
        mine = found[..., start : start + len(entry.free)]
        size = np.abs(alone).max(axis=(0, 1), keepdims=True)
        # What moves nothing is zero to rounding.
        assert (np.abs(mine - alone) <= 1e-7 * size + 1e-16).all(), entry.key

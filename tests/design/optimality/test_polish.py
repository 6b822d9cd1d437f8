"""Refinement of a front: optimality conditions hold afterwards, limits are kept, and known optima are found."""

from typing import Any

import numpy as np
import pytest

from expdesign.planning.deflection_noise import series_by_pose
from expdesign.planning.front import hypervolume, non_dominated
from expdesign.planning.optimality.kktpm import kktpm
from expdesign.planning.optimality.objectives import Objectives, Pace, descended
from expdesign.planning.optimality.sqp import Limits
from expdesign.planning.problem import DesignProblem
from expdesign.planning.sampling import starting_designs
from expdesign.planning.scalarisation import Aims
from tests.design.problems import BIPOD, HEXAPOD, problem
from tests.design.refined import refined
from tests.oracle import Array

CASES: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "bipod": (BIPOD, {}),
    "hexapod": (HEXAPOD, {"optimiser.population": 12}),
    "short-legs": (HEXAPOD, {"optimiser.population": 12, "robot.limits.leg_length": [0.275, 0.342]}),
    "largest-target": (HEXAPOD, {"optimiser.population": 12, "aggregate": "max"}),
    "maximised": (BIPOD, {"objectives": ["o1", "feir"]}),
    "three-objectives": (BIPOD, {"objectives": ["duir", "feir", "o_tp"], "targets.0.tolerance": {"dy_m": 1e-6}}),
}


def start(here: DesignProblem, count: int = 12) -> Array:
    return starting_designs(here, count, np.random.default_rng(7))


def objectives(here: DesignProblem, decisions: Array) -> Array:
    assessment = here.assess(*here.space.decode(decisions))
    signs = [-1.0 if criterion.maximise else 1.0 for criterion in here.objectives]
    columns = [sign * criterion.values(assessment) for sign, criterion in zip(signs, here.objectives, strict=True)]
    return np.stack(columns, axis=1)


@pytest.mark.parametrize("name", CASES)
def test_a_polished_front_is_optimal_and_within_every_limit(name: str) -> None:
    here = problem(*CASES[name])
    first = start(here)
    found = refined(here, first)
    space = here.space
    assert ((found >= space.lower) & (found <= space.upper)).all()
    assert here.loaded.robot.usable(space.decode(found)[0]).all()
    assert (found[..., space.discrete] == np.rint(found[..., space.discrete])).all()
    before, after = objectives(here, first), objectives(here, found)
    front = found[non_dominated(after)]
    assert len(front) > 5
    measure = kktpm(here, front)
    assert measure.max() < 1e-4
    assert np.median(kktpm(here, first)) > 1e-2
    point = np.maximum(before, 0.0).max(axis=0) + 1.0
    assert hypervolume(after, point) > hypervolume(before, point)
    assert after.min(axis=0) == pytest.approx(np.minimum(after.min(axis=0), before.min(axis=0)))


def test_measurements_that_share_their_reference_keep_sharing_it() -> None:
    here = problem(BIPOD, {"experiment.deflection_noise.shared_reference": True, "experiment.measurements": 3})
    first = start(here)
    first[:, 1, :2] = first[:, 0, :2]
    first = here.space.canonical(first)
    series = series_by_pose(here.space.decode(first)[0])
    first, series = (each[series.max(axis=1) == 2] for each in (first, series))  # some have one pose from the start
    assert len(first) > 6
    functions = Objectives(here)
    weights = np.tile([1.0, 0.0], (len(first), 1))
    pace = Pace(steps=60, tolerance=1e-9, inner=1e-9)
    found = descended(functions, first, Aims(np.zeros_like(weights), weights), pace)
    np.testing.assert_array_equal(series_by_pose(here.space.decode(found)[0]), series)
    assert (functions.values(here.assessed(found))[:, 0] < functions.values(here.assessed(first))[:, 0]).all()
    measure = kktpm(here, found)
    # Minima of DUIR alone: the measure of the front has FEIR as well, which can only make it smaller.
    assert measure.max() < 1e-4


def test_kkt_proximity_is_one_at_most_and_zero_only_where_nothing_can_be_gained() -> None:
    here = problem(HEXAPOD)
    measure = kktpm(here, start(here, 40))
    assert ((measure >= 0.0) & (measure <= 1.0 + 1e-12)).all()
    assert (measure > 1e-3).mean() > 0.9


def test_kkt_proximity_knows_bounds() -> None:
    # More load in the same direction lowers both criteria, so that of all loads the largest is optimal.
    one = {
        "experiment.measurements": 1,
        "experiment.poses": {"bounds": {"x_m": 0.1, "y_m": 0.6}},
        "experiment.load": {"kind": "wrench", "fx_N": 0.0, "fy_N": [-1000.0, -500.0]},
    }
    here = problem(BIPOD, one)
    decisions = np.array([[[-1000.0]], [[-700.0]]])
    measure = kktpm(here, decisions)
    assert measure[0] < 1e-20
    assert measure[1] > 0.05


def test_limits_have_their_gradients_and_agree_with_the_robot() -> None:
    here = problem(HEXAPOD)
    decisions = start(here)[0]
    limits = Limits(here)
    values, gradient = limits.rows(decisions)
    excess = here.loaded.robot.limit_excess(here.space.decode(decisions)[0])
    np.testing.assert_allclose(values[:, :-1].max(axis=1) * 0.12, excess, atol=1e-8)
    for decision in np.flatnonzero(~here.space.discrete):
        step = 1e-6 * (here.space.upper - here.space.lower)[decision]
        moved = np.stack([decisions, decisions])
        moved[:, :, decision] += np.array([[-step], [step]])
        low, high = limits.rows(moved)[0]
        np.testing.assert_allclose(gradient[:, :-1, decision], ((high - low) / (2 * step))[:, :-1], atol=1e-6)

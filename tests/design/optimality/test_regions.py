"""Branch and bound over boxes of measurements: against all plans that there are, and against many in every box."""

from dataclasses import replace
from itertools import combinations_with_replacement
from typing import Any

import numpy as np
import pytest
from tests.design.problems import BIPOD, HEXAPOD, problem
from tests.design.refined import refined
from tests.oracle import Array

from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.optimality import region_tree, regions
from expdesign.planning.optimality.bounds import best_linear_total, criterion_bounds
from expdesign.planning.optimality.measurement_maps import MeasurementMaps
from expdesign.planning.optimality.pool import usable
from expdesign.planning.optimality.region_bound import Node, bounded
from expdesign.planning.optimality.region_tree import RegionTree
from expdesign.planning.optimality.regions import Axis, Box, Regions
from expdesign.planning.optimality.weights import Relaxation
from expdesign.planning.options import HALVING
from expdesign.planning.problem import DesignProblem
from expdesign.planning.sampling import starting_designs

POSES = [[-0.25, 0.45], [0.05, 0.5], [0.2, 0.7], [0.3, 0.9]]
TARGETS = [
    {"pose": [0.1, 0.6], "wrench": [0.0, -1000.0], "tolerance": {"dx_m": 1.0e-6}},
    {"pose": [-0.2, 0.4], "wrench": [300.0, -1000.0], "tolerance": {"dy_m": 2.0e-6}},
]
LIST = {
    "experiment.measurements": 3,
    "experiment.poses": {"candidates": POSES},
    "experiment.load": {"kind": "wrench", "fx_N": {"choices": [-500, 100, 500]}, "fy_N": {"choices": [-1000, -500]}},
    "experiment.load_error": [],
    "targets": TARGETS,
}
ERRORS = [{"source": "wrench", "std": [5.0, 8.0]}]
SHARED = {"experiment.deflection_noise.shared_reference": True}
CASES: dict[str, dict[str, Any]] = {
    "rows": {},
    "rows-max": {"aggregate": "max"},
    "rows-errors": {"experiment.load_error": ERRORS},
    "rows-errors-max": {"experiment.load_error": ERRORS, "aggregate": "max"},
    "rows-own-errors": {"experiment.load_error": [{**ERRORS[0], "shared": False}]},
}
FREE = {"experiment.load": {"kind": "wrench", "fx_N": [-500.0, 500.0], "fy_N": [-1000.0, 400.0]}}
TILTED = {
    "experiment.poses": {"bounds": {"x_m": [-0.03, 0.03], "z_m": [-0.02, 0.02], "rx_rad": [-0.15, 0.15]}},
    "experiment.measurements": 2,
}
CONTINUOUS: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "rows": (BIPOD, FREE),
    "max": (BIPOD, {**FREE, "targets": LIST["targets"], "aggregate": "max"}),
    "listed": (BIPOD, {**LIST, **FREE}),
    "hexapod": (HEXAPOD, TILTED),
    "hexapod-legs": (HEXAPOD, {**TILTED, "robot.limits": {"leg_length": [0.285, 0.345]}}),
}


def values(here: DesignProblem, designs: Array, name: str) -> Array:
    found = known_criteria()[name].values(here.assessed(designs))
    return np.where(np.isfinite(found), found, np.inf)


def all_plans(here: DesignProblem) -> Array:
    space = here.space
    axes = np.meshgrid(*(np.arange(high + 1.0) for high in space.upper), indexing="ij")
    rows = np.array(axes).reshape(space.decisions, -1).T
    members = np.array(list(combinations_with_replacement(range(len(rows)), space.measurements)))
    return space.canonical(rows[members])


def tree_of(here: DesignProblem, factor: float) -> RegionTree:
    information = MeasurementMaps(here, factor)
    return RegionTree(Regions(information), information.relaxation(), lambda _: np.inf)


def halved(found: Regions, box: Box, generator: np.random.Generator) -> Box:
    """One half of a box, several times."""
    for _ in range(int(generator.integers(0, 8))):
        axis = int(generator.integers(len(box)))
        if box[axis][0] < box[axis][1]:
            half = found.axes[axis].halves(box[axis])[int(generator.integers(2))]
            box = (*box[:axis], half, *box[axis + 1 :])
    return box


def evenly(found: Regions, boxes: list[Box], relaxation: Relaxation) -> Node:
    """Plans with their measurements in these boxes, at all corners alike."""
    whole = Node.whole(found, len(boxes), len(relaxation.targets))
    counts = [len(found.region(box).corners) for box in boxes]
    return replace(whole, boxes=tuple(boxes), parts=tuple(np.full(count, 1.0 / count) for count in counts))


def anywhere(found: Regions, box: Box, count: int, generator: np.random.Generator) -> Array:
    """Measurements (count, g) in a box, half of the places at its ends."""
    places = np.empty((count, len(box)))
    for column, (axis, (low, high)) in enumerate(zip(found.axes, box, strict=True)):
        part = np.clip(generator.uniform(-0.5, 1.5, count), 0.0, 1.0)
        places[:, column] = low + part * (high - low)
        if axis.order is not None:
            places[:, column] = np.rint(places[:, column])
    return found.decisions(places)


@pytest.mark.parametrize("factor", [0.0, 1.0])
@pytest.mark.parametrize("name", CONTINUOUS)
def test_no_plan_with_its_measurements_in_the_boxes_is_below_their_bound(name: str, factor: float) -> None:
    """Whatever the boxes; and the bound is not far below, so that the test could fail."""
    base, changes = CONTINUOUS[name]
    here = problem(base, changes)
    information = MeasurementMaps(here, factor)
    found, relaxation, generator = Regions(information), information.relaxation(), np.random.default_rng(5)
    m, criterion = relaxation.count, "total" if factor else "duir"
    nearest, reached = np.inf, 0
    for _ in range(24):
        boxes = [halved(found, found.whole, generator) for _ in range(m)]
        (node,), _ = bounded(found, relaxation, [evenly(found, boxes, relaxation)], np.inf, 40)
        plans = np.stack([anywhere(found, box, 400, generator) for box in boxes], axis=1)
        inside = np.array([len(usable(here, plan)) == m for plan in plans])
        if inside.any():
            assert all(found.region(box).reachable for box in boxes)
            least = values(here, plans[inside], criterion).min() ** 2
            reached += 1
            assert least >= node.bound * (1.0 - 1e-9)
            nearest = min(nearest, least / node.bound)
    assert reached > 3
    assert nearest < 2.0


@pytest.mark.parametrize("name", CASES)
def test_the_bound_over_all_plans_of_a_list(name: str) -> None:
    """Of DUIR, and of the total of the best linear estimator, which the bound is of."""
    here = problem(BIPOD, {**LIST, **CASES[name]})
    plans = all_plans(here)
    found = {name: values(here, plans, name) for name in ("duir", "total")}
    likely = plans[np.argsort(found["total"])[:150]]
    best = {0.0: found["duir"].min(), 1.0: min(best_linear_total(here, plan) for plan in likely)}
    for factor, least in best.items():
        tree = tree_of(here, factor)
        bound = np.sqrt(tree.run(least**2, 1.9 * HALVING.gap, 20.0))
        assert bound <= least * (1.0 + 1e-9)
        assert least <= bound * (1.0 + 1.1 * HALVING.gap)
        assert tree.nodes < 20000


def test_a_plan_that_is_better_than_the_known_one_is_found() -> None:
    here = problem(BIPOD, {**LIST, **CASES["rows-errors"]})
    plans = all_plans(here)
    found = values(here, plans, "duir")
    best, tried = float(found.min()), []
    information = MeasurementMaps(here, 0.0)

    def attempt(plan: Array) -> float:
        tried.append(float(values(here, plan[None], "duir")[0]))
        return float(min(tried) ** 2)

    tree = RegionTree(Regions(information), information.relaxation(), attempt)
    bound = np.sqrt(tree.run((1.2 * best) ** 2, 1.9 * HALVING.gap, 20.0))
    assert min(tried) == pytest.approx(best, rel=1e-9)
    assert best <= bound * (1.0 + 1.1 * HALVING.gap)


@pytest.mark.parametrize(("name", "within"), [("rows", 2e-3), ("hexapod", 2e-2)])
def test_over_a_continuum_the_bound_meets_what_searches_find(name: str, within: float) -> None:
    base, changes = CONTINUOUS[name]
    here = problem(base, {**changes, "experiment.load_error": []})
    starts = starting_designs(here, 60, np.random.default_rng(3))
    known = refined(here, starts)
    bounds = criterion_bounds(here, 0.0, known, 10.0)
    least = known_criteria()["duir"].values(here.assess(*here.space.decode(known))).min()
    assert bounds.lower.value is not None
    assert bounds.best <= least * (1.0 + 1e-9)
    assert bounds.lower.value <= bounds.best
    assert bounds.open is not None
    assert bounds.open < within
    assert not bounds.exact
    assert "second differences" in bounds.lower.certified_on
    # Whatever the machine.
    again = criterion_bounds(here, 0.0, known, 10.0)
    assert again == bounds
    assert np.array_equal(np.asarray(again.plan), np.asarray(bounds.plan))


def test_boxes_are_forgotten_without_effect(monkeypatch: pytest.MonkeyPatch) -> None:
    base, changes = CONTINUOUS["max"]
    here = problem(base, changes)
    monkeypatch.setattr(
        region_tree, "HALVING", replace(HALVING, maps=np.inf)
    )  # what is looked at twice takes time twice
    kept = tree_of(here, 0.0)
    bound = kept.run(0.3, 1e-2, 0.3)
    monkeypatch.setattr(regions, "HALVING", replace(HALVING, stored=1000))
    forgotten = tree_of(here, 0.0)
    assert forgotten.run(0.3, 1e-2, 0.3) == bound
    assert forgotten._regions.work > kept._regions.work


def test_series_are_bounded_by_the_relaxation_alone() -> None:
    here = problem(BIPOD, {**LIST, **SHARED})
    known = starting_designs(here, 50, np.random.default_rng(3))
    bounds = criterion_bounds(here, 0.0, known, 5.0)
    assert bounds.nodes == 0
    assert bounds.lower == criterion_bounds(here, 0.0, known, 0.0).lower
    assert "share references" in bounds.words


def test_halves_of_a_node_hold_all_of_its_plans() -> None:
    """Two equal boxes are cut together: both below, one on either side, or both above."""
    here = problem(BIPOD, FREE)
    tree = tree_of(here, 0.0)
    found = Regions(MeasurementMaps(here, 0.0))
    node = Node.whole(found, 2, 1)
    halves = [tuple(box[2] for box in each.boxes) for each in tree._halves(node, 1, 2)]
    assert halves == [((0.5, 1.0), (0.5, 1.0)), ((0.0, 0.5), (0.5, 1.0)), ((0.0, 0.5), (0.0, 0.5))]
    unequal = replace(node, boxes=(found.whole, (*found.whole[:3], (0.0, 0.5))))
    assert len(list(tree._halves(unequal, 0, 2))) == 2


def test_places_along_axes() -> None:
    choices = Axis(0, np.array([2, 0, 1]), np.array([1.0, 2.0, 4.0]), False, False, (0.0, 2.0))
    assert choices.corners((0.0, 2.0)) == [0.0, 2.0]
    assert choices.halves((0.0, 2.0)) == ((0.0, 1.0), (2.0, 2.0))
    assert choices.middle((0.0, 2.0)) == (1.0, pytest.approx(1.0 / 3.0))
    assert choices.decisions(np.array([0.0, 2.0])).tolist() == [2.0, 1.0]
    assert not choices.bends((0.0, 1.0))
    rows = Axis(0, np.arange(5), None, False, False, (0.0, 4.0))
    assert rows.corners((1.0, 3.0)) == [1.0, 2.0, 3.0]
    assert not rows.bends((0.0, 4.0))
    angle = Axis(0, None, None, False, True, (-2.0, 2.0))
    assert not angle.resolved((0.0, 1.0))
    assert angle.resolved((0.0, HALVING.widest / 4.0))
    assert angle.decisions(np.array([0.25])).tolist() == [-1.0]


def test_a_joint_that_turns_far_is_cut_before_anything_is_bounded() -> None:
    here = problem(HEXAPOD, {**TILTED, "experiment.poses.bounds.rx_rad": [-0.7, 0.7], "robot.limits": ...})
    found = Regions(MeasurementMaps(here, 0.0))
    assert not found.region(found.whole).resolved
    tree = tree_of(here, 0.0)
    assert tree.run(1.0, 1e-3, 0.0) == 0.0


def test_where_a_box_has_too_many_corners_for_the_time_nothing_is_halved() -> None:
    poses = np.random.default_rng(1).uniform([-0.3, 0.4], [0.3, 0.9], (4000, 2))
    here = problem(BIPOD, {**LIST, **FREE, "experiment.poses": {"candidates": poses.tolist()}})
    assert not tree_of(here, 0.0).affordable(0.1)
    assert tree_of(here, 0.0).affordable(1.0)
    known = starting_designs(here, 50, np.random.default_rng(3))
    assert "halved" not in criterion_bounds(here, 0.0, known, 0.1).lower.certified_on


def test_without_time_nothing_is_halved() -> None:
    here = problem(BIPOD, {"experiment.measurements": 1})
    known = starting_designs(here, 50, np.random.default_rng(3))
    bounds = criterion_bounds(here, 0.0, known, 0.0)
    assert bounds.nodes == 0
    assert bounds.halved is None
    assert criterion_bounds(here, 0.0, known, 2.0).nodes > 0

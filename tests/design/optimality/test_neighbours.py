"""Exchanges of measurements, the front of all designs, and following a front: known answers."""

from itertools import pairwise, product

import numpy as np
import pytest
from tests.design.problems import BIPOD, HEXAPOD, problem
from tests.oracle import Array

from expdesign.criteria.criterion import known_criteria
from expdesign.design.front import GAPS, drawn_through, gap_shares, hypervolume, non_dominated
from expdesign.design.optimality.additive import Additive, additive
from expdesign.design.optimality.continuation import predictions
from expdesign.design.optimality.enumeration import every_design
from expdesign.design.optimality.neighbours import Neighbours
from expdesign.design.optimality.objectives import Objectives
from expdesign.design.optimality.polish import Polishing
from expdesign.design.optimality.repetitions import repeated_designs
from expdesign.design.optimality.seeds import relaxed_designs
from expdesign.design.optimality.sum_exchange import exchanged_by_sums
from expdesign.design.optimality.variants import variants
from expdesign.design.problem import DesignProblem
from expdesign.design.search import search
from expdesign.design.start import starting_designs

GRID = {
    "experiment.poses": {"grid": {"x_m": [-0.3, 0.3, 3], "y_m": [0.35, 0.95, 3]}},
    "experiment.load": {"kind": "wrench", "fx_N": {"choices": [-500, 400]}, "fy_N": {"choices": [-1000, 0]}},
    "optimiser.polish": True,
}


def designs(here: DesignProblem, count: int) -> Array:
    decisions = starting_designs(here, count, np.random.default_rng(5))
    return decisions.reshape(count, here.space.measurements, here.space.decisions)


def test_sums_over_measurements_are_the_criteria() -> None:
    for base, changes in ((BIPOD, {}), (HEXAPOD, {}), (HEXAPOD, {"aggregate": "max"})):
        here = problem(base, changes)
        decisions = designs(here, 6)
        sums = Additive(here, 1.0)
        noise, force = sums.variances(
            sums.parts(decisions.reshape(-1, decisions.shape[-1])).reshape(6, decisions.shape[1], -1).sum(1)
        )
        assessment = here.assess(*here.space.decode(decisions))
        for name, squares in (("duir", noise), ("feir", force), ("total", noise + force)):
            expected = known_criteria()[name].values(assessment)
            np.testing.assert_allclose(np.sqrt(squares.max(axis=-1)), expected, rtol=1e-6)


@pytest.mark.parametrize("own", [False, True])
def test_sums_over_series_are_the_criteria(own: bool) -> None:
    """With shared references, also for measurements that join a series and for repeated ones."""
    changes = {"experiment.deflection_noise.shared_reference": True, "experiment.measurements": 4}
    errors = [{"source": "wrench", "std": [3.0, 3.0, 3.0, 0.3, 0.3, 0.3], "shared": not own}]
    here = problem(HEXAPOD, {**changes, "experiment.load_error": errors})
    pose, decisions = here.space.of_pose, designs(here, 6)
    decisions[:3, 1] = np.where(pose, decisions[:3, 0], decisions[:3, 1])
    decisions[:2, 2] = np.where(pose, decisions[:2, 0], decisions[:2, 2])
    decisions[5] = decisions[5, 0]
    sums = additive(here, 1.0)
    parts = sums.parts(decisions.reshape(-1, decisions.shape[-1])).reshape(6, 4, -1)
    added = sums.joined(parts[:, 1:], decisions[:, 1:, pose], parts[:, :1], decisions[:, :1, pose])[:, 0]
    assessment = here.assess(*here.space.decode(decisions))
    for found in (sums.sums(parts, decisions[..., pose]), added):
        noise, force = sums.variances(found)
        for name, squares in (("duir", noise), ("feir", force)):
            expected = known_criteria()[name].values(assessment)
            regular = np.isfinite(expected) & (np.arange(6) < 5)
            assert regular.sum() == 5
            np.testing.assert_allclose(np.sqrt(squares.max(axis=-1))[regular], expected[regular], rtol=1e-6)
    np.testing.assert_allclose(sums.repeated(parts[5, :1], 4)[0], sums.sums(parts, decisions[..., pose])[5], rtol=1e-9)


def test_a_series_moves_as_a_whole() -> None:
    here = problem(HEXAPOD, {"experiment.deflection_noise.shared_reference": True, "experiment.measurements": 4})
    pose, decisions = here.space.of_pose, designs(here, 2)
    decisions[0, 3] = np.where(pose, decisions[0, 1], decisions[0, 3])
    neighbours = Neighbours(here, Objectives(here), np.random.default_rng(1))
    moved = neighbours.with_series(decisions, np.array([1, 0]), decisions[::-1, 2])
    np.testing.assert_array_equal(moved[0, 1:4:2][:, pose], np.tile(decisions[1, 2, pose], (2, 1)))
    np.testing.assert_array_equal(moved[0, ::2], decisions[0, ::2])
    np.testing.assert_array_equal(moved[1, 0, pose], decisions[0, 2, pose])
    np.testing.assert_array_equal(moved[..., ~pose], decisions[..., ~pose])


@pytest.mark.parametrize("shared", [False, True])
def test_exchanges_over_a_grid_reach_the_least_feir_of_all_designs(shared: bool) -> None:
    here = problem(
        BIPOD, {**GRID, "experiment.measurements": 3, "experiment.deflection_noise.shared_reference": shared}
    )
    every = every_design(here)
    assert every is not None
    objectives = Objectives(here)
    least = objectives.values(every).min(axis=0)
    neighbours = Neighbours(here, objectives, np.random.default_rng(1))
    parents = repeated_designs(here)[:2]
    neighbours.learn(parents)
    weights = np.eye(2)
    found = objectives.values(neighbours.anywhere(parents, np.zeros((2, 2)), weights))
    np.testing.assert_allclose(np.nanmin(found, axis=0), least, rtol=1e-9)


def test_exchanges_of_children_leave_none_that_a_variant_of_one_measurement_improves() -> None:
    here = problem(BIPOD, GRID)
    objectives = Objectives(here)
    neighbours = Neighbours(here, objectives, np.random.default_rng(1))
    parents = designs(here, 12)
    neighbours.learn(parents)
    weights = np.repeat(np.eye(2), 6, axis=0)
    found = neighbours.improved(parents, np.zeros((12, 2)), weights)
    reached = (objectives.values(found) * weights).sum(axis=1)
    assert (reached <= (objectives.values(parents) * weights).sum(axis=1) * (1.0 + 1e-12)).all()
    options = variants(here, found)
    for place in range(here.space.measurements):
        for variant in range(options.shape[2]):
            changed = found.copy()
            changed[:, place] = options[:, place, variant]
            values = (objectives.values(changed) * weights).sum(axis=1)
            usable = np.isfinite(values)
            assert usable.any()
            assert (values[usable] >= reached[usable] * (1.0 - 1e-7)).all()


def test_no_step_away_from_a_series_and_no_load_at_another_pose_improves_what_was_exchanged() -> None:
    here = problem(HEXAPOD, {"experiment.deflection_noise.shared_reference": True, "experiment.measurements": 4})
    space, objectives, names = here.space, Objectives(here), ("duir", "feir")
    starts = designs(here, 6)
    starts[..., space.of_pose] = starts[:, :1, space.of_pose]
    weights = np.repeat(np.eye(2), 3, axis=0)
    common = designs(here, 5).reshape(-1, space.decisions)
    found = exchanged_by_sums(here, starts, np.zeros((6, 2)), weights, names, common, False, True)
    reached = (objectives.values(space.canonical(found)) * weights).sum(axis=1)
    before = (objectives.values(space.canonical(starts)) * weights).sum(axis=1)
    assert (reached < 0.9 * before).all()
    looked = 0
    for place in range(4):
        own, others = found[:, place, None], np.delete(found, place, axis=1)
        elsewhere = variants(here, others, ~space.of_pose).reshape(6, -1, space.decisions)
        options = np.concatenate([space.inward(own, 1), np.where(space.of_pose, others, own), elsewhere], axis=1)
        for option in range(options.shape[1]):
            changed = found.copy()
            changed[:, place] = options[:, option]
            values = (objectives.values(space.canonical(changed)) * weights).sum(axis=1)
            usable = np.isfinite(values)
            looked += int(usable.sum())
            assert (values[usable] >= reached[usable] * (1.0 - 1e-6)).all()
    assert looked > 500


def test_children_of_continuous_spaces_are_left_to_descents() -> None:
    here = problem(HEXAPOD)
    neighbours = Neighbours(here, Objectives(here), np.random.default_rng(1))
    parents = designs(here, 4)
    neighbours.learn(parents)
    np.testing.assert_array_equal(neighbours.improved(parents, np.zeros((4, 2)), np.ones((4, 2))), parents)


def test_a_space_of_few_designs_is_looked_at_as_a_whole() -> None:
    here = problem(BIPOD, GRID)
    found = every_design(here)
    assert found is not None
    rows = np.array(list(product(range(9 // 3), range(9 // 3), range(2), range(2))), dtype=float)
    pairs = np.array([[rows[i], rows[j]] for i in range(len(rows)) for j in range(i, len(rows))])
    assessment = here.assess(*here.space.decode(pairs))
    usable = assessment.differentiable
    values = np.stack([known_criteria()[name].values(assessment) for name in ("duir", "feir")], axis=1)[usable]
    expected = np.unique(values[non_dominated(values)].round(9), axis=0)
    front = search(here)
    np.testing.assert_allclose(
        np.unique(np.stack([front.criteria["duir"], front.criteria["feir"]], axis=1).round(9), axis=0), expected
    )
    assert front.missing == 0.0


def test_roundings_of_the_relaxation_are_within_the_limits_of_the_legs() -> None:
    here = problem(HEXAPOD, {"robot.limits.leg_length": [0.275, 0.342]})
    poses = here.space.decode(relaxed_designs(here))[0]
    assert here.loaded.robot.usable(poses).all()


def test_a_straight_front_is_filled_evenly() -> None:
    here = problem(BIPOD)
    first = designs(here, 1)[0]
    second = np.clip(first + 0.02 * (here.space.upper - here.space.lower), here.space.lower, here.space.upper)
    values = np.array([[0.0, 1.0], [1.0, 0.0]])
    found = predictions(here.space, np.stack([first, second]), values, 0.01, 1000)
    front = np.concatenate([values, found.aims])
    assert found.smooth.all()
    assert gap_shares(front[np.argsort(front[:, 0])]).sum() <= 0.0101
    assert drawn_through(front, np.ones(2)) == 0.5
    assert hypervolume(front, np.ones(2)) < 0.5


def test_rounds_of_exchanges_lose_nothing_and_the_front_is_drawn_without_gaps() -> None:
    here = problem(HEXAPOD, {"optimiser.population": 40, "optimiser.generations": 200, "optimiser.polish": True})
    polishing = Polishing(here)
    polishing.take(designs(here, 12))
    point = polishing.front.max(axis=0) + 1.0
    volumes = [hypervolume(polishing.front, point)]
    for _ in polishing.rounds():
        volumes.append(hypervolume(polishing.front, point))
    # The last step leaves out what is not finished.
    assert all(later >= earlier * (1.0 - 1e-9) for earlier, later in pairwise(volumes[:-1]))
    assert volumes[-1] >= volumes[-2] * (1.0 - 1e-3)
    front = polishing.front[non_dominated(polishing.front)]
    gaps = np.sort(gap_shares(front[np.argsort(front[:, 0])]))[::-1]
    assert gaps.sum() < 10.0 * GAPS
    assert gaps[1:].sum() < 5.0 * GAPS
    assert 0.0 <= polishing.missing() < 0.1

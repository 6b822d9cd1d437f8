"""Series of measurements that share a reference while poses move: held, and apart where they meet."""

from dataclasses import replace

import numpy as np
import pytest
from tests.design.problems import BIPOD, HEXAPOD, problem

from expdesign.criteria.criterion import known_criteria
from expdesign.design.optimality.descents import Pace, pursued
from expdesign.design.optimality.objectives import Objectives
from expdesign.design.optimality.pose_groups import PoseGroups
from expdesign.design.optimality.whole_plans import criterion_bounds
from expdesign.design.search import search
from expdesign.design.start import starting_designs
from expdesign.instrument.deflection_noise import series_by_pose

SHARED = {"experiment.deflection_noise.shared_reference": True, "experiment.measurements": 4}
"""Reference shared at a pose, four measurements."""


@pytest.mark.parametrize("base", [BIPOD, HEXAPOD])
def test_series_that_meet_are_a_step_apart_with_a_reference_each(base: dict[str, object]) -> None:
    here = problem(base, SHARED)
    pose, steps = here.space.of_pose, here.space.grid.steps
    design = starting_designs(here, 1, np.random.default_rng(3)).reshape(1, 4, -1)
    design[0, 1, pose] = design[0, 0, pose]
    groups = PoseGroups.of(here, design)
    assert groups is not None
    np.testing.assert_array_equal(groups.numbers[0], [1, 1, 2, 3])
    alone = groups.apart(design)
    np.testing.assert_array_equal(alone, design)
    met = design.copy()
    met[0, 1:, pose] = met[0, 0, pose][:, None]
    found = here.space.canonical(groups.apart(met))
    np.testing.assert_array_equal(np.bincount(series_by_pose(here.space.decode(found)[0])[0]), [0, 2, 1, 1])
    assert (np.abs(found - here.space.canonical(met))[..., pose].max(axis=(0, 1)) <= 2.5 * steps[pose]).all()
    np.testing.assert_array_equal(np.sort(found[..., ~pose], axis=1), np.sort(met[..., ~pose], axis=1))
    held = here.assess(*here.space.decode(met), groups.numbers)
    now = here.assess(*here.space.decode(found))
    for name in ("duir", "feir"):
        criterion = known_criteria()[name]
        np.testing.assert_allclose(criterion.values(now), criterion.values(held), rtol=1e-3)
        one = criterion.values(here.assess(*here.space.decode(met)))
        assert abs(one[0] / criterion.values(held)[0] - 1.0) > 1e-2


def test_without_shared_references_nothing_is_held() -> None:
    here = problem(HEXAPOD)
    assert PoseGroups.of(here, starting_designs(here, 2, np.random.default_rng(1)).reshape(2, 3, -1)) is None


def test_poses_that_are_few_are_held_but_not_taken_apart() -> None:
    here = problem(HEXAPOD)
    here = replace(here, space=here.space.with_structure(4, 2))
    design = here.space.canonical(starting_designs(here, 1, np.random.default_rng(1)).reshape(1, 4, -1))
    groups = PoseGroups.of(here, design)
    assert groups is not None
    assert groups.series is None
    met = design.copy()
    met[..., here.space.of_pose] = met[:, :1, here.space.of_pose]
    np.testing.assert_array_equal(groups.apart(met), met)


def test_descents_do_not_join_series_that_want_one_pose() -> None:
    """All measurements of a bipod want its widest pose: DUIR falls as if the first step to it had not joined them."""
    here = problem(BIPOD, SHARED)
    starts = here.space.canonical(starting_designs(here, 6, np.random.default_rng(2)).reshape(6, 4, -1))
    weights = np.tile([1.0, 0.0], (6, 1))
    found = here.settable(
        pursued(Objectives(here), starts, np.zeros_like(weights), weights, Pace(steps=60, tolerance=1e-9, inner=1e-9))
    )
    assert (series_by_pose(here.space.decode(found)[0]).max(axis=1) == 4).all()


@pytest.mark.parametrize("seed", [1, 2])
def test_no_plan_that_branch_and_bound_meets_has_less_duir(seed: int) -> None:
    optimiser = {"population": 20, "generations": 60, "seed": seed, "polish": True, "bound_seconds": 3.0}
    here = problem(BIPOD, {**SHARED, "experiment.measurements": 5, "optimiser": optimiser})
    front = search(here)
    least = float(front.criteria["duir"].min())
    assert criterion_bounds(here, 0.0, front.decisions).whole.best == pytest.approx(least, rel=1e-6)

"""Series of measurements that share a reference while poses move: held, and apart where they meet."""

import numpy as np
import pytest

from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.optimality.objectives import Objectives, Pace, descended
from expdesign.planning.result import planned
from expdesign.planning.sampling import starting_designs
from expdesign.planning.scalarisation import Aims
from tests.design.problems import BIPOD, HEXAPOD, problem
from tests.oracle import Array

SHARED = {"experiment.deflection_noise.shared_reference": True, "experiment.measurements": 4}
"""Reference shared at a pose, four measurements."""


@pytest.mark.parametrize("base", [BIPOD, HEXAPOD])
def test_a_pose_set_anew_has_a_reference_of_its_own(base: dict[str, object]) -> None:
    """As good as a step away, and not what one series there would be; the plan says which is meant."""
    here = problem(base, SHARED)
    space, settings = here.space, here.space.settings
    pose = settings.poses
    design = starting_designs(here, 1, np.random.default_rng(3))
    design[..., pose] = design[:, :1, pose]
    together, anew, apart = design.copy(), design.copy(), design.copy()
    anew[0, :, settings.gene] = np.arange(4)
    apart[0, :, pose] += 2e-6 * np.arange(4) * ~space.discrete[pose][:, None]
    assert (np.unique(space.canonical(apart)[0][:, pose], axis=0).shape[0]) == 4
    plan = planned(here, space.canonical(anew)[0])
    np.testing.assert_array_equal(np.sort(plan.series), [1, 2, 3, 4])
    np.testing.assert_array_equal(planned(here, space.canonical(together)[0]).series, [1, 1, 1, 1])
    series = np.arange(1, 5)[None]
    for name in ("duir", "feir"):
        criterion = known_criteria()[name]
        found = criterion.values(here.assessed(space.canonical(anew)))
        expected = criterion.values(here.assess(*space.decode(space.canonical(apart)), series))
        np.testing.assert_allclose(found, expected, rtol=1e-3)
        one = criterion.values(here.assessed(space.canonical(together)))
        assert abs(one[0] / found[0] - 1.0) > 1e-2


def test_settings_are_numbered_whatever_the_order() -> None:
    here = problem(HEXAPOD, SHARED)
    space, settings = here.space, here.space.settings
    generator = np.random.default_rng(4)
    designs = starting_designs(here, 30, generator)
    designs[..., settings.poses] = designs[:, :1, settings.poses]
    designs[..., settings.gene] = generator.integers(4, size=(30, 4))
    found = space.canonical(designs)
    other = designs[:, generator.permutation(4)].copy()
    other[..., settings.gene] = generator.permutation(4)[other[..., settings.gene].astype(int)]
    np.testing.assert_array_equal(space.canonical(other), found)
    np.testing.assert_array_equal(space.canonical(found), found)
    expected = [
        known_criteria()["duir"].values(here.assess(*space.decode(d[None]), _series(d, settings.gene)))[0]
        for d in designs
    ]
    np.testing.assert_allclose(known_criteria()["duir"].values(here.assessed(found)), expected, rtol=1e-9)


def _series(design: Array, gene: int) -> Array:
    return design[None, :, gene].astype(int) + 1


def test_descents_do_not_join_series_that_want_one_pose() -> None:
    """All measurements of a bipod want its widest pose: DUIR falls as if the first step to it had not joined them."""
    here = problem(BIPOD, SHARED)
    starts = here.space.canonical(starting_designs(here, 6, np.random.default_rng(2)))
    weights = np.tile([1.0, 0.0], (6, 1))
    pace = Pace(steps=60, tolerance=1e-9, inner=1e-9)
    found = here.settable(descended(Objectives(here), starts, Aims(np.zeros_like(weights), weights), pace))
    before, after = ([len(np.unique(planned(here, each).series)) for each in designs] for designs in (starts, found))
    assert max(before) > 1
    assert sorted(after) == sorted(before)

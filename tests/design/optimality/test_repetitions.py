"""Plans of one or two measurements, repeated: the best of those drawn, against every one of them."""

import numpy as np
import pytest
from tests.design.problems import BIPOD, HEXAPOD, problem

from expdesign.criteria.criterion import known_criteria
from expdesign.design.optimality.objectives import Objectives, achieved
from expdesign.design.optimality.polish import Polishing
from expdesign.design.optimality.repetitions import Repetitions, repeated_designs, repetitions_count
from expdesign.design.start import extreme_measurements

NAMES = ("duir", "feir")


@pytest.mark.parametrize("shared", [False, True])
@pytest.mark.parametrize("base", [BIPOD, HEXAPOD])
def test_the_best_of_all_pairs_and_numbers_of_repetitions_are_found(base: dict[str, object], shared: bool) -> None:
    here = problem(base, {"experiment.measurements": 4, "experiment.deflection_noise.shared_reference": shared})
    drawn = 9
    generator = np.random.default_rng(4)
    found = Repetitions(here, NAMES, drawn, drawn, 0.5, generator)
    centres, weights = np.array([[0.0, 0.0], [0.0, 0.0], [0.1, 0.05]]), np.array([[1.0, 0.0], [0.0, 1.0], [1.0, 2.0]])
    plans, aims, scores = found.best(centres, weights, 2)
    measurements = extreme_measurements(here, drawn, 0.5, np.random.default_rng(4))
    pose = here.space.of_pose
    every = [
        measurements[[i] * times + [j] * (4 - times)]
        for times in (1, 2)
        for i in range(drawn)
        for j in range(drawn)
        if i == j or not shared or (measurements[i, pose] != measurements[j, pose]).any()
    ]
    assessment = here.assess(*here.space.decode(np.array(every)))
    values = np.stack([known_criteria()[name].values(assessment) for name in NAMES], axis=1)
    for aim in range(3):
        every_score = achieved(values, centres[aim], weights[aim])
        every_score = every_score[np.isfinite(every_score)]
        own = scores[aims == aim]
        assert own.min() == pytest.approx(every_score.min(), rel=1e-5)
    reached = here.assess(*here.space.decode(plans))
    values = np.stack([known_criteria()[name].values(reached) for name in NAMES], axis=1)
    regular = np.isfinite(values).all(axis=1)
    np.testing.assert_allclose(achieved(values, centres[aims], weights[aims])[regular], scores[regular], rtol=1e-5)
    assert len({tuple(row) for plan in plans for row in plan}) <= drawn
    assert max(len(np.unique(plan, axis=0)) for plan in plans) == 2


def test_where_no_load_errors_count_none_are_looked_at() -> None:
    here = problem(HEXAPOD, {"experiment.load_error": []})
    assert not repetitions_count(here)
    assert len(repeated_designs(here)) == 0


def test_extreme_measurements_are_at_ends_as_far_as_they_are_reached() -> None:
    here = problem(HEXAPOD, {"robot.limits.leg_length": [0.255, 0.345]})
    space = here.space
    found = extreme_measurements(here, 300, 1.0, np.random.default_rng(1))
    assert here.loaded.robot.usable(space.decode(found)[0]).all()
    free = ~space.discrete
    at_end = (found == space.lower) | (found == space.upper)
    assert at_end[:, free & ~space.of_pose].all()
    whole = at_end[:, free & space.of_pose].all(axis=1)
    assert 0.05 < whole.mean() < 0.95
    inner = extreme_measurements(here, 300, 0.0, np.random.default_rng(1))
    assert not ((inner == space.lower) | (inner == space.upper))[:, free].any()


def test_errors_of_each_measurement_average_out_over_repetitions() -> None:
    """Independent load errors alone: the rounds meet repeated measurements wherever these are the best they know."""
    error = [{"source": "wrench", "std": [4.0, 4.0, 4.0, 0.4, 0.4, 0.4], "shared": False}]
    here = problem(HEXAPOD, {"experiment.measurements": 3, "experiment.load_error": error, "optimiser.polish": True})
    polishing = Polishing(here)
    polishing.take(repeated_designs(here))
    single = np.array([len(np.unique(design, axis=0)) for design in polishing.pool])
    values = Objectives(here).values(polishing.pool)
    assert single[np.argmin(values[:, 1])] == 1

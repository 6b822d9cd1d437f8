"""Maps of the error to expect: at every point they are what a target at that point would have."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from expdesign.planning.accuracy_map import accuracy_maps
from expdesign.planning.criteria.accuracy import Total
from expdesign.planning.problem_file import read_problem
from expdesign.planning.sampling import reachable_measurements
from tests.design.problems import BIPOD, HEXAPOD, changed, problem


def decisions_of(case: Any, count: int) -> Any:
    generator = np.random.default_rng(5)
    return np.stack([case.space.sample(case.space.measurements, generator) for _ in range(count)])


BODY_AXES = changed(HEXAPOD, {"targets.0.tolerance_axes": "body", "targets.0.pose": [0.02, 0.0, 0.0, 0.1, 0.15, 0.0]})


@pytest.mark.parametrize("content", [BIPOD, HEXAPOD, BODY_AXES], ids=["bipod", "hexapod", "body-axes"])
def test_a_point_of_the_map_is_a_target_there(content: dict[str, Any]) -> None:
    case = problem(content)
    decisions = decisions_of(case, 2)
    covariance = sum(case.assess(*case.space.decode(decisions)).parameter_covariance)
    for chart in accuracy_maps(case, points=4):
        rms = chart.rms(np.asarray(covariance))
        known = np.argwhere(np.isfinite(rms[0]))
        assert len(known)
        for up, across in known[:: max(1, len(known) // 4)]:
            pose = case.targets.configurations[chart.target].copy()
            pose[list(chart.axes)] = chart.across[across], chart.up[up]
            there = problem(content, {"targets": [content["targets"][chart.target] | {"pose": pose.tolist()}]})
            expected = Total().values(there.assess(*there.space.decode(decisions)))
            np.testing.assert_allclose(rms[:, up, across], expected, rtol=1e-8)


def test_the_map_spans_where_measurements_may_be_taken_and_the_targets() -> None:
    changes = {"experiment.poses.bounds.x_m": [-0.01, 0.01], "targets.0.pose": [0.02, 0, 0, 0, 0, 0]}
    chart = accuracy_maps(problem(HEXAPOD, changes), points=3)[0]
    assert chart.axes == (0, 1)
    np.testing.assert_allclose(chart.across, [-0.01, 0.005, 0.02])


def test_poses_beyond_the_limits_are_blank() -> None:
    case = problem(HEXAPOD, {"experiment.poses.bounds.x_m": [-0.2, 0.2]})  # far beyond what the legs allow
    chart = accuracy_maps(case, points=5)[0]
    blank = np.isnan(chart.weight).any(axis=(-2, -1))
    assert blank[:, 0].all()
    assert not blank[2, 2]


def test_a_plane_in_which_nothing_varies_is_left_out() -> None:
    case = problem(HEXAPOD, {"experiment.poses.bounds.y_m": ..., "targets.1": ..., "targets.0.pose.1": 0.0})
    assert [chart.axes for chart in accuracy_maps(case, points=2)] == [(0, 2)]


def test_an_actuator_that_nothing_determines_and_nothing_needs_leaves_the_map_known() -> None:
    """The first joint of an arm turns about the vertical: weights load it neither in the plan nor on the map."""
    case = read_problem(Path(__file__).parents[2] / "configs" / "ur5.yaml")
    decisions = reachable_measurements(case, case.space.measurements, np.random.default_rng(2))[None]
    assessment = case.assess(*case.space.decode(decisions))
    assert assessment.rank[0] < assessment.parameters
    noise, load = assessment.parameter_covariance
    assert np.isnan(noise[0, 0]).all()
    assert np.isfinite(noise[0, 1:, 1:]).all()
    chart = accuracy_maps(case, points=5)[0]
    rms = chart.rms((noise + load)[0])
    usable = np.isfinite(chart.weight).all(axis=(-2, -1))
    assert usable.any()
    assert np.isfinite(rms[usable]).all()
    blind = np.full_like(noise[0], np.nan)
    assert np.isnan(chart.rms(blind)).all()

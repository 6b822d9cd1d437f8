"""What can be set: whole steps, decimal cells, limits kept, and criteria that are those of the plan as written."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import expdesign as xd
from expdesign.errors import InputError
from expdesign.io.table import parse_table
from expdesign.planning.variables import Grid, steps_of
from tests.design.problems import BIPOD, HEXAPOD, changed, problem, searched

FEW = {"population": 8, "generations": 2, "seed": 1, "polish": True}


@given(st.floats(-10.0, 10.0), st.sampled_from([1e-6, 2.5e-6, 1e-3, 0.125, 0.3, 7.0]))
def test_a_settable_value_is_the_double_nearest_to_its_decimal(value: float, step: float) -> None:
    grid = Grid(np.array([step]), np.array([-20.0]), np.array([20.0]))
    rounded = float(grid.nearest(np.array([value]))[0])
    assert abs(rounded - value) <= 0.5 * step * (1.0 + 1e-9)
    assert rounded == float(f"{rounded:.7f}")
    assert float(grid.nearest(np.array([rounded]))[0]) == rounded


def test_bounds_are_rounded_inward() -> None:
    grid = Grid(np.array([0.01, 0.01]), np.array([-0.123, 0.1]), np.array([0.456, 0.3]))
    np.testing.assert_array_equal(grid.lower, [-0.12, 0.1])
    np.testing.assert_array_equal(grid.upper, [0.45, 0.3])


def test_a_short_interval_has_a_fine_step_unless_it_is_stated() -> None:
    names, widths = ("x_m", "rx_rad", "mass_kg"), np.array([2e-5, 0.4, 0.0])
    np.testing.assert_allclose(steps_of(names, widths, {}), [1e-8, 1e-6, 1e-4], rtol=1e-12)
    np.testing.assert_allclose(steps_of(names, widths, {"x_m": 1e-5}), [1e-5, 1e-6, 1e-4], rtol=1e-12)


@pytest.mark.parametrize(
    ("resolution", "words"),
    [({"x_mm": 1e-6}, "Did you mean `x_m`"), ({"x_m": 10.0}, "no multiple of 10"), ({"x_m": 0.0}, "greater than 0")],
)
def test_bad_resolutions(resolution: dict[str, float], words: str) -> None:
    changes = {"experiment.resolution": resolution, "experiment.poses.bounds.x_m": [0.01, 0.3]}
    with pytest.raises(InputError, match=words):
        problem(BIPOD, changes)


def test_rounding_does_not_leave_the_limits() -> None:
    """Poses at a leg's limit, coarse steps: the nearest multiple is often beyond the limit, and another one is not."""
    case = problem(HEXAPOD, {"experiment.resolution": {"x_m": 1e-3, "z_m": 2e-3, "rx_rad": 5e-3}})
    robot, space = case.loaded.robot, case.space
    decisions = space.sample(4000, np.random.default_rng(1)).reshape(-1, 4, space.decisions)
    excess = robot.limit_excess(space.decode(decisions)[0])
    near = decisions[((excess <= 0.0) & (excess > -2e-3)).any(axis=1) & (excess <= 0.0).all(axis=1)]
    assert len(near) > 20
    assert (robot.limit_excess(space.decode(space.canonical(near))[0]) > 1e-12).any()
    assert (robot.limit_excess(space.decode(case.settable(near))[0]) <= 1e-12).all()


def assert_written_right(config: Any) -> None:
    """Criteria recomputed from `plans.csv` are those of `pareto.csv`; series stand together at one pose."""
    result = searched(config)
    files = result.files()
    plans, pareto = parse_table(files["plans.csv"], "plans.csv").frame, parse_table(files["pareto.csv"], "p").frame
    names = result.problem.loaded.robot.configuration
    robot = result.problem.loaded.robot
    for number, row in pareto.set_index("design").iterrows():
        plan = plans[plans["design"] == number].drop(columns="design")
        # A series is one setting of a pose; a pose may be set anew.
        assert (plan.groupby("series")[list(names)].nunique() == 1).all(axis=None)
        assert plan["series"].astype(int).is_monotonic_increasing
        judged = xd.evaluate(result.problem, plan)
        assert (robot.limit_excess(judged.plan.configurations) <= 1e-12).all()
        for name in ("duir", "feir", "total", "o1", "o2", "o3", "o4", "o5", "o_tp", "o_mv"):
            assert judged.record[name] == pytest.approx(float(row[name]), rel=1e-9), name
        if "tilt" not in str(result.problem.config["experiment"].get("load")):
            digits = [len(cell.split("e")[0].replace(".", "").strip("-0")) for cell in plan.to_numpy().ravel()]
            assert max(digits) <= 12


def shared(config: dict[str, Any], **changes: Any) -> dict[str, Any]:
    return changed(config, {"experiment.deflection_noise.shared_reference": True, "optimiser": FEW, **changes})


@pytest.mark.parametrize("base", [BIPOD, HEXAPOD])
def test_criteria_are_those_of_the_plan_as_written(base: dict[str, Any]) -> None:
    assert_written_right(changed(base, {"optimiser": FEW}))
    assert_written_right(shared(base))


def test_shared_references_are_not_escaped_by_poses_that_differ_by_nothing() -> None:
    """Rounded to the steps, no plan has two poses closer than a step, and its criteria stay what they were."""
    case = problem(shared(HEXAPOD, **{"experiment.measurements": 5, "optimiser": FEW}))
    result = searched(case)
    for decisions in result.front.decisions:
        poses = np.unique(case.space.decode(decisions)[0], axis=0)
        apart = np.abs(poses[:, None] - poses[None]).max(axis=-1) + np.eye(len(poses))
        assert apart.min() >= 0.999e-6


def _random_configuration(seed: int) -> dict[str, Any]:
    generator = np.random.default_rng(seed)
    base = HEXAPOD if generator.random() < 0.5 else BIPOD
    few = {"population": 6, "generations": 2, "seed": seed, "polish": bool(generator.random() < 0.5)}
    changes: dict[str, Any] = {
        "experiment.measurements": int(generator.integers(2, 6)),
        "experiment.deflection_noise.shared_reference": bool(generator.random() < 0.5),
        "optimiser": few,
    }
    form = generator.integers(3)
    if form == 1 and base is BIPOD:
        changes["experiment.poses"] = {"grid": {"x_m": [-0.3, 0.3, 7], "y_m": [0.35, 0.95, 4]}}
    if form == 2:
        changes["experiment.resolution"] = {"x_m": float(generator.choice([1e-3, 2.5e-4, 1e-5]))}
    return changed(base, changes)


@pytest.mark.parametrize(
    "seed", [4, 5, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(204) if seed not in (4, 5))]
)
def test_random_configurations(seed: int) -> None:
    assert_written_right(_random_configuration(seed))

"""Tolerances about the body's own axes (theory.md 9.C)."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from expdesign.assurance.validation.repeated import standard_deviation
from expdesign.assurance.validation.simulation import simulate
from expdesign.errors import InputError
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.plan import Plan
from expdesign.planning.problem import DesignProblem
from expdesign.planning.sampling import starting_designs
from tests.design.problems import BIPOD, HEXAPOD, problem
from tests.oracle import Array

ANGLES = [0.1, 0.15, 0.0]


def mirror(axes: str, angles: list[float], orientation: str = "fixed-xyz") -> DesignProblem:
    return problem(
        HEXAPOD,
        {
            "robot.orientation": orientation,
            "experiment.load.gravity": ...,
            "targets": [
                {
                    "pose": [0.0, 0.0, 0.0, *angles],
                    "payload": {"mass_kg": 26.5, "com_m": [0.05, 0.02, 0.1]},
                    "tolerance": {"dx_m": 1e-6, "drx_rad": 1e-6, "dry_rad": 1e-6},
                    "tolerance_axes": axes,
                }
            ],
        },
    )


def one_plan(here: DesignProblem) -> Plan:
    space = here.space
    decisions = starting_designs(here, 1, np.random.default_rng(1))[0]
    return Plan(*space.decode(decisions), np.arange(space.measurements) + 1)


def duir(here: DesignProblem, plan: Plan) -> float:
    return float(known_criteria()["duir"].values(here.assess(plan.configurations[None], plan.loads[None]))[0])


def test_the_axes_are_those_of_small_turns_of_the_body() -> None:
    here = mirror("body", ANGLES)
    axes = here.targets.axes
    assert axes is not None

    def rotation(angles: Array) -> Rotation:
        return Rotation.from_euler("xyz", angles)

    base = np.array(ANGLES)
    for index in range(3):
        step = 1e-6 * np.eye(3)[index]
        turn = (rotation(base - step).inv() * rotation(base + step)).as_rotvec() / 2e-6
        np.testing.assert_allclose(axes[0, 3:, 3 + index], turn, atol=1e-9)
    # C15: the angle rz leaks −sin(ry) into the body's x and sin(rx)·cos(ry) into its y.
    np.testing.assert_allclose(axes[0, 3:5, 5], [-0.1494, 0.0987], atol=1e-4)


@pytest.mark.parametrize(("orientation", "angles"), [("fixed-xyz", [0.0, 0.0, 0.0]), ("moving-xyz", ANGLES)])
def test_without_rotation_or_with_moving_axes_selection_is_exact(orientation: str, angles: list[float]) -> None:
    axes = mirror("body", angles, orientation).targets.axes
    assert axes is not None
    np.testing.assert_allclose(axes[0, 3:5, 5], 0.0, atol=1e-12)
    if orientation == "fixed-xyz":
        np.testing.assert_allclose(axes[0], np.eye(6), atol=1e-12)


def test_the_angle_about_the_mirrors_axis_does_not_matter() -> None:
    """Two angle conventions of one physical target: equal with axes of the body, not with selected angles."""
    turned = Rotation.from_euler("xyz", ANGLES)
    same = turned.as_euler("XYZ").tolist()
    values = {}
    for axes in ("body", "pose"):
        fixed = mirror(axes, ANGLES)
        moving = mirror(axes, same, "moving-xyz")
        plan = one_plan(fixed)
        other = plan.configurations.copy()
        other[:, 3:] = Rotation.from_euler("xyz", plan.configurations[:, 3:]).as_euler("XYZ")
        values[axes] = duir(fixed, plan), duir(moving, Plan(other, plan.loads, plan.series))
    # The noise of measured angles is not quite that of the other angles (they differ by up to rx·ry of themselves).
    assert values["body"][1] == pytest.approx(values["body"][0], rel=0.02)
    assert abs(values["pose"][1] / values["pose"][0] - 1.0) > 2.0 * abs(values["body"][1] / values["body"][0] - 1.0)


def test_monte_carlo_attains_them() -> None:
    here = mirror("body", ANGLES)
    result = simulate(here, one_plan(here), 20_000, 3)
    found = standard_deviation(result.errors[:, 0])
    predicted = np.sqrt(np.diag(result.predicted_covariance[0]))
    assert np.abs(found.z_score(predicted)).max() < 4.0


def test_a_position_alone_has_no_axes_of_a_body() -> None:
    with pytest.raises(InputError, match="pose with angles"):
        problem(BIPOD, {"targets.0.tolerance_axes": "body"})

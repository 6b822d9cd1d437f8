"""Recordings of arms with one effect concealed: diagnosis names it, at its place."""

import numpy as np
import pytest

from expdesign.diagnosis.diagnose import diagnose
from expdesign.diagnosis.library import library
from expdesign.diagnosis.result import Diagnosis
from expdesign.estimation.identify import identify
from expdesign.report.remark_texts import sentences
from tests.chain.arm_rows import arm_rows, concealed, six_axis
from tests.chain.kinds import KINDS

# Class, component, variant and parameters; sizes as of worn or light arms, each well above the noise.
CONCEALED = {
    "tilting bearing": ("JointCompliance", "joint 2", "", [8e-6]),
    "tilting bearing, two directions": ("JointCompliance", "joint 3", "two directions", [2e-5, 8e-6]),
    "bending link": ("LinkCompliance", "link 2", "", [6e-6, 3e-6]),
    "play": ("JointBacklash", "joint 4", "middle", [2e-4]),
    "gear error": ("JointPeriodicError", "joint 3", "", [6e-5, 4e-5, 0.9]),
    "soft support": ("BaseCompliance", "base", "diagonal", [2e-7, 4e-7, 6e-7, 2e-6, 5e-6, 1e-6]),
    "warm joint": ("ArmThermalDrift", "joint 2", "", [2e-5]),
    "growing link": ("ArmThermalDrift", "link 3", "", [12e-6]),
    "warming up": ("ArmThermalDrift", "joint 3", "warm-up", [8e-4, 600.0]),
    "wrong zero": ("ArmGeometryError", "joint 3", "offset", [0.02]),
    "wrong link": ("ArmGeometryError", "link 2", "frame", [0.01, 0.0, 0.0, 0.0, 0.03, 0.0]),
    "unsettled": ("LoggedBeforeSettled", "all joints", "logged before settled", [0.06]),
    "change of geometry": ("ArmGeometricStiffness", "geometry", "", [1.0]),
    "hardening gear": ("LegNonlinearStiffness", "joint 2", "", [4e-4]),
    "friction": ("FrictionHysteresis", "joint 3", "rigid", [1.0]),
    "creeping gear": ("Creep", "joint 2", "", [0.1, 60.0, 0.5]),
    "wrong centre of mass": ("PayloadComOffset", "payload", "", [0.004, -0.003, 0.002]),
    "tilted load": ("LoadDirectionTilt", "payload", "", [0.01, -0.008]),
}


def _diagnosed(case: str) -> tuple[Diagnosis, str, str]:
    name, component, variant, parameters = CONCEALED[case]
    robot = six_axis()
    kind = next(kind for kind in KINDS if kind.__name__ == name)
    if name == "LegNonlinearStiffness":
        variant = str(kind.variants(robot)[0])
    effect = kind.from_text(robot, component, variant)
    return diagnose(robot, concealed(robot, arm_rows(robot), (effect,), parameters)), effect.physics, component


def _cases() -> list[object]:
    """Every fourth one in every run, all of them as a slow proof."""
    return [
        case if index % 4 == 0 else pytest.param(case, marks=pytest.mark.slow) for index, case in enumerate(CONCEALED)
    ]


@pytest.mark.parametrize("case", _cases())
def test_a_concealed_effect_is_named(case: str) -> None:
    found, physics, component = _diagnosed(case)
    assert found.verdict == "explained"
    first = found.findings[0]
    assert (first.physics, first.component) == (physics, component)
    assert first.probability > 0.85  # 0.895 for a wrong zero
    assert found.errors.test_after < min(1.2, found.errors.test_before)


def test_an_arm_that_is_as_modelled_is_consistent() -> None:
    robot = six_axis()
    found = diagnose(robot, concealed(robot, arm_rows(robot, seed=4), (), [], seed=5))
    assert found.verdict == "consistent"
    assert found.findings == ()


def test_arms_are_not_offered_what_only_legs_have() -> None:
    robot = six_axis()
    points = concealed(robot, arm_rows(robot), (), [])
    offered = library(robot, points)
    assert {e.physics for e in offered}.isdisjoint({"leg_backlash", "leg_coupling", "passive_joint_stiffness"})
    words = {str(effect.component) for effect in offered}
    assert not [word for word in words if "leg" in word]
    assert {"joint_backlash", "joint_compliance", "link_compliance"} <= {e.physics for e in offered}
    assert len({effect.key for effect in offered}) == len(offered)


def test_a_joint_about_the_vertical_keeps_its_stiffness_and_says_so() -> None:
    """Weights do not load joint 1: the others are identified, and it stays as uncertain as it was."""
    robot = six_axis()
    points = concealed(robot, arm_rows(robot), (), [])
    result = identify(robot, points)
    relative = np.sqrt(np.diag(result.covariance)) / robot.compliance
    assert relative[0] == pytest.approx(1.0)
    assert result.compliance.estimate[0] == pytest.approx(robot.compliance[0])
    assert (relative[1:] < 0.01).all()
    assert result.fit.rank == 5
    assert any(text.startswith("No fitted row shows how joint 1 yields") for text in sentences(result.suspicions))


def test_a_load_across_it_tells_the_stiffness_of_joint_1() -> None:
    robot = six_axis()
    points = concealed(robot, arm_rows(robot, sideways=True), (), [])
    result = identify(robot, points)
    truth = np.random.default_rng(7).uniform(0.8, 1.2, 6)
    errors = (result.compliance.estimate / robot.compliance - truth) / (
        np.sqrt(np.diag(result.covariance)) / robot.compliance
    )
    assert np.abs(errors).max() < 4.0
    assert not result.suspicions


@pytest.mark.parametrize(
    "case",
    ["tilting bearing", *(pytest.param(case, marks=pytest.mark.slow) for case in ("bending link", "play"))],
)
def test_the_part_that_yields_is_located_before_it_is_named(case: str) -> None:
    found, _, component = _diagnosed(case)
    assert component in {probe.name for probe in found.location.components[:3]}

"""Arms by pinocchio's mechanics: the known limits, and cases that are what they claim."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

pytest.importorskip("exudyn", reason="the recipes share the laboratory's laws")
pytest.importorskip("pinocchio", reason="arms are solved with pinocchio")
from benchmarks.concealed.arms.cases import draw_arm, draw_case
from benchmarks.concealed.arms.mechanics import DEFLECTION, JOINTS, WRENCH, Arm, Hidden
from benchmarks.concealed.arms.recipes import RECIPES

Q = np.array([0.3, -0.4, 1.1, 0.2, 0.7, -0.5])
FORCE = np.array([5.0, -3.0, -10.0, 0.5, 0.2, -0.3])


def loads(*wrenches: np.ndarray) -> pd.DataFrame:
    rows = pd.DataFrame(np.tile(Q, (len(wrenches), 1)), columns=list(JOINTS))
    rows[list(WRENCH)] = np.array(wrenches)
    return rows.assign(series=1)


@pytest.fixture(scope="module")
def arm():
    _, urdf, compliance = draw_arm(np.random.default_rng(1))
    return urdf, compliance


def test_without_anything_hidden_it_is_the_base_model(arm):
    urdf, compliance = arm
    jacobian = Arm(urdf, compliance).jacobian(Q)
    expected = jacobian @ (compliance * (jacobian.T @ FORCE))
    found = Arm(urdf, compliance).deflections(loads(0 * FORCE, FORCE))
    assert found[0] == pytest.approx(0.0, abs=1e-12)
    assert found[1] == pytest.approx(expected, rel=0.02, abs=1e-6)


@pytest.mark.parametrize("physics", list(RECIPES))
def test_each_vanishes_with_its_size(arm, physics):
    urdf, compliance = arm
    torques = np.abs(np.random.default_rng(2).normal(size=(9, 6))) + 1.0
    concealed = RECIPES[physics](compliance, torques, np.random.default_rng(3))
    rows = loads(0 * FORCE, FORCE, 0.5 * FORCE)
    plain = Arm(urdf, compliance).deflections(rows)
    changes = [
        np.abs(Arm(urdf, compliance, [concealed.of_size(size)]).deflections(rows) - plain).max()
        for size in (1e-9, concealed.high / 10)
    ]
    assert changes[0] < 1e-8
    assert changes[1] > 1e-7


def test_a_yielding_base_turns_the_arm_about_its_foot(arm):
    urdf, compliance = arm
    tilt = Hidden(base=lambda moment, _: 1e-6 * moment)
    change = Arm(urdf, compliance, [tilt]).deflections(loads(FORCE)) - Arm(urdf, compliance).deflections(loads(FORCE))
    tip = Arm(urdf, compliance)._place(Q).translation
    moment = FORCE[3:] + np.cross(tip, FORCE[:3])
    assert change[0, 3:] == pytest.approx(1e-6 * moment, rel=0.01, abs=1e-9)
    assert change[0, :3] == pytest.approx(np.cross(1e-6 * moment, tip), rel=0.02, abs=2e-8)


@pytest.mark.parametrize("physics", ["gear_hysteresis", "none"])
def test_cases_repeat_and_show_what_they_shall(physics):
    case, again = (draw_case(physics, np.random.default_rng([1, 4])) for _ in range(2))
    pd.testing.assert_frame_equal(case.recordings, again.recordings)
    assert case.truth == again.truth
    mismatch = case.truth["mismatch_in_std"]
    assert mismatch <= 0.1 if physics == "none" else 1.8 <= mismatch <= 11.0
    assert 45 <= len(case.recordings) <= 150
    assert "arm.urdf" in case.files
    assert {f"true_{name}" for name in DEFLECTION} <= set(case.later)
    assert not [name for name in case.recordings if str(name).startswith(("true_", "base_"))]

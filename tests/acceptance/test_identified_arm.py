"""Acceptance of an arm that positions calibrated: the geometry counts, as in the commands that `compensate` writes."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

import expdesign as xd
from expdesign.app.api.configuration import problem_of
from expdesign.diagnosis.dispersion import widened
from expdesign.errors import InputError
from expdesign.report.acceptance_texts import sentences
from tests.design.problems import plan_table
from tests.plant import PLAIN, ROBOT, recordings

ROOT = Path(__file__).parents[2]


def configuration(calibration: str | None) -> dict[str, Any]:
    """The shipped arm's targets, without load errors, which an arm that carries nothing does not have."""
    content: dict[str, Any] = yaml.safe_load((ROOT / "configs/ur5.yaml").read_text())
    del content["experiment"]["load_error"]
    content["objectives"] = ["duir"]
    if calibration == "geometric":  # of the unloaded arm
        del content["experiment"]["load"]
        for target in content["targets"]:
            del target["payload"]
    if calibration is not None:
        content["experiment"]["calibration"] = calibration
    return {**content, "robot": str(ROBOT)}


@pytest.mark.parametrize("calibration", ["both", None])
def test_the_budget_is_that_of_the_commands(calibration: str | None) -> None:
    """By the compliances alone U of the tip was less than half of what `compensate` states."""
    frame = recordings(PLAIN, 150, 5, loads=False)
    config = configuration(calibration)
    found = xd.identify(ROBOT, frame, targets=config)
    accepted = found.acceptance
    assert accepted is not None
    commands = xd.compensate(found, config).frame
    stated = commands[["sx_m", "sy_m", "sz_m"]].to_numpy()
    np.testing.assert_allclose(accepted.budget.standard[:, :3], stated, rtol=0.02)
    assert accepted.left_out is None
    assert "what these recordings may hide is not counted" in " ".join(sentences(accepted))
    assert 0.0 <= accepted.robot_risk <= 1.0


def test_what_no_reading_shows_rests_on_the_drawing_and_says_so(tmp_path: Path) -> None:
    """Zeros are off by 1 mrad: joint 1's is one rotation with the instrument's, joint 6's with the only marker's."""
    frame = recordings(PLAIN, 180, 5, loads=False).query("marker == 'one'")
    config = configuration("both")
    found = xd.identify(ROBOT, frame, targets=config)
    arm, fit, accepted = found.result.arm, found.result.fit, found.acceptance
    assert arm is not None
    assert accepted is not None
    steps = np.hstack([arm.drawn.steps, arm.drawn.base])
    shown = np.abs(fit.sensitivities) @ np.abs(steps)
    assert np.abs(fit.sensitivities @ steps).max() < 1e-2 * shown.max()
    base, tip = accepted.budget.base, accepted.budget.of("drawing")
    assert base is not None
    assert tip is not None
    for turn in (base[:, 5], np.linalg.norm(tip.deviation[:, 3:], axis=1)):
        assert (turn > 5e-4).all()
        assert (turn < 3e-3).all()
    assert (accepted.budget.standard >= tip.deviation).all()
    said = " ".join(sentences(accepted))
    assert "ost of U rests on the drawing, because no reading shows where the tip is" in said
    assert "in the base's frame as drawn" in said
    found.save(tmp_path / "out")
    commands = xd.compensate(tmp_path / "out" / "model.yaml", config)
    stated = commands.frame[["sx_m", "sy_m", "sz_m", "srx_rad", "sry_rad", "srz_rad"]].to_numpy()
    np.testing.assert_allclose(accepted.budget.standard, stated, rtol=0.02)
    assert "rests on the drawing" in " ".join(commands.scope)


@pytest.mark.parametrize("calibration", ["both", "geometric"])
def test_a_diagnosis(calibration: str) -> None:
    """U counts the geometry, as in the commands and in those of `identify`; nothing is said of what is hidden.

    That joint 1's zero and the instrument's turn cannot be told apart made U a hundred times as large.
    """
    frame = recordings(PLAIN, 75, 5, loads=False)
    config = configuration(calibration)
    found = xd.diagnose(ROBOT, frame, targets=config)
    assert found.verdict == "consistent"
    accepted = found.acceptance
    assert accepted is not None
    assert accepted.decided
    commands = xd.compensate(found, config).frame
    stated = commands[["sx_m", "sy_m", "sz_m"]].to_numpy()
    # Commands are up to 6 mrad from the targets, at which the budget is.
    np.testing.assert_allclose(accepted.budget.standard[:, :3], stated, rtol=0.05)
    identified = xd.identify(ROBOT, frame, targets=config).acceptance
    assert identified is not None
    np.testing.assert_allclose(accepted.budget.standard, identified.budget.standard, rtol=0.1)
    assert accepted.verdict == identified.verdict
    assert accepted.budget.base is not None
    # Readings are as uncertain in these frames as before.
    fit = found.result.predictive.fit
    before = widened(fit, found.result.widening).estimable.deviations(fit.sensitivities)
    np.testing.assert_allclose(found.result.known.estimable.deviations(fit.sensitivities), before, rtol=0.02)
    assert any(parameter.name.startswith("link_") for parameter in found.model.chain.parameters)
    assert accepted.left_out is None
    assert "hidden" not in found.record
    assert "what these recordings may hide is not counted" in " ".join(sentences(accepted))


def test_deflections_do_not_show_a_geometry_that_is_calibrated() -> None:
    config = configuration(None)
    deflections = xd.simulate(config, plan_table(problem_of(config))).frame
    with pytest.raises(InputError, match=r"calibrates the geometry.*do not show"):
        xd.identify(ROBOT, deflections, targets=configuration("both"))
    with pytest.raises(InputError, match=r"calibrates the geometry.*do not show"):
        xd.diagnose(ROBOT, deflections, targets=configuration("both"))

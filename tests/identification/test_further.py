"""What is identified of an arm on request: masses, tools, harmonics, a wandering stand; pinocchio is the machine."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import expdesign as xd
from expdesign.errors import InputError
from expdesign.estimation.arm_options import Further
from expdesign.report.identification_report import IdentificationResult
from tests.plant import NOISE, PLAIN, READ, ROBOT, Faults, recordings, usual_faults

TOOL = usual_faults(3, tool=3.0)


def found(frame: pd.DataFrame, *further: Further) -> IdentificationResult:
    return xd.identify(ROBOT, frame, further=further)


def held_out(result: IdentificationResult) -> float:
    """RMS length of the errors of held-out positions, in that of their noise."""
    return result.result.arm.accuracy["held out", "position"].after.rms / (NOISE * np.sqrt(3.0))


def parameters(result: IdentificationResult) -> dict[str, tuple[float, float]]:
    """Value and standard deviation of what was identified, by its name."""
    fit = result.result.fit
    names = [parameter.name for parameter in fit.chain.parameters]
    return dict(
        zip(names, zip(fit.values.tolist(), np.sqrt(np.diag(fit.covariance)).tolist(), strict=True), strict=True)
    )


def wandering(faults: Faults, *, shift: float = 1e-4, turn: float = 5e-5) -> pd.DataFrame:
    """A series for every row, and a frame that wanders by `shift` (m) and `turn` (rad) in five hours."""
    frame, random = recordings(faults, 300, 5), np.random.default_rng(2)
    pose = np.arange(len(frame)) // 3
    steps = random.standard_normal((pose.max() + 1, 6)) * ([shift] * 3 + [turn] * 3) / np.sqrt(pose.max() + 1)
    moved = np.cumsum(steps, axis=0)[pose]
    place = frame[READ].to_numpy()
    frame[READ] = place + moved[:, :3] + np.cross(moved[:, 3:], place)
    return frame.assign(time_s=180.0 * pose, series=frame["sequence"])


def test_a_tool_that_nobody_weighed_and_a_runout(tmp_path: Path) -> None:
    frame = recordings(TOOL, 300, 5)
    assert held_out(found(frame)) > 3.0
    result = found(frame, "tool", "harmonics")
    assert held_out(result) < 1.1
    values = parameters(result)
    mass, centre = TOOL.tool
    size, phase = TOOL.periodic
    truth = {
        "tool_mass_kg": mass,
        "joint_3_sine_1_rad": size * np.cos(phase),
        "joint_3_cosine_1_rad": size * np.sin(phase),
    }
    truth |= {f"tool_moment_{axis}_kgm": mass * c for axis, c in zip("xyz", centre, strict=True)}
    for name, value in truth.items():
        assert abs(values[name][0] - value) < 3.0 * values[name][1], name
    assert values["tool_mass_kg"][1] < 0.5
    result.save(tmp_path / "found")
    again = xd.predict(tmp_path / "found" / "model.yaml", frame, readings=True).frame
    direct = xd.predict(result, frame, readings=True).frame
    np.testing.assert_allclose(again[READ], direct[READ], atol=1e-9)
    assert "tool_mass_kg" in (tmp_path / "found" / "report.html").read_text(encoding="utf-8")


def test_masses_of_links_that_are_right_stay_near_what_the_file_says() -> None:
    result = found(recordings(PLAIN, 300, 5), "masses")
    assert held_out(result) < 1.1
    for name, (value, deviation) in parameters(result).items():
        if name == "relative_mass_error":
            assert abs(value) < 3.0 * deviation


def test_a_stand_that_wanders_is_followed(tmp_path: Path) -> None:
    frame = wandering(PLAIN)
    still, moving = held_out(found(frame)), found(frame, "drift")
    assert still > 1.8
    assert held_out(moving) < 1.3
    moving.save(tmp_path / "found")
    again = xd.predict(tmp_path / "found" / "model.yaml", frame).frame
    direct = xd.predict(moving, frame).frame
    np.testing.assert_allclose(again[READ], direct[READ], atol=1e-9)


def test_a_stand_that_stands_still_costs_next_to_nothing() -> None:
    frame = wandering(PLAIN, shift=0.0, turn=0.0)
    assert held_out(found(frame, "drift")) < 1.05 * held_out(found(frame))


def test_what_cannot_be_asked_for() -> None:
    frame = recordings(PLAIN, 60, 5)
    with pytest.raises(InputError, match="a drift needs times"):
        found(frame, "drift")
    with pytest.raises(xd.ArgumentError, match="`gears` is not in the list of what can be given"):
        xd.identify(ROBOT, frame, further=["gears"])  # type: ignore[list-item]

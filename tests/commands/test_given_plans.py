"""Plans beside the configuration that they are given for: one reader, whatever is done with them."""

from pathlib import Path

import pandas as pd
import pytest

from tests.commands.calls import CONFIG, Printed, call, plan_file, refusal

WAYS = {
    "evaluate": (),
    "simulate": ("--out", "recordings.csv"),
    "sheet": ("--out", "sheet"),
    "montecarlo": ("--samples", "100", "--out", "repeated"),
}


def way(command: str, folder: Path) -> tuple[object, ...]:
    """What follows the plan in a call."""
    return tuple(folder / each if each in ("recordings.csv", "sheet", "repeated") else each for each in WAYS[command])


def changed(folder: Path, **columns: float | list[float]) -> Path:
    path = plan_file(folder)
    pd.read_csv(path).assign(**columns).to_csv(path, index=False)
    return path


@pytest.mark.parametrize("command", [command for command in WAYS if command != "simulate"])
def test_what_is_to_be_measured_has_to_be_reached(command: str, tmp_path: Path, capsys: Printed) -> None:
    """`simulate` says so, and goes on: where check readings are taken is no matter of the configuration."""
    plan, what = changed(tmp_path, z_m=0.3), "beyond the robot's limits: leg"
    assert f"row 2: the pose is {what}" in refusal(capsys, command, CONFIG, plan, *way(command, tmp_path))
    assert call("simulate", CONFIG, plan, *way("simulate", tmp_path)) == 0
    assert f"row 2: a point is {what}" in capsys.readouterr().err


@pytest.mark.parametrize("command", [command for command in WAYS if command != "simulate"])
def test_what_is_beyond_the_bounds_is_said(command: str, tmp_path: Path, capsys: Printed) -> None:
    plan = changed(tmp_path, mass_kg=[26.5, 40.0, 26.5, 30.0], com_z_m=0.12000001)
    assert call(command, CONFIG, plan, *way(command, tmp_path)) == 0
    said = capsys.readouterr().err
    assert "rows 3, 5: mass_kg is 40, beyond the bounds of the configuration (5 to 26.5)" in said
    assert said.count("beyond the bounds") == 1


def test_degrees_in_a_plan_are_asked_about(tmp_path: Path, capsys: Printed) -> None:
    assert call("evaluate", CONFIG, changed(tmp_path, rz_rad=6.25)) == 0
    assert "row 2: rz_rad would be 6.25 rad, i.e. 358°. Is it in degrees?" in capsys.readouterr().err

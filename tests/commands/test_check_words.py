"""What `expdesign check` says is said once, of what there is."""

import re
from pathlib import Path

import numpy as np
import yaml

from tests.commands.calls import Printed, call
from tests.plausibility.sound import CONFIGS, content_of, recordings_of


def test_a_mistake_is_said_once_with_one_word_and_a_remedy(tmp_path: Path, capsys: Printed) -> None:
    frame = recordings_of(content_of("hexapod-h1"), 5)
    frame[["dx_m", "dy_m", "dz_m"]] *= 1e3
    frame[["sx_m", "sy_m", "sz_m"]] *= 1e3
    frame.to_csv(tmp_path / "mm.csv", index=False)
    call("check", tmp_path / "mm.csv", "--robot", CONFIGS / "robots" / "hexapod-h1.yaml")
    said = capsys.readouterr()
    assert (said.err + said.out).count("in mm?") == 1
    assert "as in `dx_mm`" in said.err
    assert "suspicion" not in said.err


def test_a_joint_without_a_load_is_said_in_place_of_its_deviation(tmp_path: Path, capsys: Printed) -> None:
    """Weights load no joint about the vertical."""
    frame = recordings_of(content_of("ur5"), 5, rows=10)
    frame.to_csv(tmp_path / "arm.csv", index=False)
    assert call("check", tmp_path / "arm.csv", "--robot", CONFIGS / "robots" / "ur5.yaml") == 0
    said = capsys.readouterr().out
    assert "The recordings identify 5 of 6 stiffnesses, the worst (joint " in said
    assert "; no load acts on joint 1." in said


def test_a_stiffness_that_drowns_in_noise_has_no_percentage(tmp_path: Path, capsys: Printed) -> None:
    """What may be rigid is said to have a lower limit; what is identified has less than 51 % of standard deviation."""
    frame = recordings_of(content_of("ur5"), 5, rows=10)
    noise = 100.0 * np.random.default_rng(1).standard_normal((len(frame), 6))
    for index, name in enumerate(("x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad")):
        frame[f"d{name}"] += noise[:, index] * frame[f"s{name}"]
        frame[f"s{name}"] *= 100.0
    frame.to_csv(tmp_path / "arm.csv", index=False)
    call("check", tmp_path / "arm.csv", "--robot", CONFIGS / "robots" / "ur5.yaml")
    said = capsys.readouterr().out
    (identified,) = [line for line in said.splitlines() if line.startswith("The recordings identify")]
    assert "only a lower limit" in identified
    assert all(float(number) < 51.0 for number in re.findall(r"([\d.]+)%", identified))


def test_under_a_budget_the_numbers_of_measurements_that_fit_are_said(tmp_path: Path, capsys: Printed) -> None:
    content = content_of("hexapod-h1")
    del content["experiment"]["measurements"]
    content["experiment"] |= {"budget": {"minutes": 60}, "costs": {"pose_change": 5, "mass_change": 3, "reading": 1}}
    (tmp_path / "budget.yaml").write_text(yaml.safe_dump(content), encoding="utf-8")
    assert call("check", tmp_path / "budget.yaml") == 0
    assert "measurements, as many as 60 minutes allow, with " in capsys.readouterr().out

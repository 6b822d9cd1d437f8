"""From a robot given by radii and a tracker's list of points to a certificate, by the commands alone."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
import yaml

from tests.commands.calls import ROOT, call
from tests.docs.test_tutorial import NUMBER, loaded

LIMITS = (ROOT / "docs" / "limits.md").read_text(encoding="utf-8")
TRUTH = np.array([8.7e6, 9.6e6, 11.2e6, 9.1e6, 10.4e6, 7.9e6])


@pytest.mark.slow
def test_the_page_shows_what_its_commands_print(tmp_path: Path) -> None:
    """To the word, and its figures to a twentieth: another linear algebra leads to another optimum."""
    tutorial = loaded("tutorial")
    page = tutorial.PAGE.with_stem("walk").read_text(encoding="utf-8")
    steps = list(tutorial.follow(page, tmp_path))
    assert len(steps) == 14
    for step in steps:
        assert NUMBER.sub("#", step.printed) == NUMBER.sub("#", step.shown), step.command
        printed, shown = (np.array(NUMBER.findall(text), dtype=float) for text in (step.printed, step.shown))
        np.testing.assert_allclose(printed, shown, rtol=0.05, err_msg=step.command)
    low, high = (1e6 * float(text) for text in re.findall(r"pages of ([\d.]+) to ([\d.]+) MB", LIMITS)[0])
    sizes = [(tmp_path / name / "report.html").stat().st_size for name in ("planned", "identified", "diagnosed")]
    assert low <= min(sizes)
    assert max(sizes) <= high
    _holds_the_truth_and_fails_another_robot(tmp_path)


def _holds_the_truth_and_fails_another_robot(folder: Path) -> None:
    result = json.loads((folder / "identified" / "identification.json").read_text(encoding="utf-8"))
    estimate, low, high = np.array(list(result["stiffness"].values())).T
    assert np.all(np.abs(estimate - TRUTH) < 2.0 * (high - low))  # 8 standard deviations: never by chance
    assert np.all(high - low < 0.15 * TRUTH)
    weak = yaml.safe_load((folder / "truth.yaml").read_text(encoding="utf-8"))
    weak["actuator_stiffness"] = (TRUTH / 3.0).tolist()
    (folder / "weak.yaml").write_text(yaml.safe_dump(weak), encoding="utf-8")
    given = (folder / "config.yaml", folder / "commands.csv", "--model", folder / "weak.yaml")
    assert call("simulate", *given, "--out", folder / "weak.csv") == 0
    checked = (folder / "identified" / "model.yaml", folder / "weak.csv", "--config", folder / "config.yaml")
    assert call("verify", *checked, "--out", folder / "failed") == 3  # a certificate that says fail was made
    found = json.loads((folder / "failed" / "verification.json").read_text(encoding="utf-8"))
    assert (found["verdict"], found["model_test"]["consistent"]) == ("fail", False)
    assert "Certificate of verification" in (folder / "failed" / "report.html").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_page_of_an_arm_shows_what_its_commands_print(tmp_path: Path) -> None:
    tutorial = loaded("tutorial")
    steps = list(tutorial.follow(tutorial.PAGE.with_stem("arms-walk").read_text(encoding="utf-8"), tmp_path))
    assert len(steps) == 9
    for step in steps:
        assert NUMBER.sub("#", step.printed) == NUMBER.sub("#", step.shown), step.command
    assert "verdict: pass" in steps[-1].printed

"""`expdesign next`."""

import json
from pathlib import Path

import numpy as np
import pandas as pd

from expdesign.assurance.acceptance.budget import Contribution, UncertaintyBudget
from expdesign.assurance.acceptance.decision import Basis, Decision
from expdesign.estimation.coverage import STANDARD
from expdesign.estimation.goodness import StatementOfFit
from expdesign.report.plan_results import NextResult
from tests.commands.calls import CONFIG, ROBOT, Printed, call, plan_file, recordings_file


def forecast(text: str) -> list[float]:
    """The totals that are announced, now and with every further measurement."""
    return [
        float(line.split(": ")[1].split()[0])
        for line in text.splitlines()
        if line.endswith("tolerances") and ": " in line
    ]


def test_the_plan_goes_on_where_the_recordings_end(tmp_path: Path, capsys: Printed) -> None:
    recordings, out = recordings_file(tmp_path), tmp_path / "next.csv"
    capsys.readouterr()
    assert call("next", CONFIG, recordings, "--out", out, "--count", 2) == 0
    printed, notes = capsys.readouterr()
    assert "kept but not used: note" in notes
    plan = pd.read_csv(out)
    assert plan["sequence"].tolist() == [5, 6]
    assert plan["series"].tolist() == [4, 5]
    now, one, two = forecast(printed)
    assert two < one < now
    assert "expected to pass" in printed
    both = tmp_path / "both.csv"
    pd.concat([pd.read_csv(plan_file(tmp_path)).drop(columns="note"), plan]).to_csv(both, index=False)
    assert call("evaluate", CONFIG, both, "--json") == 0
    np.testing.assert_allclose(json.loads(capsys.readouterr().out)["total"], two, rtol=1e-3)


def test_of_recordings_that_refute_the_model_nothing_is_enough() -> None:
    """Errors that are expected hold for a model that is right."""
    totals, one = np.array([0.1, 0.09]), np.ones((1, 1))
    budget = UncertaintyBudget((Contribution("noise", 0.1 * one),), one, ("dx_m",), STANDARD, 3)
    for chi2, enough in ((40.0, True), (4000.0, False)):
        fit, decisions = StatementOfFit.of_chi2(chi2, 40), [Decision(budget, Basis.PLAN)] * 2
        found = NextResult(pd.DataFrame(), None, totals[0], totals[1:], fit, None, tuple(decisions))  # type: ignore[arg-type]
        lines = found.lines
        assert any("No further measurement is needed" in line for line in lines) == enough
        assert any("assumes that the base model is right" in line for line in lines) != enough


def test_it_stops_at_the_accuracy(tmp_path: Path, capsys: Printed) -> None:
    recordings, out = recordings_file(tmp_path), tmp_path / "next.csv"
    capsys.readouterr()
    for accuracy, enough in ((0.9, True), (0.01, False)):
        assert call("next", CONFIG, recordings, "--out", out, "--accuracy", accuracy, "--count", 1) == 0
        printed = capsys.readouterr().out
        assert (forecast(printed)[-1] <= accuracy) == enough
        assert ("not enough for" in printed) != enough


def test_nothing_is_decided_where_recordings_are_to_be_read_otherwise(tmp_path: Path, capsys: Printed) -> None:
    recordings = recordings_file(tmp_path)
    frame = pd.read_csv(recordings)
    frame.rename(columns={"x_m": "y_m", "y_m": "x_m"}).to_csv(recordings, index=False)
    capsys.readouterr()
    assert call("next", CONFIG, recordings, "--out", tmp_path / "next.csv") == 0
    printed = capsys.readouterr().out
    assert "Acceptance is not decided: the recordings fit only if they are read otherwise" in printed
    assert "expected to pass" not in printed
    assert call("identify", ROBOT, recordings, "--targets", CONFIG, "--out", tmp_path / "identified") == 3
    assert "Acceptance is not decided: the recordings fit only if" in capsys.readouterr().out

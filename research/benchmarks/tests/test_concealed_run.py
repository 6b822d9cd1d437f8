"""The proof's command, with a stand-in for the program: separate processes that see two files and no truth."""

from __future__ import annotations

import shlex
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("exudyn", reason="the virtual laboratory needs the engine exudyn")
from research.benchmarks.concealed.case import generate
from research.benchmarks.concealed.cases import draw_case, orders
from research.benchmarks.concealed.pipeline import examine
from research.benchmarks.concealed.program import Program

ROOT = Path(__file__).parents[3]
STAND_IN = """
import json, os, pathlib, sys
import pandas as pd
if sys.argv[1] == "diagnose":
    assert sys.argv[2:5] == ["robot.yaml", "recordings.csv", "--out"]
    out = pathlib.Path(sys.argv[5])
    whole = sorted(str(path) for path in out.parents[1].rglob("*") if "truth" in path.name or "later" in path.name)
    if "FAIL" in os.environ:
        sys.exit("no such thing\\ncannot read it")
    fit = dict.fromkeys(["noise_rms", "train_before", "train_after", "test_before", "test_after"], 1.0)
    seen = {"here": sorted(os.listdir()), "truths": whole}
    answer = {"verdict": "consistent", "effects": [], "location": None, "fit": fit, "seen": seen}
    (out / "diagnosis.json").write_text(json.dumps(answer))
    (out / "model.yaml").write_text("model")
else:
    points = pd.read_csv(sys.argv[3])
    assert not [name for name in points if name.startswith(("d", "s")) and name.endswith(("_m", "_rad"))]
    for name in ("x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad"):
        points["d" + name] = 0.0
    points.to_csv(sys.argv[5], index=False)
"""


@pytest.fixture
def stand_in(tmp_path):
    path = tmp_path / "stand_in.py"
    path.write_text(STAND_IN, encoding="utf-8")
    return [sys.executable, str(path)]


def examined(command, folder, count=2):
    cases = list(generate(draw_case, orders(count, 21, ["none"]), 21))
    program = Program(command, folder)
    return cases, program, examine(program, cases, jobs=2)


def test_a_diagnosis_sees_two_files_and_no_truth(stand_in, tmp_path):
    cases, program, judged = examined(stand_in, tmp_path / "proof")
    import json  # noqa: PLC0415

    for case in cases:
        seen = json.loads((program.answers(case.name) / "diagnosis.json").read_text())["seen"]
        assert seen == {"here": ["recordings.csv", "robot.yaml"], "truths": []}
    assert [case.faults() for case in judged] == [[], []]
    assert all(case.outcome.wall_s > 0 for case in judged)
    assert program.repeatable(cases) == 2


def test_the_judges_own_series_measure_the_model(stand_in, tmp_path):
    """Without effect the base model is at the noise floor; a model that predicts nothing is at the signal."""
    cases, _, judged = examined(stand_in, tmp_path / "proof")
    for case, found in zip(cases, judged, strict=True):
        names = [name for name in case.later if name.startswith("d") and name.endswith(("_m", "_rad"))]
        whitened = np.concatenate([case.later[name] / case.later["s" + name[1:]] for name in names])
        noise = case.truth["later_noise_rms"]
        assert found.predicted.model_read == pytest.approx(np.sqrt(np.mean(whitened**2)), rel=1e-9)
        assert found.predicted.base_read == pytest.approx(noise, rel=0.05)
        assert noise == pytest.approx(1.0, abs=5 / np.sqrt(2 * whitened.size))


def test_a_program_that_fails_has_no_answer(stand_in, tmp_path, monkeypatch):
    monkeypatch.setenv("FAIL", "1")
    _, _, judged = examined(stand_in, tmp_path / "proof", count=1)
    assert judged[0].answer is None
    assert judged[0].faults() == ["exit 1: cannot read it"]


def test_the_command_writes_table_and_truths_afterwards(stand_in, tmp_path):
    call = [sys.executable, "-m", "research.benchmarks.concealed.run", "--count", "3", "--seed", "9", "--only", "none"]
    call += ["--only", "thermal_drift", "--again", "1", "--keep", str(tmp_path / "kept")]
    call += ["--results", str(tmp_path / "results"), "--command", shlex.join(stand_in)]
    done = subprocess.run(call, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    (table,) = (tmp_path / "results").glob("*-9-development.md")
    text = table.read_text(encoding="utf-8")
    assert "seed 9 (given), only none, thermal_drift" in text
    assert "same diagnosis.json: 1 of 1" in text
    assert "not detected" in text
    assert len(list((tmp_path / "results").glob("*.csv"))) == 1
    assert len(list((tmp_path / "kept" / "truth").glob("case-*/truth.yaml"))) == 3
    again = subprocess.run([*call, "--limit", "2"], cwd=ROOT, capture_output=True, text=True, check=False)
    assert "2 cases:" in again.stdout  # judged again from what was kept

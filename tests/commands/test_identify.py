"""`expdesign identify`."""

import json
from pathlib import Path

import numpy as np
import pandas as pd

from tests.commands.calls import ROBOT, Printed, call, recordings_file


def test_it_writes_model_record_and_report(tmp_path: Path, capsys: Printed) -> None:
    recordings, out = recordings_file(tmp_path), tmp_path / "out"
    capsys.readouterr()
    assert call("identify", ROBOT, recordings, "--out", out) == 0
    printed = capsys.readouterr()
    assert printed.out.splitlines()[-1] == str(out / "report.html")
    assert "leg 6 " in printed.out
    assert "Chi2" in printed.out
    assert "columns without a meaning here, kept but not used: note" in printed.err
    names = [".expdesign.json", "identification.json", "model.yaml", "report.html"]
    assert sorted(path.name for path in out.iterdir()) == names
    report = (out / "report.html").read_text(encoding="utf-8")
    assert "Stiffness of hexapod-h1" in report
    assert "http://" not in report.split("<script")[0]


def test_several_files_are_one(tmp_path: Path) -> None:
    recordings = recordings_file(tmp_path)
    frame = pd.read_csv(recordings)
    first, second = tmp_path / "a.csv", tmp_path / "b.csv"
    frame.iloc[:2].to_csv(first, index=False)
    frame.iloc[2:].to_csv(second, index=False)
    assert call("identify", ROBOT, recordings, "--out", tmp_path / "whole") == 0
    assert call("identify", ROBOT, first, second, "--out", tmp_path / "split") == 0
    records = [
        json.loads((tmp_path / name / "identification.json").read_text(encoding="utf-8")) for name in ("whole", "split")
    ]
    np.testing.assert_allclose(records[0]["covariance"], records[1]["covariance"], rtol=1e-9)
    np.testing.assert_allclose(records[0]["chi2"], records[1]["chi2"], rtol=1e-9)


def test_options_reach_the_estimator(tmp_path: Path) -> None:
    recordings = recordings_file(tmp_path)

    def record(*options: object) -> dict:  # type: ignore[type-arg]
        assert call("identify", ROBOT, recordings, "--out", tmp_path / "out", *options) == 0
        content: dict = json.loads((tmp_path / "out" / "identification.json").read_text(encoding="utf-8"))  # type: ignore[type-arg]
        return content

    plain, shared, prior = record(), record("--shared-reference"), record("--prior", 1)
    assert shared["shared_reference"]
    assert shared["chi2"] != plain["chi2"]
    # A prior takes over part of what the readings had to determine.
    assert plain["dof"] < prior["dof"] < plain["dof"] + 6
    assert prior["covariance"][0][0] < plain["covariance"][0][0]

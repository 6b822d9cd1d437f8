"""`expdesign identify`."""

import json
from pathlib import Path

import pytest

import expdesign as xd
from tests.commands.calls import ROBOT, Printed, call, recordings_file


def test_it_writes_model_record_and_report(tmp_path: Path, capsys: Printed) -> None:
    """Recordings in two files are those in one."""
    recordings, out = recordings_file(tmp_path), tmp_path / "out"
    whole = recordings.read_text(encoding="utf-8").splitlines(keepends=True)
    parts = [tmp_path / "first.csv", tmp_path / "second.csv"]
    for path, lines in zip(parts, (whole[:3], [whole[0], *whole[3:]]), strict=True):
        path.write_text("".join(lines), encoding="utf-8")
    capsys.readouterr()
    assert call("identify", ROBOT, *parts, "--out", out) == 0
    record = json.loads((out / "identification.json").read_text(encoding="utf-8"))
    assert record["chi2"] == pytest.approx(xd.identify(ROBOT, recordings).record["chi2"])
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

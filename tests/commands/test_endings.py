"""How a command ends: the status that a script reads, outputs that cannot take a text, and signals."""

import io
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest

import expdesign as xd
from expdesign.app.commands.terminal import encode_anything
from tests.commands.calls import CONFIG, ROBOT, Printed, call, config_file, plan_file, refused

COMMAND = [sys.executable, "-m", "expdesign"]


def printed(patch: pytest.MonkeyPatch, encoding: str, *arguments: object) -> tuple[int, str, str]:
    """Exit status, standard output and standard error of a call whose streams have an encoding."""
    streams = [io.TextIOWrapper(io.BytesIO(), encoding=encoding) for _ in range(2)]
    with patch.context() as here:
        for name, stream in zip(("stdout", "stderr"), streams, strict=True):
            here.setattr(sys, name, stream)
        status = call(*arguments)
    for stream in streams:
        stream.seek(0)
    return status, streams[0].read(), streams[1].read()


@pytest.mark.parametrize("encoding", ["cp1252", "ascii"])
def test_an_output_that_does_not_know_every_character(encoding: str, monkeypatch: pytest.MonkeyPatch) -> None:
    status, out, error = printed(monkeypatch, encoding, "check", ROBOT)
    assert (status, error) == (0, "")
    assert "leg 1" in out


def test_a_minus_stays_a_minus(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    path = tmp_path / "out.txt"
    with path.open("w", encoding="ascii") as stream:
        monkeypatch.setattr(sys, "stdout", stream)
        encode_anything()
        print("\u22123.1 \u00b5m \u2264 \u03c7\u00b2, r\u00f6bot \u30ed")
    assert path.read_text(encoding="ascii") == "-3.1 um <= chi2, robot ?\n"


def test_a_name_does_not_steer_a_terminal(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Escape sequences and the mark that turns the direction of writing, in the name of a robot."""
    text = re.sub(r"name: .*", r'name: "st\\u202eage\\x1b[31m"', ROBOT.read_text(encoding="utf-8"), count=1)
    (tmp_path / "robot.yaml").write_text(text, encoding="utf-8")
    status, out, error = printed(monkeypatch, "utf-8", "check", tmp_path / "robot.yaml")
    assert status == 0
    assert "st\ufffdage\ufffd[31m" in out
    assert not {"\x1b", "\u202e"} & set(out + error)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no full device on this system")
def test_standard_output_is_full() -> None:
    """In a process of its own, which has to end without a word more."""
    environment = os.environ | {"PYTHONUNBUFFERED": "1"}
    with Path("/dev/full").open("wb") as full:
        done = subprocess.run([*COMMAND, "--help"], stdout=full, stderr=subprocess.PIPE, env=environment, check=False)
    (message,) = done.stderr.decode().splitlines()
    assert done.returncode == 2
    assert message.startswith("expdesign: standard output cannot be written (No space left on device).")


def test_standard_output_is_full_for_a_command(capsys: Printed, monkeypatch: pytest.MonkeyPatch) -> None:
    if not Path("/dev/full").exists():
        pytest.skip("no full device on this system")
    with Path("/dev/full").open("w", encoding="utf-8") as full:
        monkeypatch.setattr(sys, "stdout", full)
        assert refused(capsys, "check", ROBOT).startswith("expdesign: standard output cannot be written (No space left")


def test_sigterm_is_an_interruption(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Printed) -> None:
    monkeypatch.setattr(xd, "simulate", lambda *args, **options: signal.raise_signal(signal.SIGTERM))
    assert call("simulate", CONFIG, plan_file(tmp_path), "--out", tmp_path / "rows.csv") == 130
    assert capsys.readouterr().err == "expdesign: interrupted. Nothing was written.\n"


def test_check_where_no_pose_can_be_reached(tmp_path: Path, capsys: Printed) -> None:
    far = {f"{axis}_m": [-3.0, 3.0] for axis in "xyz"}
    path = config_file(tmp_path, {"experiment.poses": {"bounds": far}})
    assert call("check", path) == 3
    assert "0 % of the poses can be reached" in capsys.readouterr().out
    assert call("check", CONFIG) == 0


def test_strict_refuses_what_is_doubtful(tmp_path: Path, capsys: Printed) -> None:
    text = ROBOT.read_text(encoding="utf-8").replace("leg_length: [0.25,", "leg_length: [0.35,")
    path = tmp_path / "robot.yaml"
    path.write_text(text, encoding="utf-8")
    assert call("check", path) == 0
    assert call("check", path, "--strict") == 3
    assert "at the reference pose" in capsys.readouterr().err
    assert call("check", ROBOT, "--strict") == 0


def test_identify_of_swapped_columns(tmp_path: Path, capsys: Printed) -> None:
    rows, swapped = tmp_path / "rows.csv", tmp_path / "swapped.csv"
    assert call("simulate", CONFIG, plan_file(tmp_path), "--out", rows) == 0
    frame = pd.read_csv(rows)
    frame.rename(columns={"dx_m": "dz_m", "dz_m": "dx_m"}).to_csv(swapped, index=False)
    assert call("identify", ROBOT, rows, "--out", tmp_path / "right") == 0
    assert call("identify", ROBOT, swapped, "--out", tmp_path / "wrong") == 3
    assert "swapped?" in capsys.readouterr().err
    assert (tmp_path / "wrong" / "model.yaml").is_file()

"""No command replaces what was written for another purpose, by somebody, or is one of its inputs."""

import json
import os
import stat
from pathlib import Path

import pandas as pd
import pytest
from openpyxl import load_workbook

import expdesign as xd
from expdesign.errors import InputError
from expdesign.io.written import RECORD
from tests.commands.calls import CONFIG, ROBOT, Printed, call, model_file, plan_file, refusal

BIPOD = CONFIG.parent / "bipod.yaml"
OTHERS = "this was measured for a week\n"

# What every command with `--out` gets, and a file that it would write there ('' where --out is the file).
WRITERS: dict[str, tuple[list[object], str]] = {
    "run": ([BIPOD], "plan.csv"),
    "compare": ([BIPOD], "comparison.csv"),
    "montecarlo": ([CONFIG, "plan.csv"], "montecarlo.json"),
    "sheet": ([CONFIG, "plan.csv"], "sheet.csv"),
    "simulate": ([CONFIG, "plan.csv"], ""),
    "identify": ([ROBOT, "recordings.csv"], "model.yaml"),
    "diagnose": ([ROBOT, "recordings.csv"], "model.yaml"),
    "predict": (["model.yaml", "plan.csv"], ""),
    "compensate": (["model.yaml", "plan.csv"], ""),
    "verify": (["model.yaml", "plan.csv"], "verification.json"),
    "table": (["model.yaml", "--over", "x_mm=-1:1"], "correction.c"),
    "next": ([CONFIG, "recordings.csv"], ""),
    "register": ([ROBOT, "plan.csv", "points.txt"], ""),
    "correct": ([ROBOT, "poses.csv"], ""),
    "sweep": ([BIPOD.parent / "sweep-bipod.yaml"], "sweep.csv"),
    "check": ([ROBOT], "report.html"),
    "new": (["bipod"], "robot.yaml"),
}


@pytest.mark.parametrize("name", WRITERS)
def test_what_others_wrote_stays(name: str, tmp_path: Path, capsys: Printed, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is said before the work: the inputs need not even be there."""
    monkeypatch.chdir(tmp_path)
    arguments, inner = WRITERS[name]
    out = tmp_path / "out"
    file = out / inner if inner else out
    file.parent.mkdir(exist_ok=True)
    file.write_text(OTHERS)
    said = refusal(capsys, name, *arguments, "--out", out)
    assert f"{file}: this file is there already. Nothing was written." in said
    assert "--force" in said
    assert file.read_text() == OTHERS
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out"]


def test_the_same_command_replaces_what_it_wrote(tmp_path: Path, capsys: Printed) -> None:
    plan, out = plan_file(tmp_path), tmp_path / "rows.csv"
    assert call("simulate", CONFIG, plan, "--out", out) == 0
    first = out.read_text()
    assert call("simulate", CONFIG, plan, "--out", out, "--seed", 2) == 0
    assert out.read_text() != first
    plan.write_text("\n".join(plan.read_text().splitlines()[:-1]))  # the inputs may change, their paths not
    assert call("simulate", CONFIG, plan, "--out", out) == 0
    assert len(pd.read_csv(out)) == 3
    other = tmp_path / "other.csv"
    other.write_text(plan.read_text())
    capsys.readouterr()
    assert "already, written by `expdesign simulate` from" in refusal(capsys, "simulate", CONFIG, other, "--out", out)
    assert len(pd.read_csv(out)) == 3
    assert call("simulate", CONFIG, other, "--out", out, "--force") == 0


def test_what_moved_with_its_plan_is_known_again(tmp_path: Path) -> None:
    first = tmp_path / "first"
    first.mkdir()
    plan = plan_file(first)
    assert call("simulate", CONFIG, plan, "--out", first / "out" / "rows.csv") == 0
    first.rename(tmp_path / "second")  # with its plan
    assert call("simulate", CONFIG, tmp_path / "second" / "plan.csv", "--out", tmp_path / "second/out/rows.csv") == 0


def test_a_file_into_which_somebody_wrote(tmp_path: Path, capsys: Printed) -> None:
    plan, out = plan_file(tmp_path), tmp_path / "rows.csv"
    assert call("simulate", CONFIG, plan, "--out", out) == 0
    out.write_text(out.read_text().replace("first", "read again by hand"))
    assert "changed since `expdesign simulate` wrote it. Nothing was written." in refusal(
        capsys, "simulate", CONFIG, plan, "--out", out
    )
    assert "read again by hand" in out.read_text()


@pytest.mark.parametrize(("form", "value"), [("sheet.xlsx", ""), ("sheet.csv", "0.08859"), ("sheet.csv", "0,08859")])
def test_a_filled_sheet_is_never_replaced(form: str, value: str, tmp_path: Path, capsys: Printed) -> None:
    plan, out = plan_file(tmp_path), tmp_path / "sheet"
    assert call("sheet", CONFIG, plan, "--out", out) == 0
    assert call("sheet", CONFIG, plan, "--out", out) == 0  # nothing was read yet
    path = out / form
    if form.endswith("xlsx"):
        book = load_workbook(path)
        sheet = book.worksheets[0]
        column = [str(cell.value).startswith("reading_") for cell in sheet[1]].index(True) + 1
        sheet.cell(row=2, column=column, value=0.08859)
        book.save(path)
    else:
        frame = pd.read_csv(path, dtype=str, keep_default_na=False)
        frame.loc[0, "reading_z_m"] = value
        frame.to_csv(path, index=False)
        path.write_text(path.read_text().replace(f'"{value}"', value))  # a row with too many cells, by hand
    filled = path.read_bytes()
    (out / RECORD).unlink()  # as after a copy of the file
    for command in (("sheet", CONFIG, plan, "--out", out), ("simulate", CONFIG, plan, "--out", path)):
        for options in ((), ("--force",)):
            said = refusal(capsys, *command, *options)
            assert "laboratory sheet with readings in it, which is never replaced" in said or not options
    assert path.read_bytes() == filled


def test_an_input_is_never_replaced(tmp_path: Path, capsys: Printed) -> None:
    model, targets = model_file(tmp_path), plan_file(tmp_path)
    (tmp_path / "link.csv").symlink_to(targets)
    before = targets.read_bytes()
    for out in (targets, tmp_path / "link.csv"):
        assert "this is an input of `compensate`. Nothing was written." in refusal(
            capsys, "compensate", model, targets, "--out", out, "--force"
        )
    assert targets.read_bytes() == before


def test_a_device_and_a_pipe_are_written_to(tmp_path: Path) -> None:
    plan = plan_file(tmp_path)
    assert call("simulate", CONFIG, plan, "--out", "/dev/null") == 0
    assert stat.S_ISCHR(Path("/dev/null").stat().st_mode)
    (tmp_path / "nowhere").symlink_to("/dev/null")
    assert call("simulate", CONFIG, plan, "--out", tmp_path / "nowhere") == 0
    assert (tmp_path / "nowhere").is_symlink()
    assert stat.S_ISCHR(Path("/dev/null").stat().st_mode)
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    try:
        assert call("simulate", CONFIG, plan, "--out", pipe) == 0
        assert os.read(reader, 20).startswith(b"sequence,series")
    finally:
        os.close(reader)
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    assert not (tmp_path / RECORD).exists()


def test_what_a_link_points_to_is_replaced(tmp_path: Path) -> None:
    plan, real = plan_file(tmp_path), tmp_path / "real.csv"
    (tmp_path / "link.csv").symlink_to(real)
    for _ in range(2):
        assert call("simulate", CONFIG, plan, "--out", tmp_path / "link.csv") == 0
    assert (tmp_path / "link.csv").is_symlink()
    assert len(pd.read_csv(real)) == 4


def test_in_python(tmp_path: Path) -> None:
    simulated = xd.simulate(CONFIG, plan_file(tmp_path))
    out = tmp_path / "rows.csv"
    out.write_text(OTHERS)
    with pytest.raises(InputError, match=r"this file is there already.*force=True"):
        simulated.save(out)
    simulated.save(out, force=True)
    assert call("simulate", CONFIG, tmp_path / "plan.csv", "--out", out) == 0  # the same purpose
    assert json.loads((tmp_path / RECORD).read_text())["rows.csv"]["command"] == "simulate"
    frame = simulated.frame
    found = xd.identify(ROBOT, frame)
    found.save(tmp_path / "identified")
    found.save(tmp_path / "identified")
    with pytest.raises(InputError, match="written by `expdesign identify`"):
        xd.identify(ROBOT, frame[frame["sequence"] != 4]).save(tmp_path / "identified")

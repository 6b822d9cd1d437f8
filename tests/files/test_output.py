"""Nobody meets a half-written result."""

import os
from pathlib import Path

import pytest

from expdesign.errors import InputError
from expdesign.io.output import json_text, output_folder, require_writable, write_file


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_a_folder_appears_whole(tmp_path: Path) -> None:
    target = tmp_path / "results" / "run"
    with output_folder(target) as scratch:
        (scratch / "a.csv").write_text("1")
        assert not target.exists()
        assert scratch.parent == target.parent
    assert names(target) == ["a.csv"]
    assert names(target.parent) == ["run"]
    assert target.stat().st_mode & 0o777 == 0o755


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt, InputError])
@pytest.mark.parametrize("existing", [True, False])
def test_a_failure_leaves_the_folder_as_it_was(tmp_path: Path, existing: bool, error: type[BaseException]) -> None:
    target = tmp_path / "run"
    if existing:
        target.mkdir()
        (target / "a.csv").write_text("old")

    def write() -> None:
        with output_folder(target) as scratch:
            (scratch / "a.csv").write_text("new")
            raise error("stop")

    with pytest.raises(error, match="stop"):
        write()
    assert names(tmp_path) == (["run"] if existing else [])
    if existing:
        assert (target / "a.csv").read_text() == "old"


def test_files_of_other_names_stay(tmp_path: Path) -> None:
    target = tmp_path / "run"
    target.mkdir()
    (target / "a.csv").write_text("old")
    (target / "mine.txt").write_text("mine")
    with output_folder(target) as scratch:
        (scratch / "a.csv").write_text("new")
        (scratch / "b.csv").write_text("b")
    assert names(target) == ["a.csv", "b.csv", "mine.txt"]
    assert (target / "a.csv").read_text() == "new"
    assert names(tmp_path) == ["run"]


def test_a_file_is_written_in_one_step(tmp_path: Path) -> None:
    target = tmp_path / "deep" / "plan.csv"
    write_file(target, "a\n")
    write_file(target, "µ\n")
    assert target.read_bytes() == "µ\n".encode()
    assert names(target.parent) == ["plan.csv"]
    with pytest.raises(InputError, match="cannot be written"):
        write_file(target / "below.csv", "x")
    with pytest.raises(InputError, match="this is a folder"):
        write_file(target.parent, "x")
    assert names(tmp_path) == ["deep"]
    assert names(target.parent) == ["plan.csv"]


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_json_has_no_nan(value: float) -> None:
    assert json_text({"a": None}) == '{\n  "a": null\n}\n'
    with pytest.raises(ValueError, match="JSON"):
        json_text({"a": value})


def test_what_a_killed_process_left_is_removed(tmp_path: Path) -> None:
    left, young, other = (tmp_path / name for name in (".run-1.expdesign", ".run-2.expdesign", ".run-backup"))
    for folder in (left, young, other):
        folder.mkdir()
    os.utime(left, (0, 0))
    with output_folder(tmp_path / "run") as scratch:
        write_file(tmp_path / "run.csv", "1")
        with output_folder(tmp_path / "run") as second:  # a process that works is left alone
            (second / "b.csv").write_text("1")
        assert scratch.exists()
    assert names(tmp_path) == [".run-2.expdesign", ".run-backup", "run", "run.csv"]


def test_links_that_lead_to_themselves(tmp_path: Path) -> None:
    loop = tmp_path / "loop"
    loop.symlink_to(loop)
    with pytest.raises(InputError, match="is a link that leads to itself"):
        write_file(loop, "1")
    with pytest.raises(InputError, match="is a link that leads to itself"):
        require_writable(loop)


def test_a_message_names_the_place_and_not_the_scratch_folder(tmp_path: Path) -> None:
    def write() -> None:
        with output_folder(tmp_path / "run") as scratch:
            (scratch / "a.csv").mkdir()
            write_file(scratch / "a.csv", "1")

    with pytest.raises(InputError) as caught:
        write()
    assert caught.value.where == str(tmp_path / "run" / "a.csv")

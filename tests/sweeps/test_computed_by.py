"""A run is identified by what computes it: the code that decides about numbers, and the libraries, not the version."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest

import expdesign as xd
from expdesign.app.sweeps.runs import ROOT, code_digest, computed_by, modules
from tests.sweeps.small import sweep_file

VARY = {"experiment.measurements": [1, 2]}


@pytest.fixture
def copied(tmp_path: Path) -> Path:
    """The package, to be changed."""
    ignored = shutil.ignore_patterns("__pycache__")
    return Path(shutil.copytree(ROOT, tmp_path / "expdesign", ignore=ignored))


def change(package: Path, name: str, before: str, after: str) -> None:
    """Another text in one file."""
    file = package / name
    text = file.read_text(encoding="utf-8")
    assert before in text
    file.write_text(text.replace(before, after, 1), encoding="utf-8")


def test_the_modules_that_numbers_come_from() -> None:
    """Those that search and judge, and those that are found by their place; none that draws or diagnoses."""
    found = set(modules())
    assert found >= {
        "planning/search.py", "planning/optimality/certificate.py", "mechanics/elastostatics/measurements.py",
        "planning/criteria/accuracy.py", "mechanics/robots/hexapod.py", "mechanics/loads/errors/source.py",
        "chain/effect.py", "coordinates.py",
    }  # fmt: skip
    folders = {part for name in found for part in name.split("/")[:2]}
    assert not folders & {"commands", "diagnosis", "report", "sweeps", "templates", "comparison"}


def test_whatever_a_run_imports_counts() -> None:
    """What `run` loads of the package counts, but for what only says, draws or carries."""
    code = "import sys, expdesign.app.api.run; print(*(m for m in sys.modules if m.startswith('expdesign.')))"
    loaded = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout.split()
    paths = {"/".join(name.split(".")[1:]) for name in loaded}
    silent = ("app", "assurance/plausibility", "report")
    counted = {name.removesuffix(".py").removesuffix("/__init__") for name in modules()}
    assert {path for path in paths if not path.startswith(silent)} <= counted | {"assurance"}


@pytest.mark.parametrize(
    ("name", "before", "after"),
    [
        ("planning/search.py", "MOST_GENERATIONS = 2000", "MOST_GENERATIONS = 2001"),
        ("planning/criteria/accuracy.py", "class ", "ADDED = 1\n\n\nclass "),
        ("app/api/run.py", "seconds: Seconds = None", "seconds: Seconds = 1.0"),
    ],
)
def test_code_that_decides_about_numbers_counts(copied: Path, name: str, before: str, after: str) -> None:
    change(copied, name, before, after)
    assert code_digest(copied) != computed_by()["code"]


def test_a_criterion_of_one_s_own_counts(copied: Path) -> None:
    shutil.copy(copied / "planning/criteria/observability.py", copied / "planning/criteria/o6.py")
    assert code_digest(copied) != computed_by()["code"]


def test_reports_and_the_version_s_number_do_not_count(copied: Path) -> None:
    for name, before, after in (
        ("__init__.py", '__version__ = "', '__version__ = "9'),
        ("report/page.py", "_FOLDER = ", "OTHER = "),
        ("app/commands/new.py", '"""', '"""Other words. '),
    ):
        change(copied, name, before, after)
    assert code_digest(copied) == computed_by()["code"]


def test_runs_of_other_code_are_done_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file, out = sweep_file(tmp_path, vary=VARY), tmp_path / "out"
    first = xd.sweep(file, out).table
    for folder in first["folder"]:
        assert json.loads((out / folder / "computed_by.json").read_text(encoding="utf-8")) == computed_by()
    counts: list[int] = []
    xd.sweep(file, out, callback=lambda title, done, total, note: counts.append(done))
    assert counts == [2]  # both were done before
    monkeypatch.setattr("expdesign.app.sweeps.runs.computed_by", lambda: computed_by() | {"numpy": "0.1"})
    again = xd.sweep(file, out).table
    assert not set(again["folder"]) & set(first["folder"])
    pd.testing.assert_frame_equal(again.drop(columns="folder"), first.drop(columns="folder"))

"""Where the results of a sweep are kept: one folder per run, named by the run's identity, and `sweep.csv` over all.

A run's folder appears at once and complete, or not at all, so that its being there is the record that the run is
finished. Times depend on the machine and lie apart in `times.csv`; all else is the same bytes wherever it was computed.

What computed a result: the code that decides about the numbers, and the libraries that they depend on.

The number of a version says neither what a checkout with changes computed, nor that two versions compute the same. So
what the rooms do from which a run's numbers come is digested: their syntax trees without documentation, so that
comments, sentences in docstrings and layout do not count. Rooms that only draw or write (`report`) are not among them.
"""

import ast
import csv
import fcntl
import hashlib
import json
import shutil
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import pandas as pd

from expdesign.app.sweeps.runs import SweepRun, text_of
from expdesign.errors import InputError
from expdesign.io.output import csv_text, output_folder, write_file
from expdesign.plugins import extensions

LIBRARIES = ("autograd", "casadi", "moocore", "numpy", "pandas", "pymoo", "scipy")
"""On whose versions the numbers depend."""
ROOT = Path(__file__).parents[2]
_DECIDE = (
    "*.py", "io/**/*.py", "mechanics/**/*.py", "chain/**/*.py", "estimation/**/*.py", "planning/**/*.py",
    "assurance/acceptance/*.py", "assurance/model_error/*.py", "app/api/run.py",
)  # fmt: skip
"""Modules whose code decides about the numbers of a run; others say, draw, judge recordings or carry them."""


@lru_cache(maxsize=1)
def computed_by() -> dict[str, str]:
    """Digest of the code (`code`), and versions of Python, the libraries and installed extensions, by their names."""
    found = {"code": code_digest(), "python": ".".join(map(str, sys.version_info[:2]))}
    for name in LIBRARIES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    return found | extensions()


def computed_by_text() -> str:
    """`computed_by` as one line, which is part of the identity of a run."""
    return json.dumps(computed_by(), sort_keys=True, separators=(",", ":"))


def code_digest(root: Path = ROOT) -> str:
    """Digest of the modules below `root` (the package's folder) from which the numbers of a run come."""
    digest = hashlib.sha256()
    for name in modules(root):
        tree = ast.parse((root / name).read_text(encoding="utf-8"))
        digest.update(f"{name}\n{ast.dump(_without_documentation(tree))}\n".encode())
    return digest.hexdigest()[:16]


def modules(root: Path = ROOT) -> list[str]:
    """Paths of these modules below `root`; the package's own file has no more than its version and names."""
    files = {file.relative_to(root).as_posix() for pattern in _DECIDE for file in root.glob(pattern)}
    return sorted(files - {"__init__.py", "__main__.py"})


def _without_documentation(tree: ast.Module) -> ast.Module:
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            node.body = [part for part in node.body if not _is_text(part)]
    return tree


def _is_text(node: ast.stmt) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)


RUNS, TABLE, TIMES, LOCK = "runs", "sweep.csv", "times.csv", ".lock"
FAILURE = "failure.json"
"""In the folder of a run that has no result: why."""
_RECORD = "run.json"
_SUMMARY = ("designs", "evaluations", "hypervolume", "duir_lower_bound", "total_lower_bound")
_INTERVAL = 2.0
"""s between tables that are written on the way."""


@contextmanager
def sole_writer(folder: Path) -> Iterator[None]:
    """The right to write a sweep's folder; what a sweep that was killed left half-written is removed.

    Raises:
        InputError: another sweep is writing there, or the folder cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock = (folder / LOCK).open("w")
    except OSError as error:
        raise InputError(f"cannot be written ({error.strerror})", where=str(folder), remedy="Name another.") from None
    with lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)  # released with the process, however it ends
        except OSError:
            remedy = "Wait for it, or name another folder."
            raise InputError("another sweep is writing here", where=str(folder), remedy=remedy) from None
        for scratch in [*folder.glob(f"{RUNS}/.*"), *folder.glob(f".{TABLE}-*"), *folder.glob(f".{TIMES}-*")]:
            shutil.rmtree(scratch) if scratch.is_dir() else scratch.unlink()
        yield


class Store:
    """Results of the runs of one sweep in a folder.

    Args:
        folder: of the sweep.
        runs: all its runs.

    Raises:
        InputError: the folder cannot be written.
    """

    def __init__(self, folder: Path, runs: list[SweepRun]) -> None:
        self.folder = folder
        self.runs = runs
        self._rows = {run.identity: self._row(run.identity) for run in runs}
        self._seconds = self._known_times()
        self._written = -_INTERVAL

    def waiting(self) -> list[SweepRun]:
        """The runs that are not finished, one of each identity."""
        return list({run.identity: run for run in self.runs if self._rows[run.identity] is None}.values())

    def count(self, status: str | None = None) -> int:
        """How many runs are finished, or have a status (`finished`, `failed`)."""
        rows = [self._rows[run.identity] for run in self.runs]
        return sum(row is not None and (status is None or row["status"] == status) for row in rows)

    def put(self, run: SweepRun, files: Mapping[str, str], seconds: float) -> None:
        """Keep the results of a run, and bring the table up to date now and then."""
        with output_folder(self.folder / RUNS / run.identity) as scratch:
            for name, text in files.items():
                write_file(scratch / name, text)
        self._rows[run.identity] = self._row(run.identity)
        self._seconds[run.identity] = seconds
        if time.monotonic() - self._written >= _INTERVAL:
            self.write_tables()

    def write_tables(self) -> None:
        """Write `sweep.csv` and `times.csv`."""
        write_file(self.folder / TABLE, csv_text(self.table()))
        times = pd.DataFrame(sorted(self._seconds.items()), columns=["folder", "wall_s"])
        write_file(self.folder / TIMES, csv_text(times))
        self._written = time.monotonic()

    def table(self) -> pd.DataFrame:
        """One row per run: its number and folder, what was varied, its status, and its recommended design."""
        rows = []
        for run in self.runs:
            found = self._rows[run.identity] or {"status": "waiting"}
            varied = {key: text_of(value) for key, value in run.values.items()}
            rows.append({"run": run.number, "folder": f"{RUNS}/{run.identity}"} | varied | found)
        columns = list(dict.fromkeys(name for row in rows for name in row))
        return pd.DataFrame([[row.get(name, "") for name in columns] for row in rows], columns=columns, dtype=object)

    def _row(self, identity: str) -> dict[str, Any] | None:
        folder = self.folder / RUNS / identity
        try:
            if (folder / FAILURE).is_file():
                failure = json.loads((folder / FAILURE).read_text(encoding="utf-8"))
                return {"status": "failed", "message": failure["message"]}
            if not (folder / _RECORD).is_file():
                return None
            record = json.loads((folder / _RECORD).read_text(encoding="utf-8"))
            best = next(row for row in _rows(folder / "pareto.csv") if row["recommended"] == "true")
        except (OSError, ValueError, KeyError, StopIteration) as error:
            remedy = "Remove this folder, and give the same command again."
            raise InputError(
                f"the results of this run are damaged ({error})", where=str(folder), remedy=remedy
            ) from None
        criteria = [name for name in best if name not in ("design", "kktpm", "recommended", "knee")]
        summary = {name: "" if record[name] is None else record[name] for name in _SUMMARY}
        return {"status": "finished"} | {name: float(best[name]) for name in criteria} | summary

    def _known_times(self) -> dict[str, float]:
        file = self.folder / TIMES
        if not file.is_file():
            return {}
        return {row["folder"]: float(row["wall_s"]) for row in _rows(file)}


def _rows(file: Path) -> list[dict[str, str]]:
    with file.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))

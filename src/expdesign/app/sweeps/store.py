"""Where the results of a sweep are kept: one folder per run, named by the run's identity, and `sweep.csv` over all.

A run's folder appears at once and complete, or not at all, so that its being there is the record that the run is
finished. Times depend on the machine and lie apart in `times.csv`; all else is the same bytes wherever it was computed.
"""

import json
import shutil
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pandas as pd

from expdesign.app.sweeps.runs import SweepRun, text_of
from expdesign.errors import InputError
from expdesign.io.output import csv_text, output_folder, write_file

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
        stream = (folder / LOCK).open("w")
    except OSError as error:
        raise InputError(f"cannot be written ({error.strerror})", where=str(folder), remedy="Name another.") from None
    with stream:
        try:
            _lock(stream.fileno())
        except OSError:
            remedy = "Wait for it, or name another folder."
            raise InputError("another sweep is writing here", where=str(folder), remedy=remedy) from None
        for scratch in [*folder.glob(f"{RUNS}/.*"), *folder.glob(f".{TABLE}-*"), *folder.glob(f".{TIMES}-*")]:
            shutil.rmtree(scratch) if scratch.is_dir() else scratch.unlink()
        yield


def _lock(handle: int) -> None:
    """Be the only one with a lock on an open file until the process ends; nothing where the system has no such locks.

    Raises:
        OSError: another process has it.
    """
    try:
        import fcntl  # noqa: PLC0415 (not on every system)
    except ImportError:
        return
    fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)


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
        times = folder / TIMES
        self._seconds: dict[str, float] = {}
        if times.is_file():
            known = _read(times)
            self._seconds = dict(zip(known["folder"], known["wall_s"].astype(float), strict=True))
        self._written = -_INTERVAL

    def waiting(self) -> list[SweepRun]:
        """The runs that are not finished, one of each identity."""
        return list({run.identity: run for run in self.runs if self._rows[run.identity] is None}.values())

    def count(self) -> int:
        """How many runs are finished."""
        return sum(self._rows[run.identity] is not None for run in self.runs)

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
            best = _read(folder / "pareto.csv").query("recommended == 'true'").iloc[0]
        except (OSError, ValueError, KeyError, IndexError) as error:
            remedy = "Remove this folder, and give the same command again."
            raise InputError(
                f"the results of this run are damaged ({error})", where=str(folder), remedy=remedy
            ) from None
        criteria = best.drop(["design", "kktpm", "recommended", "knee"], errors="ignore")
        summary = {name: "" if record[name] is None else record[name] for name in _SUMMARY}
        return {"status": "finished", **criteria.astype(float), **summary}


def _read(file: Path) -> pd.DataFrame:
    """The cells of a table as text: numbers to the last digit, and identities whatever they look like."""
    return pd.read_csv(file, dtype=str, keep_default_na=False)

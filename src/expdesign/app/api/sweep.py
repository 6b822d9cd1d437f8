"""`sweep`: many runs with other values, resumable, on one machine or a cluster."""

from __future__ import annotations

import logging
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import pandas as pd

from expdesign.app.api.callbacks import Callback, shows_progress, silent
from expdesign.app.api.inputs import document_of, purpose_of
from expdesign.app.api.run import run
from expdesign.app.parallel import Executors, results
from expdesign.app.sweeps.runs import computed_by, sweep_runs
from expdesign.app.sweeps.store import FAILURE, TABLE, TIMES, Store, sole_writer
from expdesign.counted import counted
from expdesign.errors import ExpdesignError
from expdesign.io.output import json_text, require_writable
from expdesign.io.written import claim, require_free_names
from expdesign.io.yaml_reader import YamlDocument, yaml_text
from expdesign.planning.problem_file import problem_from_document
from expdesign.report.result import PathLike, Result, numeric
from expdesign.report.said import Said

_LOG = logging.getLogger(__name__)
CONFIG = "config.yaml"
"""In the folder of a run: its configuration, as resolved, so that it can be run and judged there."""
COMPUTED_BY = "computed_by.json"
"""In the folder of a run: digest of the code and versions of the libraries that its numbers come from."""


@dataclass(frozen=True, repr=False)
class SweepResult(Result):
    """A finished sweep.

    Attributes:
        folder: where it lies.
        table: one row per run (`sweep.csv`).
    """

    FILES: ClassVar = (TABLE, TIMES)
    folder: Path
    table: pd.DataFrame

    @property
    def said(self) -> Said:
        text = f"{counted(len(self.table), 'run')} in {self.folder}, {self.failed} of them without a result"
        why = f"{self.failed} of {len(self.table)} runs have no result; the column `message` says why."
        return Said(text, [str(self.folder / TABLE)], [why] if self.failed else [])

    @property
    def failed(self) -> int:
        """How many runs have no result."""
        return int((self.table["status"] == "failed").sum())


@shows_progress("sweeping")
def sweep(
    file: PathLike,
    folder: PathLike,
    *,
    executors: Executors | None = None,
    callback: Callback | None = None,
    progress: bool = False,
    force: bool = False,
) -> SweepResult:
    """Repeat a run with other values; the same command continues an interrupted sweep.

    Each run is kept as it arrives. Given again with more values, only the new runs are done. A run is done again where
    other code or other libraries would compute it now.

    Args:
        file: what varies (YAML).
        folder: folder for the results; the same folder continues a sweep.
        executors: makes the executor that does the runs, e.g. `ProcessPoolExecutor`; one after another in this process
            if left out.
        callback: called with the stage, the steps done, the steps in all and a note (`Callback`).
        progress: whether progress is shown on standard error.
        force: replace the tables of another sweep in the folder.

    Raises:
        InputError: the sweep is wrong, or a result cannot be written.
        WorkersError: the workers are gone.

    Command:
        expdesign sweep configs/sweep-measurements.yaml --out results/measurements --workers 2
    """
    path = Path(folder)
    document = document_of(file, "sweep")
    require_writable(path)
    purpose = purpose_of("sweep", file)
    require_free_names(path, SweepResult.FILES, purpose, force=force)
    runs = sweep_runs(document)
    with sole_writer(path):
        claim(path, SweepResult.FILES, purpose)
        store = Store(path, runs)
        waiting = store.waiting()
        done = store.count()
        (callback or silent)("sweeping", done, len(runs), f"{done} were done before" if done else "")
        try:
            for index, (files, seconds) in results(run_files, [item.config for item in waiting], executors):
                store.put(waiting[index], files, seconds)
                (callback or silent)("sweeping", store.count(), len(runs), "")
            store.write_tables()
        except ExpdesignError as error:
            kept = f"{store.count()} of {len(runs)} runs are finished and kept: the same command continues from there."
            remedy = f"{error.remedy} {kept}".strip()
            raise type(error)(error.what, where=error.where, remedy=remedy) from None
        except KeyboardInterrupt:
            _LOG.info("Finished runs are kept; the same command continues from there.")
            raise
    return SweepResult(path, numeric(store.table()), purpose=purpose)


def run_files(config: dict[str, Any]) -> tuple[dict[str, str], float]:
    """Names and texts of the files of one run, without a time in them, and how long it took (s).

    What is wrong with a run is its result; only what is wrong with the machine is raised.
    """
    started = time.perf_counter()
    try:
        result = run(problem_from_document(YamlDocument(CONFIG, Path(), config)))
        del result.written["wall_s"]
        files = result.files()
    except ExpdesignError as error:
        files = {FAILURE: json_text({"message": error.message})}
    text = yaml_text(config)
    return files | {CONFIG: text, COMPUTED_BY: json_text(computed_by())}, time.perf_counter() - started

"""Running a command on one case: what it cost, the program under test, and resuming."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import pandas as pd

from .case import Case, asked_of, write_questions

ROOT = Path(__file__).parents[3]
MOST_SECONDS = 600.0


@dataclass(frozen=True)
class Outcome:
    """Wall and processor time (s) and the largest memory (MB) of a command, and what went wrong, if anything did."""

    wall_s: float
    cpu_s: float
    memory_MB: float
    problem: str = ""


def measured(call: Sequence[str], folder: Path, limit_s: float = MOST_SECONDS) -> Outcome:
    """Run one command in a folder. It and what it started are ended where they take longer than the limit.

    Its processor time counts it alone, whatever else the machine is doing.
    """
    started = time.monotonic()
    with tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace") as said:
        try:
            running = subprocess.Popen(call, cwd=folder, stdout=subprocess.DEVNULL, stderr=said, start_new_session=True)
        except OSError as error:
            return Outcome(0.0, 0.0, 0.0, f"the command does not start: {error.strerror}: {call[0]}")
        problem = ""
        pid, status, used = os.wait4(running.pid, os.WNOHANG)
        while not pid:
            if not problem and time.monotonic() - started > limit_s:
                problem = f"longer than {limit_s:g} s"
                os.killpg(running.pid, signal.SIGKILL)
            time.sleep(0.05)
            pid, status, used = os.wait4(running.pid, os.WNOHANG)
        running.returncode = os.waitstatus_to_exitcode(status)
        said.seek(0)
        lines = said.read().strip().splitlines()
    if running.returncode != 0 and not problem:
        problem = f"exit {running.returncode}: {lines[-1][:200] if lines else 'nothing on standard error'}"
    return Outcome(time.monotonic() - started, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024, problem)


@dataclass(frozen=True)
class Program:
    """The program's command line, and where cases and answers lie; what has been answered is not asked again."""

    command: Sequence[str]
    folder: Path

    def answers(self, name: str) -> Path:
        """Where the answer to a case lies."""
        return self.folder / "answers" / name

    def ask(self, case: Case) -> Outcome:
        """Diagnose in an empty folder with the questions alone, then predict the judge's rows; both are kept."""
        out, kept = self.answers(case.name), self.answers(case.name) / "outcome.json"
        if kept.exists():
            return Outcome(**json.loads(kept.read_text(encoding="utf-8")))
        out.mkdir(parents=True, exist_ok=True)
        write_questions(case, self.folder / "cases" / case.name)
        with tempfile.TemporaryDirectory() as elsewhere:
            for file in (self.folder / "cases" / case.name).iterdir():
                shutil.copy(file, elsewhere)
            outcome = measured(diagnosis(self.command, str(out), case.truth["without"]), Path(elsewhere))
            if not outcome.problem:
                self._predict(case, out, Path(elsewhere))
        kept.write_text(json.dumps(asdict(outcome)), encoding="utf-8")
        return outcome

    def _predict(self, case: Case, out: Path, elsewhere: Path) -> None:
        model, points = out / "model.yaml", elsewhere / "points.csv"
        if not model.exists():
            return
        rows, held_out = asked_of(case)
        rows.to_csv(points, index=False)
        call = [*self.command, "predict", str(model), str(points), "--out", str(out / "predicted.csv")]
        done = subprocess.run(call, cwd=elsewhere, capture_output=True, text=True, timeout=300, check=False)
        (out / "predict.txt").write_text(done.stderr[-2000:], encoding="utf-8")
        if done.returncode == 0:
            pd.read_csv(out / "predicted.csv")[held_out].to_csv(out / "predicted.csv", index=False)

    def repeatable(self, cases: Sequence[Case]) -> int:
        """How many of the cases get the same diagnosis.json a second time."""
        again = Program(self.command, self.folder / "again")
        for case in cases:
            again.ask(case)
        each = [[one.answers(case.name) / "diagnosis.json" for one in (self, again)] for case in cases]
        return sum(a.exists() and b.exists() and a.read_bytes() == b.read_bytes() for a, b in each)


def diagnosis(command: Sequence[str], out: str, without: Sequence[str]) -> list[str]:
    """The command line of a diagnosis; with entries left out, through the seam of `withheld`."""
    if not without:
        return [*command, "diagnose", "robot.yaml", "recordings.csv", "--out", out]
    see_checkout(ROOT)
    module = "research.benchmarks.concealed.withheld"
    return [sys.executable, "-m", module, "robot.yaml", "recordings.csv", out, *without]


def see_checkout(*folders: Path) -> None:
    """Let Python processes that are started later import from folders of the checkout."""
    paths = [*map(str, folders), *os.environ.get("PYTHONPATH", "").split(os.pathsep)]
    os.environ["PYTHONPATH"] = os.pathsep.join(dict.fromkeys(path for path in paths if path))

"""Running the program under test on one case: diagnose and predict, what it cost, and resuming."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from ..run import Outcome, timed
from .case import Case
from .generate import write_questions

_ROOT = Path(__file__).parents[3]


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
        name = str(case.truth["case"])
        out, kept = self.answers(name), self.answers(name) / "outcome.json"
        if kept.exists():
            return Outcome(**json.loads(kept.read_text(encoding="utf-8")))
        out.mkdir(parents=True, exist_ok=True)
        write_questions(case, self.folder / "cases" / name)
        with tempfile.TemporaryDirectory() as elsewhere:
            for file in (self.folder / "cases" / name).iterdir():
                shutil.copy(file, elsewhere)
            call = diagnosis(self.command, str(out), case.truth["without"])
            outcome = timed(call, elsewhere)
            if not outcome.problem:
                self._predict(case, out, elsewhere)
        kept.write_text(json.dumps(asdict(outcome)), encoding="utf-8")
        return outcome

    def _predict(self, case: Case, out: Path, elsewhere: str) -> None:
        model, points = out / "model.yaml", Path(elsewhere) / "points.csv"
        if not model.exists():
            return
        hidden = [name for name in case.later if _measured(str(name))]
        case.later.drop(columns=hidden).to_csv(points, index=False)
        call = [*self.command, "predict", str(model), str(points), "--out", str(out / "predicted.csv")]
        done = subprocess.run(call, cwd=elsewhere, capture_output=True, text=True, timeout=300, check=False)
        (out / "predict.txt").write_text(done.stderr[-2000:], encoding="utf-8")


def diagnosis(command: Sequence[str], out: str, without: Sequence[str]) -> list[str]:
    """The command line of a diagnosis; with entries left out, through the seam of `withheld`."""
    if not without:
        return [*command, "diagnose", "robot.yaml", "recordings.csv", "--out", out]
    os.environ["PYTHONPATH"] = os.pathsep.join(dict.fromkeys([str(_ROOT), *_paths()]))
    module = "benchmarks.concealed.unlisted.withheld"
    return [sys.executable, "-m", module, "robot.yaml", "recordings.csv", out, *without]


def _paths() -> list[str]:
    return [each for each in os.environ.get("PYTHONPATH", "").split(os.pathsep) if each]


def _measured(column: str) -> bool:
    """Whether a column of the judge's rows tells what was measured."""
    axes = ("x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad")
    deflections = {f"{kind}{axis}" for kind in "ds" for axis in axes}
    positions = {f"{kind}{axis}" for kind in ("p", "sp") for axis in axes[:3]}
    return column.startswith(("true_", "base_")) or column in deflections | positions

"""The proof in one command: `python -m benchmarks.concealed.run` generates cases, has them diagnosed, and scores.

Every diagnosis is a process of its own, started in an empty folder, given a folder that holds the robot file and the
recordings alone. The truths stay in the memory of this process until the last diagnosis has ended; the seed is drawn
afresh unless one is given.
"""

from __future__ import annotations

import argparse
import datetime
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from . import cases as concealed
from .answers import NoAnswerError, read_answer
from .generate import fresh_seed, generate, write_questions, write_truth
from .held_out import HeldOut, held_out
from .judgement import Case
from .score import frame, markdown

MOST_SECONDS = 600.0


@dataclass(frozen=True)
class Outcome:
    """Wall and processor time of a diagnosis (s), what went wrong, if anything did, and its largest memory (MB)."""

    wall_s: float
    cpu_s: float
    problem: str
    memory_MB: float = float("nan")


@dataclass(frozen=True)
class Examination:
    """How diagnoses are run: the program's command line, where cases and answers lie, how many at a time."""

    command: Sequence[str]
    folder: Path
    jobs: int

    def questions(self, name: str) -> Path:
        return self.folder / "cases" / name

    def answers(self, name: str) -> Path:
        return self.folder / "answers" / name

    def diagnose(self, name: str) -> Outcome:
        """How long it took, and what went wrong, if anything did."""
        out = self.answers(name)
        out.mkdir(parents=True, exist_ok=True)
        call = [*self.command, "diagnose", "robot.yaml", "recordings.csv", "--out", str(out / "result")]
        with tempfile.TemporaryDirectory() as elsewhere:
            for file in self.questions(name).iterdir():
                shutil.copy(file, elsewhere)
            outcome = timed(call, elsewhere)
        if (out / "result").is_dir():
            for file in (out / "result").iterdir():
                shutil.move(file, out / file.name)
            (out / "result").rmdir()
        (out / "wall_s.txt").write_text(f"{outcome.wall_s:.2f}\n", encoding="utf-8")
        (out / "cpu_s.txt").write_text(f"{outcome.cpu_s:.2f}\n", encoding="utf-8")
        return outcome

    def judge(self, case: concealed.Case, outcome: Outcome) -> Case:
        judged = partial(Case, case.truth, wall_s=outcome.wall_s, cpu_s=outcome.cpu_s)
        folder = self.answers(case.truth["case"])
        if outcome.problem:
            return judged(None, problem=outcome.problem)
        try:
            answer = read_answer(folder / "diagnosis.json", len(case.truth["true_stiffness"]))
        except NoAnswerError as error:
            return judged(None, problem=str(error))
        return judged(answer, later=self._held_out(case, folder))

    def _held_out(self, case: concealed.Case, folder: Path) -> HeldOut | None:
        model = folder / "model.yaml"
        if not model.exists():
            return None
        noise = case.truth["later_noise_rms"]
        return held_out(self.command, model, case.robot, case.recordings, case.later, noise)

    def repeatable(self, names: Sequence[str]) -> int:
        """How many of the cases get the same diagnosis.json a second time."""
        same = 0
        for name in names:
            before = self.answers(name) / "diagnosis.json"
            again = Examination(self.command, self.folder / "again", 1)
            shutil.copytree(self.questions(name), again.questions(name), dirs_exist_ok=True)
            again.diagnose(name)
            after = again.answers(name) / "diagnosis.json"
            same += before.exists() and after.exists() and before.read_bytes() == after.read_bytes()
        return same


def timed(call: Sequence[str], folder: str) -> Outcome:
    """Run one program in a folder. Its processor time counts it alone, whatever else the machine is doing."""
    started = time.monotonic()
    with tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace") as said:
        running = subprocess.Popen(call, cwd=folder, stdout=subprocess.DEVNULL, stderr=said)
        while True:
            pid, status, used = os.wait4(running.pid, os.WNOHANG)
            if pid:
                break
            if time.monotonic() - started > MOST_SECONDS:
                running.kill()
                os.wait4(running.pid, 0)
                return Outcome(time.monotonic() - started, float("nan"), f"no answer within {MOST_SECONDS:.0f} s")
            time.sleep(0.05)
        running.returncode = os.waitstatus_to_exitcode(status)
        said.seek(0)
        problem = "" if running.returncode == 0 else f"exit {running.returncode}: {_last_line(said.read())}"
    return Outcome(time.monotonic() - started, used.ru_utime + used.ru_stime, problem, used.ru_maxrss / 1024)


def _last_line(text: str) -> str:
    lines = text.strip().splitlines()
    return lines[-1][:200] if lines else "nothing on standard error"


def examine(examination: Examination, cases: Sequence[concealed.Case]) -> list[Case]:
    """Have all cases diagnosed, then judge."""
    names = [str(case.truth["case"]) for case in cases]
    outcomes = []
    with ThreadPoolExecutor(examination.jobs) as pool:
        for done, outcome in enumerate(pool.map(examination.diagnose, names), start=1):
            outcomes.append(outcome)
            print(f"\rdiagnosed {done} of {len(names)}", end="", file=sys.stderr, flush=True)
        print(file=sys.stderr)
        return list(pool.map(examination.judge, cases, outcomes))


def main() -> None:
    chosen = _arguments()
    fresh = chosen.seed is None and not chosen.only
    seed = fresh_seed() if chosen.seed is None else chosen.seed
    started, today = time.monotonic(), datetime.datetime.now(datetime.UTC).date().isoformat()
    with tempfile.TemporaryDirectory(prefix="concealed-") as scratch:
        folder = chosen.keep or Path(scratch)
        examination = Examination(shlex.split(chosen.command), folder.resolve(), chosen.jobs)
        cases = []
        for case in generate(chosen.count, seed, chosen.only, chosen.jobs):
            cases.append(case)
            write_questions(case, examination.questions(case.truth["case"]))
        generated = time.monotonic() - started
        judged = examine(examination, cases)
        again = [str(case.truth["case"]) for case in cases[: chosen.again]]
        same = examination.repeatable(again)
        if chosen.keep:
            for case in cases:
                write_truth(case, folder / "truth" / case.truth["case"])
    only = f", only {', '.join(chosen.only)}" if chosen.only else ""
    facts = [
        f"{today}, seed {seed}{' (drawn afresh)' if fresh else ' (given)' if chosen.seed is not None else ''}{only}",
        f"{chosen.jobs} at a time; generating took {generated:.0f} s, everything {time.monotonic() - started:.0f} s",
        f"diagnosed a second time with the same diagnosis.json: {same} of {len(again)}",
    ]
    title = "Proof on concealed data" if fresh else "Development set of concealed data"
    text = markdown(judged, title, facts)
    print(text)
    results = chosen.results or (Path("results/concealed") if fresh else chosen.keep)
    if results:
        results.mkdir(parents=True, exist_ok=True)
        stem = results / f"{today}-{seed}{'' if fresh else '-development'}"
        stem.with_suffix(".md").write_text(text, encoding="utf-8")
        frame(judged).to_csv(stem.with_suffix(".csv"), index=False)
        print(stem.with_suffix(".md"))


def _arguments() -> argparse.Namespace:
    program = Path(sys.executable).with_name("expdesign")
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, help="default: drawn afresh; with a seed it is no proof")
    parser.add_argument("--only", action="append", default=[], help="an identifier, or none, one, two, outside")
    parser.add_argument("--jobs", type=int, default=2, help="diagnoses at a time")
    parser.add_argument("--keep", type=Path, help="folder for cases, answers and, afterwards, truths")
    parser.add_argument("--results", type=Path, help="folder for the table (a proof: results/concealed)")
    parser.add_argument("--again", type=int, default=2, help="how many cases to diagnose a second time")
    parser.add_argument("--command", default=str(program), help="the program that diagnoses and predicts")
    return parser.parse_args()


if __name__ == "__main__":
    main()

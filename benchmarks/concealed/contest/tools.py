"""Running a tool on one case: any command, in an empty folder, within a time limit."""

from __future__ import annotations

import json
import os
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

CASE, ANSWER = "{case}", "{answer}"
_ROOT = Path(__file__).parents[3]


@dataclass(frozen=True)
class Cost:
    """Wall and processor time (s) and the largest memory (MB) of a command, and what went wrong, if anything did."""

    wall_s: float
    cpu_s: float
    memory_MB: float
    problem: str = ""


@dataclass(frozen=True)
class Tool:
    """A name and a command line with the placeholders `{case}` (folder) and `{answer}` (file to be written).

    Raises:
        ValueError: a placeholder is missing.
    """

    name: str
    command: str

    def __post_init__(self) -> None:
        for placeholder in (CASE, ANSWER):
            if placeholder not in self.command:
                raise ValueError(f"tool {self.name}: the command has no {placeholder}: {self.command}")

    @classmethod
    def from_text(cls, text: str) -> Tool:
        """Of `NAME=COMMAND`."""
        name, equals, command = text.partition("=")
        if not equals or not name.strip():
            raise ValueError(f"{text!r} is not NAME=COMMAND")
        return cls(name.strip(), command.strip())

    def ask(self, question: Path, kept: Path, limit_s: float) -> Cost:
        """Run the command on a copy of the question; `kept` then holds answer.json, where one was written, and
        cost.json. What was asked before is not asked again.
        """
        if (kept / "cost.json").exists():
            return kept_cost(kept)
        kept.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix="case-") as folder:
            case, answer = Path(folder) / "case", Path(folder) / "answer.json"
            shutil.copytree(question, case)
            words = [word.replace(CASE, str(case)).replace(ANSWER, str(answer)) for word in shlex.split(self.command)]
            cost = measured(words, case, limit_s)
            if answer.is_file():
                shutil.copy(answer, kept / "answer.json")
        (kept / "cost.json").write_text(json.dumps(asdict(cost)), encoding="utf-8")
        return cost


def kept_cost(kept: Path) -> Cost:
    """What an answer has cost; unknown where it was not asked for here."""
    file = kept / "cost.json"
    if not file.exists():
        return Cost(float("nan"), float("nan"), float("nan"))
    return Cost(**json.loads(file.read_text(encoding="utf-8")))


def with_rivals(tools: Sequence[Tool]) -> list[Tool]:
    """Tools and, after them, every module of `rivals` that can be run; these find the checkout by PYTHONPATH."""
    paths = [str(_ROOT), str(_ROOT / "src"), *os.environ.get("PYTHONPATH", "").split(os.pathsep)]
    os.environ["PYTHONPATH"] = os.pathsep.join(dict.fromkeys(path for path in paths if path))
    found = list(tools)
    for path in sorted((_ROOT / "benchmarks" / "concealed" / "rivals").glob("*.py")):
        if path.stem not in ("__init__", "listed_models", "question"):
            module = f"{sys.executable} -m benchmarks.concealed.rivals.{path.stem}"
            found.append(Tool(path.stem.replace("_", " "), f"{module} {CASE} {ANSWER}"))
    return found


def measured(words: list[str], folder: Path, limit_s: float) -> Cost:
    """What a command costs. It and what it started are ended where they take longer than the limit."""
    started = time.monotonic()
    with tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace") as said:
        try:
            running = subprocess.Popen(
                words, cwd=folder, stdout=subprocess.DEVNULL, stderr=said, start_new_session=True
            )
        except OSError as error:
            return Cost(0.0, 0.0, 0.0, f"the command does not start: {error.strerror}: {words[0]}")
        pid, status, used = os.wait4(running.pid, os.WNOHANG)
        while not pid:
            if time.monotonic() - started > limit_s:
                os.killpg(running.pid, signal.SIGKILL)
                _, status, used = os.wait4(running.pid, 0)
                running.returncode = os.waitstatus_to_exitcode(status)
                cpu = used.ru_utime + used.ru_stime
                return Cost(time.monotonic() - started, cpu, used.ru_maxrss / 1024, f"longer than {limit_s:g} s")
            time.sleep(0.05)
            pid, status, used = os.wait4(running.pid, os.WNOHANG)
        running.returncode = os.waitstatus_to_exitcode(status)
        said.seek(0)
        lines = said.read().strip().splitlines()
    problem = ""
    if running.returncode != 0:
        problem = f"exit {running.returncode}: {lines[-1][:200] if lines else 'nothing on standard error'}"
    wall = time.monotonic() - started
    return Cost(wall, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024, problem)

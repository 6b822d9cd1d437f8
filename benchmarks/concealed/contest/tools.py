"""Running a tool on one case: any command, in an empty folder, within a time limit."""

from __future__ import annotations

import json
import shlex
import shutil
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from ..program import ROOT, Outcome, measured, see_checkout

CASE, ANSWER = "{case}", "{answer}"


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

    def ask(self, question: Path, kept: Path, limit_s: float) -> Outcome:
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


def kept_cost(kept: Path) -> Outcome:
    """What an answer has cost; unknown where it was not asked for here."""
    file = kept / "cost.json"
    if not file.exists():
        return Outcome(float("nan"), float("nan"), float("nan"))
    return Outcome(**json.loads(file.read_text(encoding="utf-8")))


def with_rivals(tools: Sequence[Tool]) -> list[Tool]:
    """Tools and, after them, every module of `rivals` that can be run; these find the checkout by PYTHONPATH."""
    see_checkout(ROOT, ROOT / "src")
    found = list(tools)
    for path in sorted((ROOT / "benchmarks" / "concealed" / "rivals").glob("*.py")):
        if path.stem not in ("__init__", "listed_models", "question"):
            module = f"{sys.executable} -m benchmarks.concealed.rivals.{path.stem}"
            found.append(Tool(path.stem.replace("_", " "), f"{module} {CASE} {ANSWER}"))
    return found

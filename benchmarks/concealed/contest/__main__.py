"""The contest: `python -m benchmarks.concealed.contest draw|answer|score|run`; docs/benchmark.md explains it."""

from __future__ import annotations

import argparse
import datetime
import sys
from collections.abc import Sequence
from pathlib import Path

from benchmarks.single_thread import single_threaded

from ..case import Case, fresh_seed, read_case, write_questions, write_truth
from .judgement import Judged, judge
from .questions import drawn, questions
from .table import agreement, frame, markdown
from .tools import Tool, kept_cost, with_rivals

LIMIT_S = 300.0


def draw(chosen: argparse.Namespace) -> None:
    """Write cases, and apart from them their truths."""
    seed = fresh_seed() if chosen.seed is None else chosen.seed
    wanted = questions(seed, chosen.count, chosen.none)
    for done, case in enumerate(drawn(wanted), start=1):
        write_questions(case, chosen.out / "cases" / case.name, points=True)
        write_truth(case, chosen.out / "truth" / case.name)
        print(f"\rdrawn {done} of {len(wanted)}", end="", file=sys.stderr, flush=True)
    print(f"\n{len(wanted)} cases of seed {seed} in {chosen.out}", file=sys.stderr)


def answer(chosen: argparse.Namespace) -> None:
    """Have the tools answer cases that were drawn."""
    names = sorted(path.name for path in (chosen.folder / "cases").glob("case-*"))
    if not names:
        raise SystemExit(f"{chosen.folder} has no cases/case-001 …: draw some first")
    _ask(chosen.tool, chosen.folder / "cases", names, chosen.folder / "answers", chosen.limit)


def score(chosen: argparse.Namespace) -> None:
    """Judge what was answered in one round or more: the cases to which every tool was put."""
    rounds = [kept_round(folder) for folder in chosen.folder]
    parts = []
    for folder, judged in zip(chosen.folder, rounds, strict=True):
        parts.append(f"## {folder.name}\n\n{markdown(judged, _facts(judged))}")
    together = [case for judged in rounds for case in judged]
    if len(rounds) > 1:
        parts.append(f"## All rounds together\n\n{markdown(together, _facts(together))}")
        parts.append(f"## Do the rounds agree?\n\n{agreement(rounds[0], rounds[1])}")
    print("\n".join(parts))
    if chosen.csv:
        frame(together).to_csv(chosen.csv, index=False)


def kept_round(folder: Path) -> list[Judged]:
    """The judged answers of a folder with `cases`, `truth` and `answers`."""
    answers = folder / "answers"
    tools = sorted(path.name for path in answers.iterdir() if path.is_dir())
    names = [path.name for path in sorted((folder / "truth").glob("case-*"))]
    asked = [name for name in names if all((answers / tool / name).is_dir() for tool in tools)]
    return _judge(tools, [read_case(folder / "cases" / name, folder / "truth" / name) for name in asked], answers)


def _facts(judged: Sequence[Judged]) -> list[str]:
    seeds = sorted({str(case.truth["seed"]) for case in judged})
    cases = {(case.truth["seed"], case.case) for case in judged}
    spent = sum(case.cost.cpu_s for case in judged)
    return [f"seed {', '.join(seeds)}; {len(cases)} cases; the tools' processor time {spent:.0f} s"]


def run(chosen: argparse.Namespace) -> None:
    """Draw, ask and judge. The truths stay in the memory of this process until the last tool has answered."""
    seed = fresh_seed() if chosen.seed is None else chosen.seed
    print(f"seed {seed}", file=sys.stderr, flush=True)
    cases = list(drawn(questions(seed, chosen.count, chosen.none)))
    names = [case.name for case in cases]
    for case, name in zip(cases, names, strict=True):
        write_questions(case, chosen.out / "cases" / name, points=True)
    _ask(chosen.tool, chosen.out / "cases", names, chosen.out / "answers", chosen.limit)
    judged = _judge([tool.name for tool in chosen.tool], cases, chosen.out / "answers")
    for case, name in zip(cases, names, strict=True):
        write_truth(case, chosen.out / "truth" / name)
    today = datetime.datetime.now(datetime.UTC).date().isoformat()
    drawn_how = "drawn afresh" if chosen.seed is None else "given"
    facts = [f"{today}, seed {drawn_how}, time limit {chosen.limit:g} s a case", *_facts(judged)]
    (chosen.out / "table.md").write_text(markdown(judged, facts), encoding="utf-8")
    frame(judged).to_csv(chosen.out / "cases.csv", index=False)
    print(markdown(judged, facts))


def _ask(tools: Sequence[Tool], cases: Path, names: Sequence[str], answers: Path, limit_s: float) -> None:
    """Every tool on every case, case by case, so that an interrupted run has whole cases."""
    with single_threaded():
        for done, name in enumerate(names, start=1):
            for tool in tools:
                tool.ask(cases / name, answers / tool.name / name, limit_s)
            print(f"\ranswered {done} of {len(names)}", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)


def _judge(tools: Sequence[str], cases: Sequence[Case], answers: Path) -> list[Judged]:
    judged = []
    for case in cases:
        for tool in tools:
            kept = answers / tool / case.name
            judged.append(judge(tool, case, kept_cost(kept), kept / "answer.json"))
    return judged


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True)

    def command(name: str, act: object, what: str) -> argparse.ArgumentParser:
        made = commands.add_parser(name, help=what, description=what)
        made.set_defaults(act=act)
        return made

    def drawing(made: argparse.ArgumentParser) -> None:
        made.add_argument("--out", type=Path, required=True)
        made.add_argument("--count", type=int, default=8, help="cases of each of the four classes with a mismatch")
        made.add_argument("--none", type=int, default=4, help="consistent cases with few rows, and with many")
        made.add_argument("--seed", type=int, help="drawn afresh where left out; 1 to 5 are for practice")

    def asking(made: argparse.ArgumentParser) -> None:
        what = "NAME=COMMAND with {case} and {answer}"
        made.add_argument("--tool", type=Tool.from_text, action="append", default=[], help=what)
        made.add_argument("--rivals", action="store_true", help="also the tools of benchmarks/concealed/rivals")
        made.add_argument("--limit", type=float, default=LIMIT_S, help="seconds of wall time a case may take")

    drawing(command("draw", draw, "write cases and, apart from them, truths"))
    answering = command("answer", answer, "have tools answer cases")
    asking(answering)
    answering.add_argument("folder", type=Path, help="what `draw` has written; gets `answers`")
    scoring = command("score", score, "judge kept answers")
    scoring.add_argument("folder", type=Path, nargs="+", help="with `cases`, `truth` and `answers`; one a round")
    scoring.add_argument("--csv", type=Path, help="file for one row per case and tool")
    running = command("run", run, "draw, ask and judge in one go")
    drawing(running)
    asking(running)
    chosen = parser.parse_args()
    if "tool" in chosen:
        chosen.tool = with_rivals(chosen.tool) if chosen.rivals else chosen.tool
        if not chosen.tool:
            parser.error("no tool: give --tool NAME=COMMAND or --rivals")
    return chosen


def main() -> None:
    chosen = _arguments()
    chosen.act(chosen)


if __name__ == "__main__":
    main()

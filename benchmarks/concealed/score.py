"""Score kept answers: `python -m benchmarks.concealed.score --cases DIR --truth DIR2 --answers DIR3`.

The table is that of what the diagnosis must show: false alarms, detection, the right physics, the right component, both
of two effects, what is not known, held-out error, calibration of probabilities, time.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd
import yaml

from .answers import NoAnswerError, read_answer
from .judgement import Case
from .rates import Rate

MOST_SECONDS, ROWS_IN_TIME = 30.0, 150
BINS = (0.0, 0.5, 0.7, 0.85, 0.95, 0.99, 1.0)
ABOUT_90 = (0.85, 0.95)


@dataclass(frozen=True)
class Line:
    """One line of the table: what is asked, what was found, whether that is enough (None: not asked for)."""

    what: str
    asked: str
    found: str
    met: bool | None


def table(cases: Sequence[Case]) -> list[Line]:
    """The table, in the order in which the proof is asked for."""
    real = [case for case in cases if case.kind != "none"]
    known = [case for case in cases if case.kind in ("one", "two")]
    two = [case for case in cases if case.kind == "two"]

    def at_least(what: str, share: float, chosen: Sequence[Case], right: Callable[[Case], bool]) -> Line:
        rate = Rate.of(right(case) for case in chosen)
        return Line(what, f"≥ {100 * share:.0f} %", str(rate), rate.share >= share if rate.total else None)

    alarms = Rate.of(case.alarmed or bool(case.problem) for case in cases if case.kind == "none")
    outside = Rate.of(case.declared_unknown for case in cases if case.kind == "outside")
    return [
        Line("false alarms", "≤ 2 %", str(alarms), alarms.share <= 0.02 if alarms.total else None),
        at_least("mismatches detected", 0.97, real, lambda case: case.alarmed),
        at_least("right physics first", 0.90, known, lambda case: case.first_right),
        at_least("right physics first or in its group", 0.96, known, lambda case: case.first_or_group_right),
        at_least("right component", 0.92, known, lambda case: case.component_right),
        at_least("both of two effects found (groups count)", 0.80, two, lambda case: case.both_found()),
        Line("outside the library: unexplained or unknown", "all", str(outside), _all(outside)),
        *_held_out(cases),
        *_calibration(cases),
        *_times(cases),
        *_further(cases),
    ]


def _all(rate: Rate) -> bool | None:
    return rate.hits == rate.total if rate.total else None


def _held_out(cases: Sequence[Case]) -> list[Line]:
    explained = [case for case in cases if case.answer and case.answer.verdict == "explained"]
    declared = [case.declared_ratio for case in explained if case.declared_ratio is not None]
    changes = [case.declared_change for case in cases if case.declared_change is not None]
    own = [case.later.model / case.later.noise for case in explained if case.later]
    own_changes = [case.later.model / case.later.base for case in cases if case.later]
    lines = []
    for source, ratios, before in (
        ("as declared", declared, changes),
        ("on further series", own, own_changes),
    ):
        worse = Rate.of(change > 1.02 for change in before)
        middle = float(np.median(ratios)) if ratios else float("nan")
        text = f"{middle:.3f} ({len(ratios)} cases)" if ratios else "no cases"
        lines.append(
            Line(
                f"held-out RMS / noise floor, median of explained, {source}",
                "≤ 1.15",
                text,
                middle <= 1.15 if ratios else None,
            )
        )
        most = f", worst {100 * (max(before) - 1):+.1f} %" if before else ""
        lines.append(
            Line(
                f"held-out RMS worse than base by more than 2 %, {source}",
                "never",
                f"{worse}{most}",
                worse.hits == 0 if worse.total else None,
            )
        )
    return lines


def _calibration(cases: Sequence[Case]) -> list[Line]:
    given = [(each.probability, right) for case in cases for each, right in case.conclusions()]
    about = [(p, right) for p, right in given if ABOUT_90[0] <= p <= ABOUT_90[1]]
    rate = Rate.of(right for _, right in about)
    lines = [
        Line(
            f"right of the conclusions given {100 * ABOUT_90[0]:.0f}-{100 * ABOUT_90[1]:.0f} %",
            "90 ± 5 %",
            str(rate),
            0.85 <= rate.share <= 0.95 if rate.total else None,
        )
    ]
    for low, high in pairwise(BINS):
        inside = [(p, right) for p, right in given if low <= p < high or p == high == 1.0]
        mean = f"mean {100 * np.mean([p for p, _ in inside]):.1f} %, " if inside else ""
        right = Rate.of(right for _, right in inside)
        lines.append(Line(f"  given {100 * low:.0f}-{100 * high:.0f} %", "", f"{mean}right {right}", None))
    return lines


def _times(cases: Sequence[Case]) -> list[Line]:
    small = np.array([case.cpu_s for case in cases if case.truth["rows"] <= ROWS_IN_TIME])
    if not len(small):
        return []

    def spread(times: list[float]) -> str:
        middle, late, last = np.quantile(times, [0.5, 0.95, 1.0])
        return f"{middle:.1f} s, {late:.1f} s, {last:.1f} s"

    return [
        Line(
            f"processor time of one process with up to {ROWS_IN_TIME} rows, longest",
            f"< {MOST_SECONDS:.0f} s",
            f"{small.max():.1f} s",
            bool(small.max() < MOST_SECONDS),
        ),
        Line("  all, processor time: median, 95 %, longest", "", spread([case.cpu_s for case in cases]), None),
        Line("  all, wall time (shared machine): likewise", "", spread([case.wall_s for case in cases]), None),
    ]


def _further(cases: Sequence[Case]) -> list[Line]:
    """What helps to understand the rest."""
    one, two = ([case for case in cases if case.kind == kind] for kind in ("one", "two"))
    outside = [case for case in cases if case.kind == "outside"]

    def line(what: str, chosen: Sequence[Case], right: Callable[[Case], bool]) -> Line:
        return Line(f"  {what}", "", str(Rate.of(right(case) for case in chosen)), None)

    return [
        line("one effect: right physics first", one, lambda case: case.first_right),
        line("one effect: first or in its group", one, lambda case: case.first_or_group_right),
        line("one effect: right component", one, lambda case: case.component_right),
        line("one effect: further effects concluded", one, lambda case: len(list(case.conclusions())) > 1),
        line("two effects: one of them first", two, lambda case: case.first_right),
        line("two effects: both named themselves", two, lambda case: case.both_found(groups=False)),
        line("two effects: a third concluded", two, lambda case: len(list(case.conclusions())) > 2),
        line("outside: known physics concluded all the same (p > 0.5)", outside, _misled),
        line("diagnoses that gave no answer", cases, lambda case: bool(case.problem)),
    ]


def _misled(case: Case) -> bool:
    return any(each.physics != "unknown" and each.probability > 0.5 for each, _ in case.conclusions())


def confusion(cases: Sequence[Case]) -> list[list[str]]:
    """Per effect that was alone: cases, detected, first, in group, component, and what was named first."""
    rows = []
    physics = sorted({case.physics[0] for case in cases if case.kind in ("one", "outside")})
    for name in physics:
        own = [case for case in cases if case.kind in ("one", "outside") and case.physics == [name]]
        named = Counter(case.first.physics if case.first else _without(case) for case in own)
        counts = [
            sum(case.alarmed for case in own),
            sum(case.first_right for case in own),
            sum(case.first_or_group_right for case in own),
            sum(case.component_right for case in own),
        ]
        answers = ", ".join(f"{answer} {count}" for answer, count in named.most_common())
        rows.append([name, str(len(own)), *map(str, counts), answers])
    return rows


def _without(case: Case) -> str:
    return f"({case.answer.verdict})" if case.answer else "(no answer)"


def markdown(cases: Sequence[Case], title: str, facts: Sequence[str]) -> str:
    """The whole report: table, confusion per effect, failures one by one."""
    kinds = Counter(case.kind for case in cases)
    robots = Counter(str(case.truth["robot"]) for case in cases)
    lines = [f"# {title}", "", *(f"- {fact}" for fact in facts)]
    lines.append(f"- {len(cases)} cases: " + ", ".join(f"{kind} {count}" for kind, count in sorted(kinds.items())))
    lines.append("- robots: " + ", ".join(f"{robot} {count}" for robot, count in sorted(robots.items())))
    lines += ["", "± is the binomial standard error.", "", *_grid(["", "asked", "found", "met"], _cells(table(cases)))]
    lines += ["", "## One effect at a time", ""]
    head = ["physics", "cases", "detected", "first", "first or group", "component", "named first"]
    lines += _grid(head, confusion(cases))
    lines += ["", "## Failures, one by one", ""]
    failures = [(case, fault) for case in cases if (fault := case.faults())]
    for case, faults in failures:
        said = str(case.answer) if case.answer else case.problem
        truth = f"{case.truth['robot']}, {case.truth['rows']} rows, chi2/dof {case.truth['chi2_dof']:.2f}"
        lines.append(f"- {case.name} ({truth}): {', '.join(faults)}. There: {case.description()}. Said: {said}.")
    if not failures:
        lines.append("None.")
    return "\n".join(lines) + "\n"


def _cells(lines: Sequence[Line]) -> list[list[str]]:
    words = {True: "yes", False: "**no**", None: ""}
    return [[line.what.replace("  ", "&nbsp;&nbsp;"), line.asked, line.found, words[line.met]] for line in lines]


def _grid(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    return [f"| {' | '.join(row)} |" for row in (head, ["---"] * len(head), *rows)]


def frame(cases: Sequence[Case]) -> pd.DataFrame:
    """One row per case."""
    rows = []
    for case in cases:
        later = case.later
        rows.append(
            {
                "case": case.name,
                "kind": case.kind,
                "robot": case.truth["robot"],
                "rows": case.truth["rows"],
                "series": case.truth["series"],
                "chi2_dof": round(case.truth["chi2_dof"], 3),
                "truth": case.description(),
                "answer": str(case.answer) if case.answer else "",
                "faults": "; ".join(case.faults()),
                "declared_ratio": case.declared_ratio,
                "declared_change": case.declared_change,
                "later_base": later.base if later else None,
                "later_model": later.model if later else None,
                "later_noise": later.noise if later else None,
                "wall_s": round(case.wall_s, 2),
                "cpu_s": round(case.cpu_s, 2),
            }
        )
    return pd.DataFrame(rows)


def kept_cases(truths: Path, answers: Path) -> list[Case]:
    """Cases of a kept run; without the judge's held-out error."""
    cases = []
    for path in sorted(truths.glob("case-*/truth.yaml")):
        truth = yaml.safe_load(path.read_text(encoding="utf-8"))
        folder = answers / path.parent.name
        wall, cpu = (_number(folder / name) for name in ("wall_s.txt", "cpu_s.txt"))
        try:
            answer, problem = read_answer(folder / "diagnosis.json", len(truth["true_stiffness"])), ""
        except NoAnswerError as error:
            answer, problem = None, str(error)
        cases.append(Case(truth, answer, wall, problem, cpu_s=cpu))
    return cases


def _number(path: Path) -> float:
    return float(path.read_text(encoding="utf-8")) if path.exists() else float("nan")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--truth", type=Path, required=True)
    parser.add_argument("--answers", type=Path, required=True, help="with case-001/diagnosis.json ...")
    chosen = parser.parse_args()
    print(markdown(kept_cases(chosen.truth, chosen.answers), "Kept answers", [f"answers of {chosen.answers}"]))


if __name__ == "__main__":
    main()

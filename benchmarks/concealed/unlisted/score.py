"""The table of what must be shown outside the library, and the failures one by one."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pandas as pd

from ..rates import Rate
from ..score import Line
from .judgement import Judged

OUTSIDE = ("alone", "pair", "beside", "form")
SECOND = "second_source"
BINS = (0.0, 0.5, 0.7, 0.85, 0.95, 1.0)
_SECONDS, _MEMORY_MB, _ROWS = 10.0, 2048.0, 100


@dataclass(frozen=True)
class Asked:
    """Share located first, held-out RMS in the median (standard deviations), share below 1."""

    located: float
    median: float = 0.5
    below_one: float = 0.8


def table(cases: Sequence[Judged]) -> list[Line]:
    """Every line of the table; families that were not drawn have no lines."""
    lines = [*_family("outside the library", [c for c in cases if c.family in OUTSIDE], Asked(0.80))]
    lines += _family("physics left out of the library", [c for c in cases if c.family == "left_out"], Asked(0.75))
    lines += _family("second source", [c for c in cases if c.family == SECOND], Asked(0.90, 0.6, 0.7))
    lines += _consistent([c for c in cases if c.family == "none"])
    for family in OUTSIDE:
        own = [case for case in cases if case.family == family]
        if own:
            lines.append(Line(f"  {family}: located first", "", str(Rate.of(c.located for c in own)), None))
            lines.append(Line(f"  {family}: held-out RMS", "", _quantiles([_error(c) for c in own]), None))
    lines += _probabilities(cases) + _bands(cases) + _deviations(cases) + _cost(cases)
    return lines


def _family(name: str, cases: Sequence[Judged], bars: Asked) -> list[Line]:
    if not cases:
        return []
    errors = np.array([_error(case) for case in cases])

    def rate(what: str, asked: str, right: Callable[[Judged], bool], met: Callable[[float], bool] | None) -> Line:
        found = Rate.of(right(case) for case in cases)
        return Line(f"{name}: {what}", asked, str(found), met(found.share) if met else None)

    median = float(np.median(errors))
    return [
        rate("detected", "", lambda c: c.alarmed, None),
        rate("located first", f"≥ {100 * bars.located:.0f} %", lambda c: c.located, lambda p: p >= bars.located),
        rate("place of the first effect accepted", "", lambda c: c.effect_located, None),
        Line(f"{name}: held-out RMS, median", f"≤ {bars.median} std", _quantiles(errors), median <= bars.median),
        rate(
            "held-out RMS below 1",
            f"≥ {100 * bars.below_one:.0f} %",
            lambda c: _error(c) < 1.0,
            lambda p: p >= bars.below_one,
        ),
        rate("held-out RMS below 0.5", "", lambda c: _error(c) < 0.5, None),
        Line(f"{name}: the same by the base model", "", _quantiles([_base(case) for case in cases]), None),
        rate("readings predicted worse than by base, > 2 %", "never", _worse, lambda p: p == 0),
        rate("known physics named wrongly, p > 0.5", "≤ 3 %", lambda c: bool(c.misnamed), lambda p: p <= 0.03),
        Line(f"{name}: wrong names a case", "", f"{np.mean([len(c.misnamed) for c in cases]):.2f}", None),
        _strays(name, cases),
        Line(f"{name}: verdicts", "", _verdicts(cases), None),
    ]


def _strays(name: str, cases: Sequence[Judged]) -> Line:
    """Entries a case at parts that have nothing to do with it, with the standard error of the mean."""
    counts = np.array([len(case.strays) for case in cases], dtype=float)
    error = counts.std(ddof=1) / np.sqrt(len(counts)) if len(counts) > 1 else float("nan")
    text = f"{counts.mean():.2f} ± {error:.2f} ({int(counts.sum())} in {len(cases)} cases)"
    what = f"{name}: effects at parts that have nothing to do with it, a case"
    return Line(what, "≤ 0.2", text, bool(counts.mean() <= 0.2))


def _error(case: Judged) -> float:
    return case.predicted.model if case.predicted else float("inf")


def _base(case: Judged) -> float:
    return case.predicted.base if case.predicted else float("nan")


def _worse(case: Judged) -> bool:
    return case.predicted is None or case.predicted.model_read > 1.02 * case.predicted.base_read


def _quantiles(errors: Sequence[float] | np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> str:
    low, middle, high = np.nanquantile(np.asarray(errors, dtype=float), [0.1, 0.5, 0.9], method="nearest")
    return f"{middle:.2f} std (10 % {low:.2f}, 90 % {high:.2f})"


def _verdicts(cases: Sequence[Judged]) -> str:
    counted = Counter(case.answer.verdict if case.answer else "no answer" for case in cases)
    return ", ".join(f"{verdict} {count}" for verdict, count in counted.most_common())


def _consistent(cases: Sequence[Judged]) -> list[Line]:
    if not cases:
        return []
    alarms = Rate.of(case.alarmed or bool(case.problem) for case in cases)
    worse = Rate.of(_worse(case) for case in cases)
    return [
        Line("consistent: alarms", "≤ 2 %", str(alarms), alarms.share <= 0.02),
        Line("consistent: readings predicted worse than by base, > 2 %", "never", str(worse), worse.hits == 0),
        Line("consistent: verdicts", "", _verdicts(cases), None),
    ]


def _probabilities(cases: Sequence[Judged]) -> list[Line]:
    """Calibration of the probability of the component that is named first."""
    given = [(c.answer.candidates[0], c.parts) for c in cases if c.answer and c.answer.candidates and c.parts]
    if not given:
        return [Line("probabilities of locations", "", "none given", None)]
    lines = []
    for low, high in pairwise(BINS):
        own = [(name in parts) for (name, p), parts in given if low <= p < high or p == high == 1.0]
        near = (low, high) == (0.85, 0.95)
        rate = Rate.of(own)
        met = (rate.interval[0] <= 0.9 <= rate.interval[1]) if near and own else None
        what = f"located right where given {100 * low:.0f}-{100 * high:.0f} %"
        lines.append(Line(what, "90 %" if near else "", str(rate), met))
    return lines


def _bands(cases: Sequence[Judged]) -> list[Line]:
    shares = [share for case in cases for share in case.coverage]
    possible = sum(len(effect["curves"]) for case in cases for effect in case.truth["effects"])
    if not shares:
        return [Line("true curve inside the law's 95 % band", "90-98 %", f"no law for {possible} curves", None)]
    mean = float(np.mean(shares))
    text = f"{100 * mean:.0f} % of the points ({len(shares)} laws for {possible} curves)"
    return [Line("true curve inside the law's 95 % band", "90-98 %", text, 0.90 <= mean <= 0.98)]


def _deviations(cases: Sequence[Judged]) -> list[Line]:
    each = [c.predicted.standardised for c in cases if c.predicted and len(c.predicted.standardised)]
    if not each:
        return []
    inside = [float(np.mean(np.abs(z) < 1.96)) for z in each]
    text = f"{100 * np.mean(inside):.0f} % (median of cases {100 * np.median(inside):.0f} %, {len(inside)} cases)"
    return [Line("true values within 1.96 predicted standard deviations", "95 %", text, None)]


def _cost(cases: Sequence[Judged]) -> list[Line]:
    times = np.array([case.outcome.cpu_s for case in cases])
    small = np.array([case.outcome.cpu_s for case in cases if case.truth["rows"] <= _ROWS])
    memory = np.array([case.outcome.memory_MB for case in cases])

    def spread(values: np.ndarray[tuple[int, ...], np.dtype[np.float64]], unit: str) -> str:
        values = values[np.isfinite(values)]
        return f"median {np.median(values):.1f}, longest {values.max():.1f} {unit}" if len(values) else "none"

    met = bool(np.nanmax(small) <= _SECONDS) if len(small) and np.isfinite(small).any() else None
    return [
        Line(f"processor time, up to {_ROWS} rows", f"≤ {_SECONDS:.0f} s", spread(small, "s"), met),
        Line("processor time, all", "", spread(times, "s"), None),
        Line(
            "memory",
            "< 2048 MB",
            spread(memory, "MB").replace("longest", "largest"),
            bool(np.nanmax(memory) < _MEMORY_MB),
        ),
    ]


def by_kind(cases: Sequence[Judged]) -> list[list[str]]:
    """Per kind that was alone: cases, detected, located, held-out RMS before and after, what was said."""
    rows = []
    alone = [case for case in cases if len(case.truth["effects"]) == 1]
    for name in sorted({case.truth["effects"][0]["physics"] for case in alone}):
        own = [case for case in alone if case.truth["effects"][0]["physics"] == name]
        said = Counter(case.answer.effects[0].physics if case.answer and case.answer.effects else "-" for case in own)
        before, after = (float(np.median([of(case) for case in own])) for of in (_base, _error))
        counts = [sum(case.alarmed for case in own), sum(case.located for case in own)]
        named = ", ".join(f"{physics} {count}" for physics, count in said.most_common())
        rows.append([name, str(len(own)), *map(str, counts), f"{before:.2f}", f"{after:.2f}", named])
    return rows


def by_case(cases: Sequence[Judged]) -> list[list[str]]:
    """Per case: what is there and how large, what was said, held-out RMS, strays, processor time."""
    rows = []
    for case in cases:
        answer = case.answer
        first = str(answer.effects[0]) if answer and answer.effects else "-"
        rows.append(
            [
                case.name.removeprefix("case-"),
                f"{case.truth['robot']}, {case.truth['rows']} rows",
                case.description() if case.truth["effects"] else f"nothing (made for {case.truth['made_for'][0]})",
                answer.verdict if answer else "no answer",
                ", ".join(answer.location) if answer and answer.location else "-",
                ("yes" if case.located else "**no**") if case.truth["effects"] else "",
                f"{_base(case):.2f}",
                f"{_error(case):.2f}",
                first,
                str(len(case.strays)),
                f"{case.outcome.cpu_s:.1f}",
            ]
        )
    return rows


CASE_BY_CASE = ("case", "machine", "there", "verdict", "located at", "right", "base", "model", "first", "strays", "s")


def markdown(cases: Sequence[Judged], title: str, facts: Sequence[str]) -> str:
    """The whole report."""
    families = Counter(case.family for case in cases)
    counted = ", ".join(f"{family} {count}" for family, count in sorted(families.items()))
    lines = [f"# {title}", "", *(f"- {fact}" for fact in facts), f"- {len(cases)} cases: {counted}", ""]
    lines += [
        "± is the binomial standard error, the interval Wilson's. Held-out RMS: predicted less true deflection, in"
    ]
    lines += ["standard deviations of the readings, on series that the diagnosis never saw.", ""]
    words = {True: "yes", False: "**no**", None: ""}
    cells = [
        [line.what.replace("  ", "&nbsp;&nbsp;"), line.asked, line.found, words[line.met]] for line in table(cases)
    ]
    lines += grid(["", "asked", "found", "met"], cells)
    head = ["physics", "cases", "detected", "located", "base", "model", "named first"]
    lines += ["", "## One piece of physics at a time", "", *grid(head, by_kind(cases))]
    lines += ["", "## Failures, one by one", ""]
    for case in cases:
        if faults := case.faults():
            said = str(case.answer) if case.answer else case.problem
            truth = f"{case.family}, {case.truth['robot']}, {case.truth['rows']} rows"
            lines.append(f"- {case.name} ({truth}): {', '.join(faults)}. There: {case.description()}. Said: {said}.")
    return "\n".join(lines) + "\n"


def grid(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """A table in Markdown."""
    return [f"| {' | '.join(row)} |" for row in (head, ["---"] * len(head), *rows)]


def frame(cases: Sequence[Judged]) -> pd.DataFrame:
    """One row per case."""
    rows = []
    for case in cases:
        predicted = case.predicted
        rows.append(
            {
                "case": case.name,
                "family": case.family,
                "robot": case.truth["robot"],
                "rows": case.truth["rows"],
                "mismatch_in_std": round(case.truth["mismatch_in_std"], 3),
                "truth": case.description(),
                "answer": str(case.answer) if case.answer else "",
                "located": case.located,
                "strays": len(case.strays),
                "faults": "; ".join(case.faults()),
                "later_base": predicted.base if predicted else None,
                "later_model": predicted.model if predicted else None,
                "readings_base": predicted.base_read if predicted else None,
                "readings_model": predicted.model_read if predicted else None,
                "cpu_s": round(case.outcome.cpu_s, 2),
                "memory_MB": round(case.outcome.memory_MB, 1),
            }
        )
    return pd.DataFrame(rows)

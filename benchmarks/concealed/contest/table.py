"""Results side by side, with the intervals that chance makes: Wilson's for shares, the bootstrap's for medians."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import pandas as pd

from ..rates import Rate, grid
from .judgement import Judged

CLASSES = (("listed", "few"), ("listed", "many"), ("unlisted", "few"), ("unlisted", "many"))
_RESAMPLES = 2000
HEAD = ["tool", "located", "named", "wrong name", "held-out RMS", "below 1", "worse than base", "no answer", "cost (s)"]


def median_interval(values: Sequence[float], seed: int = 1) -> tuple[float, float, float]:
    """Median and its 95 % percentile-bootstrap interval (B. Efron, Ann. Statist. 7 (1979) 1). Infinities count."""
    sample = np.sort(np.asarray(values, dtype=float))
    if not len(sample):
        return float("nan"), float("nan"), float("nan")
    drawn = np.random.default_rng(seed).integers(len(sample), size=(_RESAMPLES, len(sample)))
    medians = np.sort(_median(sample[drawn]))
    low, high = medians[int(0.025 * _RESAMPLES)], medians[int(0.975 * _RESAMPLES) - 1]
    return float(_median(sample[None])[0]), float(low), float(high)


def _median(
    samples: np.ndarray[tuple[int, ...], np.dtype[np.float64]],
) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Medians of rows, of which some values may be infinite."""
    ordered, count = np.sort(samples, axis=1), samples.shape[1]
    return np.asarray((ordered[:, (count - 1) // 2] + ordered[:, count // 2]) / 2)


def share(cases: Sequence[Judged], right: Callable[[Judged], bool]) -> str:
    """A share with its Wilson interval, in percent."""
    rate = Rate.of(right(case) for case in cases)
    if not rate.total:
        return "–"
    low, high = rate.interval
    return f"{100 * rate.share:.0f} % ({100 * low:.0f}–{100 * high:.0f})"


def middle(values: Sequence[float]) -> str:
    """A median with its bootstrap interval."""
    median, low, high = median_interval(values)
    return f"{median:.2f} ({low:.2f}–{high:.2f})"


def lines_of(cases: Sequence[Judged]) -> list[list[str]]:
    """One line per tool, in the order in which the tools were asked."""
    return [_line(tool, [case for case in cases if case.tool == tool]) for tool in tools_of(cases)]


def tools_of(cases: Sequence[Judged]) -> list[str]:
    """Names of the tools in the order in which they were asked."""
    return list(dict.fromkeys(case.tool for case in cases))


def _line(tool: str, own: Sequence[Judged]) -> list[str]:
    return [
        tool,
        share(own, lambda case: case.located),
        share(own, lambda case: case.named),
        share(own, lambda case: case.misnamed),
        middle([case.error for case in own]),
        share(own, lambda case: case.error < 1.0),
        share(own, lambda case: case.worse),
        share(own, lambda case: case.answer is None),
        middle([case.cost.cpu_s for case in own]),
    ]


def markdown(cases: Sequence[Judged], facts: Sequence[str]) -> str:
    """The tables of every class, of all classes together, of consistent cases, and the reasons of missing answers."""
    hidden = [case for case in cases if case.physics != "none"]
    lines = [*(f"- {fact}" for fact in facts), ""]
    for physics, extent in CLASSES:
        own = [case for case in hidden if (case.physics, case.extent) == (physics, extent)]
        if own:
            lines += [f"### {physics.capitalize()} physics, {extent} rows ({_sizes(own)})", ""]
            lines += [*grid(HEAD, lines_of(own)), ""]
    if hidden:
        lines += [f"### All with a mismatch ({_sizes(hidden)})", "", *grid(HEAD, lines_of(hidden)), ""]
    consistent = [case for case in cases if case.physics == "none"]
    if consistent:
        lines += [f"### Consistent ({_sizes(consistent)})", "", *grid(*_consistent(consistent)), ""]
    missing = sorted({(case.tool, case.case, case.problem) for case in cases if case.problem})
    if missing:
        lines += ["### No answer", "", *(f"- {tool}, {case}: {problem}" for tool, case, problem in missing), ""]
    return "\n".join(lines)


def _consistent(cases: Sequence[Judged]) -> tuple[list[str], list[list[str]]]:
    found = []
    for tool in tools_of(cases):
        own = [case for case in cases if case.tool == tool]
        alarms = share(own, lambda case: case.detected)
        found.append([tool, alarms, middle([case.error for case in own]), share(own, lambda case: case.worse)])
    return ["tool", "false alarms", "held-out RMS", "worse than base"], found


def _sizes(cases: Sequence[Judged]) -> str:
    rows = [case.truth["rows"] for case in cases]
    return f"{len({(case.truth['seed'], case.case) for case in cases})} cases, {min(rows)}–{max(rows)} rows"


def agreement(first: Sequence[Judged], second: Sequence[Judged]) -> str:
    """Figures of two rounds side by side, over all cases with a mismatch, and whether their intervals overlap."""
    rows = []
    for tool in tools_of(first):
        own, other = ([c for c in each if c.tool == tool and c.physics != "none"] for each in (first, second))
        for what, right in _SHARES.items():
            one, two = (Rate.of(right(case) for case in each).interval for each in (own, other))
            rows.append([tool, what, share(own, right), share(other, right), _overlap(one, two)])
        one, two = (median_interval([case.error for case in each])[1:] for each in (own, other))
        middles = [middle([case.error for case in each]) for each in (own, other)]
        rows.append([tool, "held-out RMS", *middles, _overlap(one, two)])
    agreeing = sum(row[-1] == "yes" for row in rows)
    head = ["tool", "figure", "first round", "second round", "overlap"]
    return "\n".join([*grid(head, rows), "", f"Intervals of {agreeing} of {len(rows)} figures overlap.", ""])


_SHARES: dict[str, Callable[[Judged], bool]] = {
    "located": lambda case: case.located,
    "named": lambda case: case.named,
    "below 1": lambda case: case.error < 1.0,
    "worse than base": lambda case: case.worse,
}


def _overlap(one: tuple[float, float], other: tuple[float, float]) -> str:
    return "yes" if one[0] <= other[1] and other[0] <= one[1] else "**no**"


def frame(cases: Sequence[Judged]) -> pd.DataFrame:
    """One row per case and tool."""
    return pd.DataFrame([case.row() for case in cases])

"""The page of a round of cases: what must be shown family by family, kinds of physics, failures one by one."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pandas as pd

from .judgement import NAMED, STRANGE, Judged
from .linear_model import Array
from .rates import Rate, grid

OUTSIDE = ("alone", "pair", "beside", "form")
BINS = (0.0, 0.5, 0.7, 0.85, 0.95, 0.99, 1.0)
_SECONDS, _MEMORY_MB, _ROWS = 10.0, 2048.0, 100


@dataclass(frozen=True)
class Line:
    """One line of the table: what is asked, what was found, whether that is enough (None: not asked for)."""

    what: str
    asked: str
    found: str
    met: bool | None


@dataclass(frozen=True)
class Asked:
    """Of families that are judged by places and predictions: share located first, held-out RMS in the median (standard
    deviations), share below 1.
    """

    name: str
    families: tuple[str, ...]
    located: float
    median: float = 0.5
    below_one: float = 0.8


ASKED = (
    Asked("outside the library", OUTSIDE, 0.80),
    Asked("physics left out of the library", ("left_out",), 0.75),
    Asked("second source", ("second_source",), 0.90, 0.6, 0.7),
    Asked("third source", ("third_source",), 0.90, 0.5, 0.75),
)


def table(cases: Sequence[Judged]) -> list[Line]:
    """Every line of the table; families that were not drawn have no lines."""
    lines = _named(cases)
    for asked in ASKED:
        lines += _family(asked, [case for case in cases if case.family in asked.families])
    lines += _consistent([case for case in cases if case.family == "none"])
    for family in OUTSIDE:
        own = [case for case in cases if case.family == family]
        if own:
            lines.append(_share(f"  {family}: located first", "", own, lambda case: case.located))
            lines.append(Line(f"  {family}: held-out RMS", "", _quantiles([case.error for case in own]), None))
    return lines + _probabilities(cases) + _bands(cases) + _deviations(cases) + _cost(cases)


def _share(what: str, asked: str, cases: Sequence[Judged], right: Callable[[Judged], bool]) -> Line:
    """A share of cases and whether it is what is asked for: `≥ 90 %`, `≤ 3 %`, `all`, `never` or nothing."""
    rate = Rate.of(right(case) for case in cases)
    if not asked or not rate.total:
        return Line(what, asked, str(rate), None)
    words = {"all": ("≥", 1.0), "never": ("≤", 0.0)}
    sign, bar = words[asked] if asked in words else (asked[0], float(asked.split()[1]) / 100)
    return Line(what, asked, str(rate), rate.share >= bar if sign == "≥" else rate.share <= bar)


def _named(cases: Sequence[Judged]) -> list[Line]:
    """Physics of the library that shall be named, and what shall be said to be none of it."""
    one, two = ([case for case in cases if case.family == family] for family in NAMED)
    known, strange = one + two, [case for case in cases if case.family == STRANGE]
    lines = []
    if known or strange:
        lines.append(_share("mismatches detected", "≥ 97 %", known + strange, lambda case: case.alarmed))
    if known:
        lines += [
            _share("right physics first", "≥ 90 %", known, lambda case: case.first_right),
            _share("right physics first or in its group", "≥ 96 %", known, lambda case: case.first_or_group_right),
            _share("right component", "≥ 92 %", known, lambda case: case.component_right),
            _share("both of two effects found (groups count)", "≥ 80 %", two, lambda case: case.both_found()),
            _share("  one effect: right physics first", "", one, lambda case: case.first_right),
            _share("  one effect: further effects concluded", "", one, lambda case: len(case.effects) > 1),
            _share("  two effects: one of them first", "", two, lambda case: case.first_right),
            _share("  two effects: both named themselves", "", two, lambda case: case.both_found(groups=False)),
            _share("  two effects: a third concluded", "", two, lambda case: len(case.effects) > 2),
        ]
    if strange:
        lines.append(_share("unexplained or unknown where it shall be", "all", strange, lambda c: c.declared_unknown))
        lines.append(_share("  known physics concluded there (p > 0.5)", "", strange, lambda case: bool(case.misnamed)))
    return lines + _floors(known + strange) + _conclusions(known + strange)


def _floors(cases: Sequence[Judged]) -> list[Line]:
    """Held-out RMS over the noise floor, as the diagnosis declares it and on the judge's own series."""
    explained = [case for case in cases if case.answer and case.answer.verdict == "explained"]
    declared = [case.declared_ratio for case in explained if case.declared_ratio is not None]
    own = [c.predicted.model_read / c.truth["later_noise_rms"] for c in explained if c.predicted]
    lines = []
    for source, ratios in (("as declared", declared), ("on further series", own)):
        if ratios:
            middle, what = float(np.median(ratios)), "held-out RMS / noise floor, median of explained, "
            lines.append(Line(what + source, "≤ 1.15", f"{middle:.3f} ({len(ratios)} cases)", middle <= 1.15))
    if cases:
        lines.append(_share("readings predicted worse than by base, > 2 %", "never", cases, lambda case: case.worse))
    return lines


def _conclusions(cases: Sequence[Judged]) -> list[Line]:
    """Calibration of the probabilities of effects at their components."""
    given = [(each.probability, right) for case in cases for each, right in case.conclusions()]
    what, asked = "right of the conclusions given", "90 ± 5 %"
    return _calibration(what, given, asked, lambda rate: 0.85 <= rate.share <= 0.95) if given else []


def _calibration(
    what: str, given: Sequence[tuple[float, bool]], asked: str, enough: Callable[[Rate], bool]
) -> list[Line]:
    """Shares that are right where about so much probability is given; `enough` of the bin around 90 %."""
    lines = []
    for low, high in pairwise(BINS):
        rate = Rate.of(right for p, right in given if low <= p < high or p == high == 1.0)
        near = (low, high) == (0.85, 0.95)
        met = enough(rate) if near and rate.total else None
        lines.append(Line(f"{what} {100 * low:.0f}-{100 * high:.0f} %", asked if near else "", str(rate), met))
    return lines


def _family(asked: Asked, cases: Sequence[Judged]) -> list[Line]:
    if not cases:
        return []
    errors, name = np.array([case.error for case in cases]), asked.name

    def rate(what: str, bar: str, right: Callable[[Judged], bool]) -> Line:
        return _share(f"{name}: {what}", bar, cases, right)

    median = float(np.median(errors))
    return [
        rate("detected", "", lambda case: case.alarmed),
        rate("located first", f"≥ {100 * asked.located:.0f} %", lambda case: case.located),
        rate("place of the first effect accepted", "", lambda case: case.effect_located),
        Line(f"{name}: held-out RMS, median", f"≤ {asked.median} std", _quantiles(errors), median <= asked.median),
        rate("held-out RMS below 1", f"≥ {100 * asked.below_one:.0f} %", lambda case: case.error < 1.0),
        rate("held-out RMS below 0.5", "", lambda case: case.error < 0.5),
        Line(f"{name}: the same by the base model", "", _quantiles([case.base for case in cases]), None),
        rate("readings predicted worse than by base, > 2 %", "never", lambda case: case.worse),
        rate("known physics named wrongly, p > 0.5", "≤ 3 %", lambda case: bool(case.misnamed)),
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


def _quantiles(errors: Sequence[float] | Array) -> str:
    low, middle, high = np.nanquantile(np.asarray(errors, dtype=float), [0.1, 0.5, 0.9], method="nearest")
    return f"{middle:.2f} std (10 % {low:.2f}, 90 % {high:.2f})"


def _verdicts(cases: Sequence[Judged]) -> str:
    counted = Counter(case.answer.verdict if case.answer else "no answer" for case in cases)
    return ", ".join(f"{verdict} {count}" for verdict, count in counted.most_common())


def _consistent(cases: Sequence[Judged]) -> list[Line]:
    if not cases:
        return []
    what = "consistent: readings predicted worse than by base, > 2 %"
    return [
        _share("consistent: alarms", "≤ 2 %", cases, lambda case: case.alarmed or bool(case.problem)),
        _share(what, "never", cases, lambda case: case.worse),
        Line("consistent: verdicts", "", _verdicts(cases), None),
    ]


def _probabilities(cases: Sequence[Judged]) -> list[Line]:
    """Calibration of the probability of the component that is named first."""
    given = [(c.answer.candidates[0], c.parts) for c in cases if c.answer and c.answer.candidates and c.parts]
    if not given:
        return [Line("probabilities of locations", "", "none given", None)]
    each = [(p, name in parts) for (name, p), parts in given]
    return _calibration("located right where given", each, "90 %", lambda r: r.interval[0] <= 0.9 <= r.interval[1])


def _bands(cases: Sequence[Judged]) -> list[Line]:
    shares = [share for case in cases for share in case.coverage]
    possible = sum(len(effect["curves"]) for case in cases for effect in case.truth["effects"])
    what = "true curve inside the law's 95 % band"
    if not shares:
        return [Line(what, "90-98 %", f"no law for {possible} curves", None)]
    mean = float(np.mean(shares))
    text = f"{100 * mean:.0f} % of the points ({len(shares)} laws for {possible} curves)"
    return [Line(what, "90-98 %", text, 0.90 <= mean <= 0.98)]


def _deviations(cases: Sequence[Judged]) -> list[Line]:
    each = [c.predicted.standardised for c in cases if c.predicted and len(c.predicted.standardised)]
    if not each:
        return []
    inside = [float(np.mean(np.abs(z) < 1.96)) for z in each]
    text = f"{100 * np.mean(inside):.0f} % (median of cases {100 * np.median(inside):.0f} %, {len(inside)} cases)"
    return [Line("true values within 1.96 predicted standard deviations", "95 %", text, None)]


def _cost(cases: Sequence[Judged]) -> list[Line]:
    def line(what: str, asked: str, values: list[float], unit: str, most: float = np.inf) -> Line:
        known = np.array([value for value in values if np.isfinite(value)])
        text = f"median {np.median(known):.1f}, largest {known.max():.1f} {unit}" if len(known) else "none"
        return Line(what, asked, text, bool(known.max() <= most) if asked and len(known) else None)

    small = [case.outcome.cpu_s for case in cases if case.truth["rows"] <= _ROWS]
    return [
        line(f"processor time, up to {_ROWS} rows", f"≤ {_SECONDS:.0f} s", small, "s", _SECONDS),
        line("processor time, all", "", [case.outcome.cpu_s for case in cases], "s"),
        line("memory", "< 2048 MB", [case.outcome.memory_MB for case in cases], "MB", _MEMORY_MB),
    ]


KIND = ("physics", "cases", "detected", "located", "named", "base", "model", "named first")


def by_kind(cases: Sequence[Judged]) -> list[list[str]]:
    """Per kind that was alone: cases, detected, located, rightly named first, held-out RMS before and after, names."""
    rows = []
    alone = [case for case in cases if len(case.truth["effects"]) == 1]
    for name in sorted({case.physics[0] for case in alone}):
        own = [case for case in alone if case.physics == [name]]
        said = Counter(case.effects[0].physics if case.effects else _without(case) for case in own)
        errors = (f"{np.median(each):.2f}" for each in ([c.base for c in own], [c.error for c in own]))
        counts = [sum(case.alarmed for case in own), sum(case.located for case in own), sum(c.first_right for c in own)]
        named = ", ".join(f"{physics} {count}" for physics, count in said.most_common())
        rows.append([name, str(len(own)), *map(str, counts), *errors, named])
    return rows


def _without(case: Judged) -> str:
    return f"({case.answer.verdict})" if case.answer else "(no answer)"


CASE_BY_CASE = ("case", "machine", "there", "verdict", "located at", "right", "base", "model", "first", "strays", "s")


def by_case(cases: Sequence[Judged]) -> list[list[str]]:
    """Per case: what is there and how large, what was said, held-out RMS, strays, processor time."""
    return [
        [
            case.name.removeprefix("case-"),
            f"{case.truth['robot']}, {case.truth['rows']} rows",
            case.description() if case.truth["effects"] else f"nothing (made for {case.truth['made_for'][0]})",
            case.answer.verdict if case.answer else "no answer",
            ", ".join(case.answer.location) if case.answer and case.answer.location else "-",
            ("yes" if case.located else "**no**") if case.truth["effects"] else "",
            f"{case.base:.2f}",
            f"{case.error:.2f}",
            str(case.effects[0]) if case.effects else "-",
            str(len(case.strays)),
            f"{case.outcome.cpu_s:.1f}",
        ]
        for case in cases
    ]


def markdown(cases: Sequence[Judged], title: str, facts: Sequence[str], every: bool = False) -> str:
    """The whole page; with `every` also a table case by case."""
    counted = [f"{len(cases)} cases: {_counts(case.family for case in cases)}"]
    counted.append(f"robots: {_counts(case.truth['robot'] for case in cases)}")
    words = {True: "yes", False: "**no**", None: ""}
    cells = [[x.what.replace("  ", "&nbsp;&nbsp;"), x.asked, x.found, words[x.met]] for x in table(cases)]
    lines = [
        *(f"# {title}", "", *(f"- {fact}" for fact in [*facts, *counted]), ""),
        "± is the binomial standard error, the interval Wilson's. Held-out RMS: predicted less true deflection, in",
        "standard deviations of the readings, on series that the diagnosis never saw.",
        *("", *grid(["", "asked", "found", "met"], cells)),
        *("", "## One piece of physics at a time", "", *grid(KIND, by_kind(cases))),
        *("", "## Failures, one by one", ""),
    ]
    failures = [(case, faults) for case in cases if (faults := case.faults())]
    for case, faults in failures:
        said = str(case.answer) if case.answer else case.problem
        truth = f"{case.family}, {case.truth['robot']}, {case.truth['rows']} rows"
        lines.append(f"- {case.name} ({truth}): {', '.join(faults)}. There: {case.description()}. Said: {said}.")
    lines += [] if failures else ["None."]
    if every:
        lines += ["", "## Case by case", ""]
        lines += [
            "Base and model: held-out RMS in standard deviations of the readings against the true values. Strays:"
        ]
        lines += ["effects, laws included, at parts that have nothing to do with it. s: processor time.", ""]
        lines += grid(CASE_BY_CASE, by_case(cases))
    return "\n".join(lines) + "\n"


def _counts(names: Iterable[str]) -> str:
    return ", ".join(f"{name} {count}" for name, count in sorted(Counter(names).items()))


def frame(cases: Sequence[Judged]) -> pd.DataFrame:
    """One row per case."""
    return pd.DataFrame(
        {
            "case": case.name,
            "family": case.family,
            "robot": case.truth["robot"],
            "rows": case.truth["rows"],
            "mismatch_in_std": round(case.truth["mismatch_in_std"], 3),
            "truth": case.description(),
            "answer": str(case.answer) if case.answer else "",
            "located": case.located,
            "first_right": case.first_right,
            "strays": len(case.strays),
            "faults": "; ".join(case.faults()),
            "declared_ratio": case.declared_ratio,
            "later_base": case.predicted.base if case.predicted else None,
            "later_model": case.predicted.model if case.predicted else None,
            "readings_base": case.predicted.base_read if case.predicted else None,
            "readings_model": case.predicted.model_read if case.predicted else None,
            "wall_s": round(case.outcome.wall_s, 2),
            "cpu_s": round(case.outcome.cpu_s, 2),
            "memory_MB": round(case.outcome.memory_MB, 1),
        }
        for case in cases
    )

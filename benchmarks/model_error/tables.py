"""The tables of a closed loop with hidden physics, from its trials."""

from __future__ import annotations

import textwrap
from pathlib import Path

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray

_NORMAL_95 = 1.96


def readme(folder: Path, command: str, place: str, more: float, unsought: frozenset[str]) -> str:
    """The result as Markdown, from `trials.csv` and `criteria.csv` of a folder."""
    trials = pd.read_csv(folder / "trials.csv", keep_default_na=False)
    criteria = pd.read_csv(folder / "criteria.csv").set_index("plan")
    hiding, healthy = trials[trials["physics"] != ""], trials[trials["physics"] == ""]
    count, sound = hiding["machine"].nunique(), healthy["machine"].nunique()
    told = (
        f"{count} machines that hide one effect each and {sound} that hide none, {place}; "
        f"{trials['seconds'].sum():.0f} s of processor time. The kinds of physics go round the list, components are "
        "drawn, parameters are normal with the prior sizes of MEIR (times `--factor`), compliances Wishart with those "
        "means. True stiffnesses are scattered. Every plan is measured once on every machine with the same seed of the "
        "noise; random plans are drawn anew. `MEIR bounded` is the plan of least MEIR on the front of total and MEIR "
        f"that costs at most {100 * more:g} % more total error. Noticed: the verdict is not `consistent`. Right: the "
        "hidden physics is named at its component, or given as indistinguishable from what is named there. The "
        f"diagnosis is not offered {', '.join(sorted(unsought))}. Errors are at the targets after compensation, in "
        "tolerances; ± is half a 95 % interval of the mean. Differences are to the plan by `total`, machine by machine."
    )
    parts = [
        "# Plans on machines that hide physics", f"```\n{command}\n```", "\n".join(textwrap.wrap(told, 120)),
        "## Machines that hide one effect", summary(hiding, criteria, "right"),
    ]  # fmt: skip
    if sound:
        parts += ["## Machines that hide nothing", summary(healthy, criteria, "nothing named")]
    parts += ["## Where nothing is noticed", unnoticed(hiding), "## By physics", by_physics(hiding)]
    return "\n\n".join(parts) + "\n"


def summary(trials: pd.DataFrame, criteria: pd.DataFrame, right: str) -> str:
    """A row per plan."""
    head = ["plan", "total", "MEIR", "noticed", right, "error (mean)", "median", "95 % below", "minus `total`",
            "without diagnosis"]  # fmt: skip
    reference = _by_machine(trials, "total", "error")
    rows = []
    for name in trials["plan"].unique():
        here = trials[trials["plan"] == name]
        errors = here["error"].to_numpy(float)
        difference = _by_machine(trials, name, "error") - reference
        promised = [f"{criteria.loc[name, c]:.3f}" if name in criteria.index else "–" for c in ("total", "meir")]
        rows.append([
            name, *promised, _share(here["noticed"]), _share(here["right"]), _mean(errors), f"{np.median(errors):.3f}",
            f"{np.quantile(errors, 0.95):.3f}", "–" if name == "total" else _mean(difference, signed=True),
            _mean(here["undiagnosed"].to_numpy(float)),
        ])  # fmt: skip
    return _table(head, rows)


def unnoticed(trials: pd.DataFrame) -> str:
    """What is attained where the recordings look consistent: the error that stays hidden."""
    head = ["plan", "machines", "error (mean)", "95 % below", "largest", "largest on"]
    rows = []
    for name in trials["plan"].unique():
        here = trials[(trials["plan"] == name) & (trials["verdict"] == "consistent")]
        if here.empty:
            continue
        errors = here["error"].to_numpy(float)
        worst = here.iloc[int(np.argmax(errors))]
        rows.append([name, str(len(here)), _mean(errors), f"{np.quantile(errors, 0.95):.3f}", f"{errors.max():.3f}",
                     f"{worst['physics']}, {worst['component']}"])  # fmt: skip
    return _table(head, rows)


def by_physics(trials: pd.DataFrame) -> str:
    """Mean error and share of right diagnoses of every plan, by what is hidden."""
    plans = list(trials["plan"].unique())
    rows = []
    for physics, here in trials.groupby("physics"):
        cells = []
        for name in plans:
            chosen = here[here["plan"] == name]
            right = chosen["right"].to_numpy(float).mean()
            cells.append(f"{chosen['error'].mean():.3f} ({100 * right:.0f} %)")
        rows.append([str(physics), str(here["machine"].nunique()), *cells])
    return "Mean error, and share diagnosed right.\n\n" + _table(["physics", "machines", *plans], rows)


def _by_machine(trials: pd.DataFrame, plan: str, column: str) -> FloatArray:
    values: FloatArray = trials[trials["plan"] == plan].sort_values("machine")[column].to_numpy(float)
    return values


def _mean(values: FloatArray, *, signed: bool = False) -> str:
    half = _NORMAL_95 * values.std(ddof=1) / np.sqrt(len(values)) if len(values) > 1 else float("nan")
    return f"{values.mean():{'+' if signed else ''}.3f} ± {half:.3f}"


def _share(values: pd.Series) -> str:
    yes = values.astype(str).eq("True").to_numpy()
    half = _NORMAL_95 * np.sqrt(max(yes.mean() * (1.0 - yes.mean()), 1e-12) / len(yes))
    return f"{100 * yes.mean():.0f} ± {100 * half:.0f} %"


def _table(head: list[str], rows: list[list[str]]) -> str:
    return "\n".join(f"| {' | '.join(row)} |" for row in (head, ["---"] * len(head), *rows))

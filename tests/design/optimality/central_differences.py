"""Exact gradients of every criterion with respect to every continuous design variable, and a check of them that anyone
can run on a configuration: central differences at several step sizes.

No single step suits every variable: the error of a central difference is of the order of h² by truncation and of ε/h by
rounding. An exact gradient shows as differences that shrink with the step and grow again, a wrong one as differences
that stay.
"""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray
from expdesign.chain.instrument.deflection_noise import series_by_pose
from expdesign.errors import InputError
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.optimality.differentiated import Differentiated
from expdesign.planning.problem import DesignProblem


def criterion_gradients(
    problem: DesignProblem, variables: FloatArray, names: Sequence[str]
) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Values (b,) and gradients (b, m, g) of criteria of designs with variables (b, m, g).

    The gradient with respect to a discrete variable is 0. Where a design leaves parameters unidentified the value is
    NaN and the gradient 0. Where a criterion is a maximum, the gradient is that of its largest piece. Measurements that
    share their unloaded measurement are differentiated as if they kept sharing it.
    """
    designs = Differentiated.of_designs(problem, variables)
    found = {}
    for name in names:
        piece = designs.pieces(known_criteria()[name])[0]
        found[name] = (piece.value, piece.gradient())
    return found


STEPS = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
"""Sizes of the steps, in parts of a variable's range."""
ACCEPTED = 1e-5
"""Largest relative difference, each variable at its best step, with which a gradient passes."""


def gradient_table(
    problem: DesignProblem, variables: FloatArray, names: Sequence[str] | None = None, steps: Sequence[float] = STEPS
) -> pd.DataFrame:
    """One row per criterion: the largest relative difference over all variables at each step size, and the verdict.

    Args:
        problem: of a configuration.
        variables: designs, shape (b, m, g).
        names: of the criteria; all of them where left out.
        steps: in parts of each variable's range.

    Returns:
        Columns `quantity`, one per step, `at best steps` (each variable at its own best step, the largest of these),
        `worst variable`, and `verdict`: `pass`, `fail`, or `not evaluated` where there is no exact gradient or no
        value at these designs.
    """
    columns = {step: f"{step:.0e}" for step in steps}
    rows: list[dict[str, str | float]] = []
    for name in known_criteria() if names is None else names:
        try:
            every = [_compared(problem, design, [name], steps).assign(design=k) for k, design in enumerate(variables)]
            found = pd.concat(every).dropna(subset="relative_error")
        except InputError:
            found = pd.DataFrame({"relative_error": []})
        if found.empty:
            rows.append({"quantity": name, "worst variable": "", "verdict": "not evaluated"})
            continue
        found = found.reset_index(drop=True)
        best = found.loc[found.groupby(["design", *_PLACE], sort=False)["relative_error"].idxmin()]
        worst = best.iloc[int(best["relative_error"].to_numpy().argmax())]
        rows.append(
            {
                "quantity": name,
                **{columns[step]: found.loc[found["part"] == step, "relative_error"].max() for step in steps},
                "at best steps": float(worst["relative_error"]),
                "worst variable": f"{worst['variable']} of measurement {worst['measurement']}",
                "verdict": "pass" if worst["relative_error"] <= ACCEPTED else "fail",
            }
        )
    return pd.DataFrame(rows, columns=["quantity", *columns.values(), "at best steps", "worst variable", "verdict"])


def variable_names(problem: DesignProblem) -> list[str]:
    """Names with units of the variables of one measurement, as they stand in a plan."""
    loaded, space = problem.loaded, problem.space
    load = loaded.load.columns[: space.n_load]
    names = (*loaded.robot.configuration, *load, *loaded.load.tilt, "setting")
    return [names[variable.columns[0]] if len(variable.columns) == 1 else "candidate" for variable in space.variables]


_PLACE = ["criterion", "measurement", "variable"]


def _compared(
    problem: DesignProblem, variables: FloatArray, names: Sequence[str], steps: Sequence[float]
) -> pd.DataFrame:
    """One row per criterion, measurement, continuous variable and step (`part` of the range) of a design (m, g).

    `relative_error` is |difference − gradient|, each in the criterion's change over the variable's range, relative to
    the largest of these changes, so that metres and radians can be compared; NaN where there is no gradient.
    """
    space = problem.space
    free = np.flatnonzero(~space.discrete)
    span, labels = (space.upper - space.lower)[free], [variable_names(problem)[variable] for variable in free]
    series = series_by_pose(space.decode(variables)[0])[None]
    exact = criterion_gradients(problem, variables[None], names)
    widths = np.array(steps)[:, None] * span
    tables = []
    for measurement in range(len(variables)):
        moved = np.tile(variables, (2, len(steps), len(free), 1, 1))
        for place, variable in enumerate(free):
            moved[0, :, place, measurement, variable] -= widths[:, place]
            moved[1, :, place, measurement, variable] += widths[:, place]
        flat = moved.reshape(-1, *variables.shape)
        assessment = problem.assess(*space.decode(flat), np.repeat(series, len(flat), axis=0))
        for name in names:
            value, slopes = exact[name][0][0], exact[name][1][0][:, free]
            low, high = known_criteria()[name].values(assessment).reshape(2, len(steps), len(free))
            with np.errstate(invalid="ignore", divide="ignore"):
                differences = (high - low) / (2.0 * widths) + (0.0 if np.isfinite(value) else np.nan)
            scale = max(float(np.abs(slopes * span).max(initial=0.0)), 1e-300)
            columns = {
                "criterion": name,
                "measurement": measurement + 1,
                "variable": np.tile(labels, len(steps)),
                "gradient": np.tile(slopes[measurement], len(steps)),
                "difference": differences.ravel(),
                "step": widths.ravel(),
                "relative_error": (np.abs(differences - slopes[measurement]) * span / scale).ravel(),
                "part": np.repeat(steps, len(free)),
            }
            tables.append(pd.DataFrame(columns))
    return pd.concat(tables, ignore_index=True)

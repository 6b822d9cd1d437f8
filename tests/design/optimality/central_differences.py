"""Exact gradients of criteria, and how far central differences are from them, each variable at its best step.

No single step suits every variable: the error of a central difference is of the order of h² by truncation and of ε/h by
rounding. Differences approach an exact gradient at some step, and a wrong one at none.
"""

from collections.abc import Sequence

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.deflection_noise import series_by_pose
from expdesign.planning.optimality.differentiated import Differentiated
from expdesign.planning.problem import DesignProblem

STEPS = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
"""Sizes of the steps, in parts of a variable's range."""


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


def errors_of_gradients(
    problem: DesignProblem, variables: FloatArray, names: Sequence[str] | None = None
) -> dict[str, float]:
    """|difference − gradient| of each criterion, the largest of all designs (b, m, g) and variables at their best step.

    Each is the criterion's change over the variable's range, relative to the largest of these changes, so that metres
    and radians can be compared. Where there is no value, it is 0.
    """
    space, names = problem.space, list(known_criteria() if names is None else names)
    free = np.flatnonzero(~space.discrete)
    span = (space.upper - space.lower)[free]
    widths = np.array(STEPS)[:, None] * span
    exact = criterion_gradients(problem, variables, names)
    largest = dict.fromkeys(names, 0.0)
    for design, measurement in np.ndindex(variables.shape[:2]):
        moved = np.tile(variables[design], (2, len(STEPS), len(free), 1, 1))
        for place, variable in enumerate(free):
            moved[0, :, place, measurement, variable] -= widths[:, place]
            moved[1, :, place, measurement, variable] += widths[:, place]
        flat = moved.reshape(-1, *variables.shape[1:])
        series = series_by_pose(space.decode(variables[design])[0])[None]
        assessment = problem.assess(*space.decode(flat), np.repeat(series, len(flat), axis=0))
        for name in names:
            slopes = exact[name][1][design][:, free] * span
            low, high = known_criteria()[name].values(assessment).reshape(2, len(STEPS), len(free))
            with np.errstate(invalid="ignore"):
                changes = (high - low) / (2.0 * np.array(STEPS)[:, None])
            scale = max(float(np.abs(slopes).max(initial=0.0)), 1e-300)
            errors = np.abs(changes - slopes[measurement]) / scale
            largest[name] = float(np.fmax(largest[name], np.fmax.reduce(np.fmin.reduce(errors))))
    return largest

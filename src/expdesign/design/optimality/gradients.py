"""Exact gradients of every criterion with respect to every continuous gene, and a check of them that anyone can run."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray
from expdesign.criteria.criterion import known_criteria
from expdesign.design.optimality.partials import pieces
from expdesign.design.optimality.sensitivity import DesignModel
from expdesign.design.problem import DesignProblem
from expdesign.instrument.deflection_noise import series_by_pose

STEPS = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
"""Sizes of the finite-difference steps of `gradient_check`, in parts of 1000 of a gene's range."""


def criterion_gradients(
    problem: DesignProblem, genes: FloatArray, names: Sequence[str]
) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Values (b,) and gradients (b, m, g) of criteria of designs with genes (b, m, g).

    The gradient with respect to a discrete gene is 0. Where a design leaves parameters unidentified the value is NaN
    and the gradient 0. Where a criterion is a maximum, the gradient is that of its largest piece. Measurements that
    share their unloaded measurement are differentiated as if they kept sharing it.
    """
    state = DesignModel(problem).run(genes)
    found = {}
    for name in names:
        piece = pieces(known_criteria()[name], state)[0]
        found[name] = (piece.value, piece.gradient(state))
    return found


def gradient_check(
    problem: DesignProblem, genes: FloatArray, names: Sequence[str] | None = None, steps: Sequence[float] = STEPS
) -> pd.DataFrame:
    """Compare the exact gradients with central differences of the criteria's own code at several step sizes.

    Args:
        problem: of a configuration.
        genes: one design, shape (m, g).
        names: of the criteria; all of them where left out.
        steps: in parts of 1000 of each gene's range. No single step suits every gene: a long one truncates, a short
            one rounds.

    Returns:
        One row per criterion and continuous gene: the gradient, the finite difference at the step that agrees best,
        that step, and the error relative to the largest derivative of the criterion (derivatives per gene's range, so
        that metres and radians can be compared).
    """
    names = list(known_criteria()) if names is None else names
    space = problem.space
    span = (space.upper - space.lower) * ~space.discrete
    series = series_by_pose(space.decode(genes)[0])[None]
    exact = criterion_gradients(problem, genes[None], names)
    differences = {name: np.full((len(steps), *genes.shape), np.nan) for name in names}
    for measurement in range(genes.shape[0]):
        for gene in np.flatnonzero(~space.discrete):
            for index, step in enumerate(steps):
                width = 1e-3 * step * span[gene]
                moved = np.stack([genes, genes])
                moved[0, measurement, gene] -= width
                moved[1, measurement, gene] += width
                assessment = problem.assess(*space.decode(moved), np.repeat(series, 2, axis=0))
                for name in names:
                    low, high = known_criteria()[name].values(assessment)
                    differences[name][index, measurement, gene] = (high - low) / (2.0 * width)
    rows = []
    for name in names:
        gradient = exact[name][1][0]
        scale = max(float(np.nanmax(np.abs(gradient * span), initial=0.0)), 1e-300)
        errors = np.abs(differences[name] - gradient) * span / scale
        for measurement, gene in np.argwhere(np.broadcast_to(~space.discrete, genes.shape)):
            best = int(np.nanargmin(errors[:, measurement, gene]))
            rows.append(
                {
                    "criterion": name,
                    "measurement": int(measurement) + 1,
                    "quantity": int(space.variables[gene].columns[0]),
                    "gradient": gradient[measurement, gene],
                    "difference": differences[name][best, measurement, gene],
                    "step": 1e-3 * steps[best] * span[gene],
                    "relative_error": errors[best, measurement, gene],
                }
            )
    return pd.DataFrame(rows)

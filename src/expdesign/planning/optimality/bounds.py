"""What no plan goes below: the bound of the convex relaxation (theory.md 10).

Bounds on `total` are of the best linear unbiased estimator, plans are judged by least squares: these weigh every
reading by the instrument's noise alone. The generalised least squares of Aitken (1936) count the load errors as well,
which is to estimate those that all measurements share along with the compliances, and the reference that a series
shares (theory.md 10.4, 10.6).
"""

from collections.abc import Callable

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.planning.criteria.accuracy import expected_total
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.criteria.information import Information
from expdesign.planning.optimality.certificate import Certificate, LowerBound
from expdesign.planning.problem import DesignProblem


def lower_bound(
    problem: DesignProblem, load_errors: float, known: FloatArray, ended: Callable[[], bool] = lambda: False
) -> LowerBound:
    """The bound of DUIR (`load_errors` 0) or of `total` (1) over all plans of as many measurements.

    Of `total` its words say what least squares lose against the estimator that the bound is of.

    Args:
        problem: the design problem.
        load_errors: see `MeasurementMaps`.
        known: designs (d, m, g) that can be measured, of which one at least identifies what the targets need.
        ended: whether there is no more time.
    """
    bound = Certificate(problem, load_errors).bound(known, ended)
    if bound.value is None or load_errors == 0.0:
        return bound
    totals = known_criteria()["total"].values(problem.assessed(known))
    best = int(np.nanargmin(totals))
    if totals[best] <= bound.value:
        return bound
    reached = best_linear_total(problem, known[best])
    price = (
        f"the best plan known is {totals[best] / bound.value - 1.0:.2%} above it, and would be "
        f"{reached / bound.value - 1.0:.2%} above it with the best linear estimator: the rest is what least squares "
        "lose, which do not weigh load errors"
    )
    return LowerBound(bound.value, f"{bound.certified_on}; {price}")


def best_linear_total(problem: DesignProblem, design: FloatArray) -> float:
    """`total` of a design (m, g) by the best linear unbiased estimator; infinite where it identifies too little."""
    assessment = problem.assessed(design[None])
    errors = assessment.whitened_errors[0]
    known = Information.beside(assessment.whitened[0], errors, np.ones(errors.shape[1]))
    return float(expected_total(known, problem.targets))

"""What no plan goes below: the bound of the convex relaxation (theory.md 10).

Bounds on `total` are of generalised least squares (`experiment.estimator`, theory.md 10.4, 10.6), the best linear
unbiased estimator. They hold for weighted least squares too, which come less close to them.
"""

from collections.abc import Callable

from expdesign.arrays import FloatArray
from expdesign.planning.optimality.certificate import Certificate, LowerBound
from expdesign.planning.problem import DesignProblem


def lower_bound(
    problem: DesignProblem, load_errors: float, known: FloatArray, ended: Callable[[], bool] = lambda: False
) -> LowerBound:
    """The bound of DUIR (`load_errors` 0) or of `total` (1) over all plans of as many measurements.

    Args:
        problem: the design problem.
        load_errors: see `MeasurementMaps`.
        known: designs (d, m, g) that can be measured, of which one at least identifies what the targets need.
        ended: whether there is no more time.
    """
    return Certificate(problem, load_errors).bound(known, ended)

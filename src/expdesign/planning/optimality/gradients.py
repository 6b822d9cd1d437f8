"""Exact gradients of every criterion with respect to every continuous design variable."""

from collections.abc import Sequence

from expdesign.arrays import FloatArray
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

"""Exact gradients of every criterion with respect to every continuous gene."""

from collections.abc import Sequence

from expdesign.arrays import FloatArray
from expdesign.criteria.criterion import known_criteria
from expdesign.design.optimality.partials import pieces
from expdesign.design.optimality.sensitivity import DesignModel
from expdesign.design.problem import DesignProblem


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

"""Children that are put together of the measurements of parents, and then descend: a memetic algorithm (Moscato 1989)
in which every direction along the front has parents of its own (MOEA/D, Zhang & Li 2007).
"""

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.planning.operators.state import AIMS, BRIEF_STEPS, State
from expdesign.planning.optimality.exchange import variants
from expdesign.planning.scalarisation import Aims


class Children:
    """Children of neighbours in the sense of the front, which descend where gradients are known."""

    name = "children"

    def propose(self, state: State) -> FloatArray:
        aims = state.aims(AIMS)
        of = np.repeat(np.arange(len(aims)), state.children(aims))
        return state.descended(bred(state, aims, of), aims[of], BRIEF_STEPS)


_KINDS = 5
"""Ways to make a child, of which the last, a plan drawn anew, keeps a search from settling where it is."""


def bred(state: State, aims: Aims, of: IntArray) -> FloatArray:
    """One child (c, m, g) for each entry of `of` (c,), sorted: which aim's best designs are its parents.

    Some are mixed from two parents, some have one variable of one measurement changed, one in five is drawn anew, and
    the others have one measurement of a parent replaced by one of another.
    """
    elites = state.elite(aims)
    return np.concatenate(
        [_bred(state, elites[aim], int(count)) for aim, count in zip(*np.unique(of, return_counts=True), strict=True)]
    )


def _bred(state: State, elite: FloatArray, count: int) -> FloatArray:
    draw, (number, m, g) = state.generator.integers, elite.shape
    children = elite[draw(number, size=count)]
    rows, place = np.arange(count), draw(m, size=count)
    others = elite.reshape(-1, g)[draw(number * m, size=count)]
    # A plan drawn anew takes longer than a budget allows, and what is left of it then is a plan by chance.
    kind = draw(_KINDS if state.problem.budget is None else _KINDS - 1, size=count)
    fresh = state.stock[draw(len(state.stock), size=(count, m))]
    varied = variants(state.problem.space, children)[rows, place]
    own = varied[rows, draw(varied.shape[1], size=count)]
    others = np.where((kind == 2)[:, None], own, others)
    children[rows, place] = others
    children = np.where((kind == _KINDS - 1)[:, None, None], fresh, children)
    mixed = (state.generator.random((count, m)) < 0.5) & ((kind == 1) | (kind == 3))[:, None]
    return np.where(mixed[..., None], elite[draw(number, size=count)], children)

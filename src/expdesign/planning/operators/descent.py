"""Descents along exact gradients, towards the ends and points along the front."""

from expdesign.arrays import FloatArray
from expdesign.planning.operators.operator import State


class FrontDescent:
    """Pursues points along the front from the best designs known for them."""

    name = "gradients"

    def offspring(self, state: State) -> FloatArray:
        points, steps = state.options.along
        aims = state.aims(points)
        return state.descended(state.best(aims), aims, steps)

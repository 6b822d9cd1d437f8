"""Descents from the best designs that are known towards points along the front (Pascoletti & Serafini 1984)."""

from expdesign.arrays import FloatArray
from expdesign.planning.operators.state import State


class FrontDescent:
    """Pursues the ends of the front and points along it, by exact gradients."""

    name = "descent"

    def propose(self, state: State) -> FloatArray:
        points, steps = state.options.along
        aims = state.aims(points)
        return state.descended(state.best(aims), aims, steps)

"""Descents from the best designs that are known towards points along the front (Pascoletti & Serafini 1984)."""

from expdesign.arrays import FloatArray
from expdesign.planning.operators.state import ALONG_STEPS, State


class FrontDescent:
    """Pursues the ends of the front and points along it, by exact gradients."""

    name = "descent"

    def propose(self, state: State) -> FloatArray:
        aims = state.aims(24)
        return state.descended(state.best(aims), aims, ALONG_STEPS)

"""An unknown wrench is added to the load, as a force sensor's noise or a cable does: L = I (theory.md 5.2)."""

import casadi as ca

from expdesign.mechanics.loads.errors.source import LoadErrorSource
from expdesign.mechanics.loads.load import Load


class WrenchError(LoadErrorSource):
    """δ is the added wrench at the origin of P along the axes of O."""

    source = "wrench"
    unit = "N, N·m"

    @classmethod
    def dimension(cls, load: Load) -> int:
        return load.coordinates.n

    def disturbed(self, load: Load, parameters: ca.SX, rotation: ca.SX, delta: ca.SX) -> ca.SX:
        return load.wrench(parameters, rotation) + delta

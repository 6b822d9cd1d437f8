"""The mass is not exactly the one assumed: L = F/m (theory.md 5.2)."""

import casadi as ca

from expdesign.mechanics.loads.errors.source import LoadErrorSource
from expdesign.mechanics.loads.load import Load


class MassError(LoadErrorSource):
    """δ is the difference of mass."""

    source = "mass"
    unit = "kg"

    @classmethod
    def dimension(cls, load: Load) -> int:
        return int(load.has_mass)

    def disturbed(self, load: Load, parameters: ca.SX, rotation: ca.SX, delta: ca.SX) -> ca.SX:
        return load.wrench(parameters + ca.vertcat(delta, ca.SX.zeros(parameters.shape[0] - 1)), rotation)

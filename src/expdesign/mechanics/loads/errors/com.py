"""The centre of mass is not exactly where it is assumed: L = [0; −[m g]ₓ R] (theory.md 5.2)."""

import casadi as ca

from expdesign.mechanics.loads.errors.source import LoadErrorSource
from expdesign.mechanics.loads.load import Load


class CentreOfMassError(LoadErrorSource):
    """δ is the offset of the centre of mass in the platform frame."""

    source = "com"
    unit = "m"

    @classmethod
    def dimension(cls, load: Load) -> int:
        return len(load.coordinates.centre_of_mass) if load.has_mass else 0

    def disturbed(self, load: Load, parameters: ca.SX, rotation: ca.SX, delta: ca.SX) -> ca.SX:
        offset = ca.vertcat(0.0, delta, ca.SX.zeros(parameters.shape[0] - 1 - delta.shape[0]))
        return load.wrench(parameters + offset, rotation)

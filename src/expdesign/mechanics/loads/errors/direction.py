"""The load does not act exactly along the assumed direction (file-formats.md, Run configurations)."""

import casadi as ca

from expdesign.mechanics.loads.errors.source import LoadErrorSource
from expdesign.mechanics.loads.load import Load


class DirectionError(LoadErrorSource):
    """δ tilts the load about x and y of O: gravity for a payload, force and moment together for a wrench."""

    source = "direction"
    unit = "rad"

    @classmethod
    def dimension(cls, load: Load) -> int:
        return len(load.coordinates.tilt)

    def disturbed(self, load: Load, parameters: ca.SX, rotation: ca.SX, delta: ca.SX) -> ca.SX:
        return load.turned(parameters, rotation, delta)

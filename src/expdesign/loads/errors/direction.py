"""The load does not act exactly along the assumed direction (file-formats.md, Run configurations)."""

import casadi as ca

from expdesign.loads.errors.source import LoadErrorSource
from expdesign.loads.load import Load, small_rotation


class DirectionError(LoadErrorSource):
    """δ tilts the load about x and y of O: gravity for a payload, force and moment together for a wrench."""

    source = "direction"
    unit = "rad"

    @classmethod
    def dimension(cls, load: Load) -> int:
        return len(load.coordinates.tilt)

    def disturbed(self, load: Load, parameters: ca.SX, rotation: ca.SX, delta: ca.SX) -> ca.SX:
        if load.kind == "payload":
            dimension = len(load.coordinates.gravity)
            turned = small_rotation(parameters[-dimension:], delta)
            return load.wrench(ca.vertcat(parameters[:-dimension], turned), rotation)
        wrench = load.wrench(parameters, rotation)
        split = load.coordinates.translations
        parts = [small_rotation(wrench[:split], delta)]
        if wrench.shape[0] > split:
            # About the normal of the plane a moment stays what it is.
            parts.append(small_rotation(wrench[split:], delta) if split == 3 else wrench[split:])
        return ca.vertcat(*parts)

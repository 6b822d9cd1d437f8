"""The load is not as stated: its centre of mass is elsewhere or moves (liquids, sagging and loose parts), or it acts in
another direction.
"""

from collections.abc import Iterator, Sequence

import casadi as ca

from expdesign.chain.component import PAYLOAD, Component, tilted_load
from expdesign.chain.ports.families import Prior, over_time, smooth_over
from expdesign.chain.ports.port import Channel, Entry, Port
from expdesign.chain.ports.quantities import Quantity
from expdesign.chain.ports.sight import Sight
from expdesign.chain.row import Row
from expdesign.mechanics.robots.orientation import moment


class _Stated(Port):
    """What is stated of a load, and is not so; laws of the pose, of time, or of nothing."""

    @property
    def components(self) -> Sequence[Component]:
        return (PAYLOAD,)

    def entries(self, sight: Sight) -> Iterator[Entry]:
        pose = tuple(Quantity("pose", index) for index in range(len(self.robot.configuration)))
        priors = [Prior("load", "constant", (Quantity("clock"),), (1.0,), 1), *over_time(sight, "load")]
        for inputs in (*self._further(), pose):
            priors += smooth_over(sight, "load", inputs, 15)
        for prior in priors if self.width else ():
            channels = tuple(Channel(axis, axis, prior.inputs) for axis in range(self.width))
            yield Entry(self.name, PAYLOAD, prior.form, channels, prior.kernel, prior.scales, prior.rank)

    def _further(self) -> tuple[tuple[Quantity, ...], ...]:
        """Inputs beside the pose."""
        return ()


class CentreOfMass(_Stated):
    """u: shift (m) of the point at which the load acts, along the platform's axes.

    The moment about the origin of P grows by (R·u) × F. What shifts it is the attitude (gravity along the platform's
    axes), the pose, or time.
    """

    name = "centre of mass"

    def components_of_motion(self) -> int:
        return len(self.robot.gravity) if self.robot.coordinates.n > len(self.robot.gravity) else 0

    @property
    def outputs(self) -> Sequence[str]:
        return tuple(f"com_d{axis}_m" for axis in "xyz"[: self.width])

    def load(self, wrench: ca.SX, row: Row, extra: ca.SX) -> ca.SX:
        d = self.width
        return wrench + ca.vertcat(ca.SX.zeros(d), moment(row.rotation @ extra, row.wrench[:d]))

    def _further(self) -> tuple[tuple[Quantity, ...], ...]:
        return (tuple(Quantity("own_gravity", axis) for axis in range(self.width)),)


class LoadDirection(_Stated):
    """u: small angles (rad) about x and y of O (in the plane about its normal) by which the load is turned."""

    name = "load direction"

    def components_of_motion(self) -> int:
        return len(self.robot.gravity) - 1

    @property
    def outputs(self) -> Sequence[str]:
        return ("tilt_x_rad", "tilt_y_rad") if self.width > 1 else ("tilt_z_rad",)

    def load(self, wrench: ca.SX, row: Row, extra: ca.SX) -> ca.SX:
        return wrench + tilted_load(row.wrench, row, extra) - row.wrench

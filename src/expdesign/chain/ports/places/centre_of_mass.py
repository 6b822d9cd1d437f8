"""The load is not as stated: its centre of mass is elsewhere or moves (liquids, sagging and loose parts), or it acts in
another direction.
"""

from abc import abstractmethod
from collections.abc import Iterator, Sequence
from typing import ClassVar

import casadi as ca

from expdesign.chain.component import PAYLOAD, on_any, tilted_load
from expdesign.chain.ports.families import over_time, smooth_over
from expdesign.chain.ports.port import Entry, Port, steady
from expdesign.chain.ports.quantities import Quantity
from expdesign.chain.ports.sight import Sight
from expdesign.chain.row import Row
from expdesign.mechanics.robots.orientation import moment
from expdesign.mechanics.robots.robot import Robot


class _Stated(Port):
    """What is stated of a load, and is not so; laws of the pose, of time, of nothing, of gravity where it `shifts`."""

    at = on_any(PAYLOAD)
    shifts: ClassVar[bool] = False

    @abstractmethod
    def load(self, wrench: ca.SX, row: Row, extra: ca.SX) -> ca.SX:
        """The wrench of a load that differs by u from what is stated."""

    def entries(self, sight: Sight) -> Iterator[Entry]:
        priors = [steady("load"), *over_time(sight, "load")]
        attitude = tuple(Quantity("own_gravity", axis) for axis in range(self.width)) if self.shifts else ()
        for inputs in (attitude, sight.pose):
            priors += smooth_over(sight, "load", inputs, 15)
        for prior in priors if self.width else ():
            yield self.law(PAYLOAD, prior, range(self.width))


def _centre(robot: Robot) -> Sequence[str]:
    """A force has a moment where the platform turns."""
    d = len(robot.gravity)
    return [f"com_d{axis}_m" for axis in "xyz"[:d]] if robot.coordinates.n > d else []


class CentreOfMass(_Stated):
    """u: shift (m) of the point at which the load acts, along the platform's axes.

    The moment about the origin of P grows by (R·u) × F. What shifts it is the attitude (gravity along the platform's
    axes), the pose, or time.
    """

    name = "centre of mass"
    adds = _centre
    shifts = True

    def load(self, wrench: ca.SX, row: Row, extra: ca.SX) -> ca.SX:
        d = self.width
        return wrench + ca.vertcat(ca.SX.zeros(d), moment(row.rotation @ extra, row.wrench[:d]))


def _tilts(robot: Robot) -> Sequence[str]:
    return ("tilt_x_rad", "tilt_y_rad") if robot.coordinates.translations > 2 else ("tilt_z_rad",)


class LoadDirection(_Stated):
    """u: small angles (rad) about x and y of O (in the plane about its normal) by which the load is turned."""

    name = "load direction"
    adds = _tilts

    def load(self, wrench: ca.SX, row: Row, extra: ca.SX) -> ca.SX:
        return wrench + tilted_load(row.wrench, row, extra) - row.wrench

"""What is brought along with the load, and is not there where the robot is unloaded: cables, hoses, wind on a crate."""

from collections.abc import Iterator

import casadi as ca
import numpy as np

from expdesign.chain.component import ENVIRONMENT
from expdesign.chain.ports.places.wrenches import PayloadPort
from expdesign.chain.ports.port import Channel, Entry, steady
from expdesign.chain.ports.quantities import Quantity
from expdesign.chain.ports.sight import Sight
from expdesign.chain.row import Row


class Attachments(PayloadPort):
    """u: extra wrench (N, N·m) at the origin of P along the axes of O in all rows with a load.

    Recordings start each series with the unloaded robot, which shows nothing of what came with the load. A field that
    acts always (`PayloadPort`) would have to explain that row as well.
    """

    name = "attachments"

    def load(self, wrench: ca.SX, row: Row, extra: ca.SX) -> ca.SX:
        return wrench + ca.if_else(ca.sumsqr(row.wrench) > 0.0, extra, 0.0)

    def entries(self, sight: Sight) -> Iterator[Entry]:
        first = len(self.robot.stiffness)
        loads = [sight.values(Quantity("effort", first + axis))[sight.counts] for axis in range(self.width)]
        if np.any(loads, axis=0).all():
            return
        yield self.law(ENVIRONMENT, steady("field"), range(len(self.robot.gravity)))
        yield from self._fields(sight)
        yield from self._towards_points(sight, (1.0,))

    def _moved(self, sight: Sight, channels: tuple[Channel, ...]) -> tuple[Channel, ...]:
        return channels

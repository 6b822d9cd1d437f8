"""The payload's centre of mass, which is not where the recordings say, or moves: liquids, sagging and loose parts."""

from collections.abc import Iterator, Sequence

import casadi as ca

from expdesign.chain.component import PAYLOAD, Component
from expdesign.chain.ports.families import Prior, over_time, smooth_over
from expdesign.chain.ports.port import Channel, Entry, Port
from expdesign.chain.ports.quantities import Quantity
from expdesign.chain.ports.sight import Sight
from expdesign.chain.row import Row
from expdesign.mechanics.robots.orientation import moment


class CentreOfMass(Port):
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

    @property
    def components(self) -> Sequence[Component]:
        return (PAYLOAD,)

    def entries(self, sight: Sight) -> Iterator[Entry]:
        attitude = tuple(Quantity("own_gravity", axis) for axis in range(self.width))
        pose = tuple(Quantity("pose", index) for index in range(len(self.robot.configuration)))
        priors = [Prior("load", "constant", (Quantity("clock"),), (1.0,), 1), *over_time(sight, "load")]
        for inputs in (attitude, pose):
            priors += smooth_over(sight, "load", inputs, 15)
        for prior in priors:
            channels = tuple(Channel(axis, axis, prior.inputs) for axis in range(self.width))
            yield Entry(self.name, PAYLOAD, prior.form, channels, prior.kernel, prior.scales, prior.rank)

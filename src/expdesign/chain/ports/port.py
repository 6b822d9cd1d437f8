"""Ports and the laws that they may hide.

A port adds u, an extra motion or wrench of a few components, to one link of the chain. A law says what u is:

    u_a = Σ_channels amplitude · Σ_j φ_j(inputs) · w_(block, j),

with features φ of a covariance function (`features`) and unknown weights w ~ N(0, σ²·I).
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar

import casadi as ca

from expdesign.chain.component import Component
from expdesign.chain.ports.quantities import Quantity
from expdesign.chain.ports.sight import Sight
from expdesign.chain.row import Row
from expdesign.mechanics.robots.robot import Robot


@dataclass(frozen=True)
class Channel:
    """One term of a law: block `block` of its weights acts on component `output` of the port.

    Attributes:
        output: component of u.
        block: of the weights; channels with one block follow one law.
        inputs: on what the law depends.
        amplitude: factor, or None for 1.
        gain: constant factor, which makes the blocks of a law commensurable (`dictionary`).
    """

    output: int
    block: int
    inputs: tuple[Quantity, ...]
    amplitude: Quantity | None = None
    gain: float = 1.0


@dataclass(frozen=True)
class Entry:
    """One law that may be there, with unknown size.

    Attributes:
        port: name of the port's class (`Port.name`).
        component: where it acts.
        form: what kind of law, a key of `words.FORMS`.
        channels: its terms.
        kernel: a key of `kernels.KERNELS`.
        scales: of the inputs, in their units, one per input.
        rank: most features per block.
    """

    port: str
    component: Component
    form: str
    channels: tuple[Channel, ...]
    kernel: str
    scales: tuple[float, ...]
    rank: int = 16

    @property
    def blocks(self) -> int:
        """Number of blocks of weights."""
        return 1 + max(channel.block for channel in self.channels)

    @property
    def inputs(self) -> tuple[Quantity, ...]:
        """Inputs of the first channel, which name what the law depends on."""
        return self.channels[0].inputs

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """Everything that the law needs to see, each once, in the order of its channels."""
        every = [q for channel in self.channels for q in (*channel.inputs, channel.amplitude)]
        return tuple(dict.fromkeys(quantity for quantity in every if quantity is not None))


class Port(ABC):
    """One kind of port of a robot. The hooks are those of `Effect`, with u in place of parameters.

    Attributes:
        name: identifies the port in model files.
        width: components of u.
    """

    name: ClassVar[str]
    width: int

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.width = self.components_of_motion()

    @abstractmethod
    def components_of_motion(self) -> int:
        """How many components u has on this robot; 0 where the robot has no such port."""

    @property
    def outputs(self) -> Sequence[str]:
        """Names of the components of u with their units, as curves have them: motions of the platform."""
        return self.robot.coordinates.deflection

    @property
    @abstractmethod
    def components(self) -> Sequence[Component]:
        """Where its laws may be."""

    @abstractmethod
    def entries(self, sight: Sight) -> Iterator[Entry]:
        """The laws that recordings with this sight could show."""

    def geometry(self, geometry: ca.SX, extra: ca.SX) -> ca.SX:
        """See `Effect.geometry`."""
        return geometry

    def unloaded(self, pose: ca.SX, row: Row, extra: ca.SX) -> ca.SX:
        """See `Effect.unloaded`."""
        return pose

    def load(self, wrench: ca.SX, row: Row, extra: ca.SX) -> ca.SX:
        """See `Effect.load`."""
        return wrench

    def actuator(self, elongation: ca.SX, row: Row, extra: ca.SX) -> ca.SX:
        """See `Effect.actuator`."""
        return elongation

    def structure(self, deflection: ca.SX, row: Row, extra: ca.SX) -> ca.SX:
        """See `Effect.structure`."""
        return deflection

    def reading(self, reading: ca.SX, row: Row, extra: ca.SX) -> ca.SX:
        """See `Effect.reading`."""
        return reading

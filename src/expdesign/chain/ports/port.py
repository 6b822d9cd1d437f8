"""Ports and the laws that they may hide.

A port adds u, an extra motion or wrench of a few components, to one link of the chain. A law says what u is:

    u_a = Σ_channels amplitude · Σ_j φ_j(inputs) · w_(block, j),

with features φ of a covariance function (`features`) and unknown weights w ~ N(0, σ²·I).
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar

from expdesign.chain.component import Component
from expdesign.chain.ports.quantities import Quantity
from expdesign.chain.ports.sight import Sight
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


Terms = Iterable[int | tuple[int, Quantity] | Channel]
"""Components of u in which a law acts, each with the quantity by which it is multiplied, if any; or whole channels."""


def channels_of(terms: Terms, inputs: tuple[Quantity, ...], *, alike: bool = False) -> tuple[Channel, ...]:
    """Channels of a law of its own in every component of u, or of one law in all of them (`alike`)."""
    found = []
    for block, term in enumerate(terms):
        if isinstance(term, Channel):
            found.append(term)
            continue
        output, amplitude = term if isinstance(term, tuple) else (term, None)
        found.append(Channel(output, 0 if alike else block, inputs, amplitude))
    return tuple(found)


@dataclass(frozen=True)
class Prior:
    """A covariance function over inputs: `form` says what kind of law it makes (`words.FORMS`)."""

    form: str
    kernel: str
    inputs: tuple[Quantity, ...]
    scales: tuple[float, ...]
    rank: int = 16


ALWAYS = Quantity("clock")
"""What stands in the place of an input where a law has none."""


def steady(form: str, quantity: Quantity = ALWAYS) -> Prior:
    """What is the same always; `quantity` only stands in the place of an input."""
    return Prior(form, "constant", (quantity,), (1.0,), 1)


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


Names = Callable[[Robot], Sequence[str]]
"""Names of what a robot has of a kind."""


class Port(ABC):
    """One kind of port of a robot, which adds u to the links of the chain of which it has a method.

    These are named as those of `Effect`, take what is there, the row and u, and return what is there then:
    `unloaded(pose, row, u)`, `load(wrench, row, u)`, `actuator(elongation, row, u)`, `structure(deflection, row, u)`
    and `reading(reading, row, u)`; `geometry(geometry, u)` has no row.

    Attributes:
        name: identifies the port in model files.
        at: where on a robot its laws may be.
        adds: names of the components of u with their units, as curves have them; none where a robot has no such port.
        components, outputs: the same of this robot.
        width: components of u.
    """

    name: ClassVar[str]
    at: ClassVar[Callable[[Robot], Sequence[Component]]]
    adds: ClassVar[Names] = lambda robot: robot.coordinates.deflection

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.outputs = tuple(type(self).adds(robot))
        self.width = len(self.outputs)
        self.components = tuple(type(self).at(robot))

    @abstractmethod
    def entries(self, sight: Sight) -> Iterator[Entry]:
        """The laws that recordings with this sight could show."""

    def law(
        self, component: Component, prior: Prior, terms: Terms, *, alike: bool = False, rank: int | None = None
    ) -> Entry:
        """A law with a prior: of its own in each of the terms, or the same in all of them (`alike`)."""
        channels = channels_of(terms, prior.inputs, alike=alike)
        rank = prior.rank if rank is None else rank
        return Entry(self.name, component, prior.form, channels, prior.kernel, prior.scales, rank)

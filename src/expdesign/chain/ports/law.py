"""Laws as links of the chain: what a port does, with the weights of the law's features as parameters."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import Component
from expdesign.chain.declaration import Variant
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.form import ONLY, Form
from expdesign.chain.ports.features import FeatureBasis
from expdesign.chain.ports.port import Channel, Port
from expdesign.chain.ports.quantities import Quantity, seen_in
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.row import Row
from expdesign.mechanics.robots.robot import Robot
from expdesign.plugins import implementations

_FADES = 0.25
"""Length over which a law fades beyond the range of its inputs, in widths of the range."""
_GOES_ON = 0.1
"""The same over which a law of time or temperature goes on, before it stays at its last value."""
_WITHIN = 1e-24
"""Share left of the variance beyond within the range: a root has no derivative at exactly 0."""


def port_classes() -> dict[str, type[Port]]:
    """Every port that lies in `ports/places`, by name."""
    found = implementations("expdesign.chain.ports.places", Port)  # type: ignore[type-abstract]
    return {cls.name: cls for cls in found}


def ports_of(robot: Robot) -> list[Port]:
    """The ports that a robot has."""
    return [port for port in (cls(robot) for cls in port_classes().values()) if port.width > 0]


class _AtPort(Effect):
    """An effect whose every hook is that of a port; subclasses say what u is."""

    physics = "law"

    def __init__(self, robot: Robot, port: Port, component: Component, variant: Variant = ONLY) -> None:
        self.port = port
        self.changes_geometry = self._acts("geometry") or self._acts("unloaded")
        super().__init__(robot, component, variant)

    @property
    def port_name(self) -> str:
        return self.port.name

    @classmethod
    def components(cls, robot: Robot) -> Sequence[Component]:
        """Every component of a port."""
        return list(dict.fromkeys(component for port in ports_of(robot) for component in port.components))

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> Sequence[tuple[Component, Variant]]:
        """None: laws are not part of the library of named physics."""
        return []

    def extra(self, row: Row, state: ca.SX, theta: ca.SX) -> tuple[ca.SX, ca.SX]:
        """What the port adds, u (width,), and the next states."""
        raise NotImplementedError

    def _u(self, row: Row, theta: ca.SX) -> ca.SX:
        return self.extra(row, ca.SX.zeros(self.states), theta)[0]

    def always(self, theta: ca.SX) -> ca.SX:
        """What a port adds that changes the machine without a load: u, the same in all rows."""
        return theta

    def geometry(self, geometry: ca.SX, theta: ca.SX) -> ca.SX:
        return self._added("geometry", geometry, self.always(theta)) if self._acts("geometry") else geometry

    def unloaded(self, pose: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        return self._added("unloaded", pose, row, self.always(theta)) if self._acts("unloaded") else pose

    def load(self, wrench: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        return self._added("load", wrench, row, self._u(row, theta)) if self._acts("load") else wrench

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        return self._remembered("actuator", elongation, row, state, theta)

    def structure_with_memory(
        self, deflection: ca.SX, wrench: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        return self._remembered("structure", deflection, row, state, theta)

    def reading(self, reading: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        return self._added("reading", reading, row, self._u(row, theta)) if self._acts("reading") else reading

    def _acts(self, link: str) -> bool:
        return hasattr(self.port, link)

    def _added(self, link: str, *given: Any) -> ca.SX:
        found: ca.SX = getattr(self.port, link)(*given)
        return found

    def _remembered(self, link: str, value: ca.SX, row: Row, state: ca.SX, theta: ca.SX) -> tuple[ca.SX, ca.SX]:
        if not self._acts(link):
            return value, state
        extra, following = self.extra(row, state, theta)
        return self._added(link, value, row, extra), following


class Injection(_AtPort):
    """u itself as parameters: its sensitivities are the port's map to the readings."""

    def describe(self) -> tuple[Parameter, ...]:
        return tuple(Parameter(f"u{i + 1}", 1.0) for i in range(self.port.width))

    def extra(self, row: Row, state: ca.SX, theta: ca.SX) -> tuple[ca.SX, ca.SX]:
        return theta, state


@dataclass(frozen=True)
class LawForm:
    """A law without its weights; everything that a model file has to hold.

    Attributes:
        port, component, kind: where it acts, and what kind of law it is (`words.FORMS`).
        channels: its terms.
        basis: of its features.
        low, high: range of the inputs of each channel in the fitted rows, shape (channels, d) each.
        deviation: standard deviation of the weights before anything is measured (σ).
    """

    port: str
    component: Component
    kind: str
    channels: tuple[Channel, ...]
    basis: FeatureBasis
    low: FloatArray
    high: FloatArray
    deviation: float

    @property
    def blocks(self) -> int:
        """Number of blocks of weights."""
        return 1 + max(channel.block for channel in self.channels)

    @property
    def depends_on(self) -> tuple[Quantity, ...]:
        """What the law depends on, each once: its inputs, or what a law that is always the same is in proportion to."""
        if self.basis.kernel == "constant":
            return tuple(dict.fromkeys(c.amplitude for c in self.channels if c.amplitude is not None))
        return tuple(dict.fromkeys(q for channel in self.channels for q in channel.inputs))


class Law(_AtPort):
    """An unknown law that was found at a port.

    Parameters are the weights of its features, block after block, known beforehand to ±σ about 0; after them one per
    component of u for what is not known beyond the range of the inputs: there the features fade, and this takes over
    with the law's own standard deviation about 0. Soon beyond recorded times and temperatures a law stays at its last
    value, and what is not known grows as a random walk that wanders by its standard deviation within their range. With
    a_c the signed amplitudes of the channels of one law and b_c how far they are beyond, their sum is uncertain by
    σ·√(Σ_cd a_c·a_d·min(b_c, b_d)), the covariance of a Brownian motion: a reading at t that refers to one at t₀ by
    σ·√|b − b₀|, however late both are.
    """

    def __init__(self, robot: Robot, form: LawForm, number: int = 1) -> None:
        self.form, self.number = form, number
        classes = port_classes()
        self._outputs = sorted({channel.output for channel in form.channels})
        super().__init__(robot, classes[form.port](robot), form.component, Form(name=f"{form.kind} {number}"))

    @property
    def subject(self) -> str:
        """What forms say is said of one: all joints are every joint."""
        if not self.component.several:
            return super().subject
        return f"Every {str(self.component).removeprefix('all ').removesuffix('s')}"

    def describe(self) -> tuple[Parameter, ...]:
        form = self.form
        every = {q for channel in form.channels for q in (*channel.inputs, channel.amplitude) if q is not None}
        self._seen = sorted(every, key=lambda q: (q.kind, q.index, q.setting))
        self.states = sum(q.states for q in self._seen)
        if self.states and not (self._acts("actuator") or self._acts("structure")):
            raise TypeError(f"port {self.port.name}: only the hooks `actuator` and `structure` remember")
        names = [f"w{b + 1}_{j + 1}" for b in range(form.blocks) for j in range(form.basis.rank)]
        names += [f"beyond_{output + 1}" for output in self._outputs]
        return tuple(Parameter(name, form.deviation, spread=form.deviation) for name in names)

    def always(self, theta: ca.SX) -> ca.SX:
        values = ca.SX.zeros(self.port.width)
        for channel in self.form.channels:
            values[channel.output] += channel.gain * theta[channel.block * self.form.basis.rank]
        return values

    def extra(self, row: Row, state: ca.SX, theta: ca.SX) -> tuple[ca.SX, ca.SX]:
        form = self.form
        seen, following = seen_in(self._seen, row, self.robot, state)
        extra = ca.SX.zeros(self.port.width)
        rank, blocks = form.basis.rank, form.blocks
        features: dict[tuple[Quantity, ...], ca.SX] = {}
        outside: dict[tuple[int, int], list[tuple[ca.SX, ca.SX]]] = {}
        for index, channel in enumerate(form.channels):
            low, high = form.low[index], form.high[index]
            inputs = [seen[quantity] for quantity in channel.inputs]
            if form.basis.kernel == "constant":
                # Always the same: neither a time nor anything else is asked of points.
                inputs = [ca.SX(float(middle)) for middle in 0.5 * (low + high)]
            held, later = _held(channel.inputs, inputs, low, high)
            if any(quantity.kind == "approach" for quantity in channel.inputs):
                later += row.unseen  # how it was reached is as far beyond what is known
            if channel.inputs not in features:
                features[channel.inputs] = form.basis.expression(held)
            weights = theta[channel.block * rank : (channel.block + 1) * rank]
            fading = [i for i, quantity in enumerate(channel.inputs) if not quantity.drifts]
            within = _within([inputs[i] for i in fading], low[fading], high[fading])
            amplitude = channel.gain * (ca.SX(1.0) if channel.amplitude is None else seen[channel.amplitude])
            extra[channel.output] += amplitude * within * ca.dot(features[channel.inputs], weights)
            outside.setdefault((channel.output, channel.block), []).append((amplitude, 1.0 - within**2 + later))
        for position, output in enumerate(self._outputs):
            variance = sum((_wandered(each) for (own, _), each in outside.items() if own == output), ca.SX(0.0))
            least = _WITHIN * sum(channel.gain**2 for channel in form.channels if channel.output == output)
            extra[output] += ca.sqrt(ca.fmax(variance, least)) * theta[blocks * rank + position]
        return extra, following

    def physics_among(self, known: Collection[str]) -> str:
        """Identifier of the known physics whose name is this port and what the law depends on; see `physics_of`."""
        form = self.form
        return physics_of(self.robot, form.port, form.component, form.kind, (form.depends_on, form.channels), known)

    def reported(self, theta: ca.SX) -> dict[str, ca.SX]:
        """A law is a curve; it has no parameters that a person would know."""
        return {}


def physics_of(
    robot: Robot,
    port: str,
    component: Component,
    kind: str,
    terms: tuple[Iterable[Quantity], Iterable[Channel]],
    known: Collection[str],
) -> str:
    """Identifier of the known physics whose name is a port and what a law there depends on, whatever its form.

    Creep that follows no exponential and a gear error with harmonics of its own remain creep and a periodic error.
    Amplitudes count as inputs: a compliance that varies with time depends on a force and on time. A law that no
    declaration covers has no name, `Law.physics`.

    Args:
        robot: the robot.
        port: of the law.
        component: where it acts.
        kind: of law, a key of `words.FORMS`.
        terms: what the law depends on, and its channels.
        known: identifiers of the physics that may be named.
    """
    inputs, channels = terms
    seen = {*inputs, *(channel.amplitude for channel in channels)}
    depends = {quantity.input for quantity in seen if quantity is not None}
    for effect in implementations("expdesign.chain.effects", Effect):
        covers = effect.physics in known and kind in effect.declared.laws and depends <= {*effect.declared.inputs}
        if covers and component in effect.components(robot) and port == effect.port_at(component):
            return effect.physics
    return Law.physics


def _held(
    quantities: Sequence[Quantity], inputs: list[ca.SX], low: FloatArray, high: FloatArray
) -> tuple[list[ca.SX], ca.SX]:
    """Inputs with times and temperatures held soon beyond their range, and how many ranges these are beyond it."""
    held, later = list(inputs), ca.SX(0.0)
    for i, (quantity, least, most) in enumerate(zip(quantities, low, high, strict=True)):
        if quantity.drifts:
            width = max(float(most - least), 1e-12)
            held[i] = ca.fmin(ca.fmax(inputs[i], float(least) - _GOES_ON * width), float(most) + _GOES_ON * width)
            later += ca.fmax(ca.fmax(inputs[i] - float(most), float(least) - inputs[i]), 0.0) / width
    return held, later


def _wandered(channels: Sequence[tuple[ca.SX, ca.SX]]) -> ca.SX:
    """Variance of Σ a_c·W(b_c) of a Brownian motion W, from amplitudes and how far the channels are beyond."""
    return sum((a * b * ca.fmin(at, by) for a, at in channels for b, by in channels), ca.SX(0.0))


def _within(inputs: list[ca.SX], low: FloatArray, high: FloatArray) -> ca.SX:
    """1 within the range of the inputs, falling as exp(−½(distance/fade)²) beyond it."""
    squares = ca.SX(0.0)
    for value, least, most in zip(inputs, low, high, strict=True):
        fade = _FADES * max(float(most - least), 1e-12)
        outside = ca.fmax(ca.fmax(value - float(most), float(least) - value), 0.0)
        squares += (outside / fade) ** 2
    return ca.exp(-0.5 * squares)


def form_data(form: LawForm) -> dict[str, Any]:
    """A form as plain data, for a model file."""

    def of(quantity: Quantity | None) -> list[Any] | None:
        return None if quantity is None else [quantity.kind, quantity.index, *quantity.setting]

    return {
        "port": form.port,
        "kind": form.kind,
        "kernel": form.basis.kernel,
        "scales": form.basis.scales.tolist(),
        "centres": form.basis.centres.tolist(),
        "features": form.basis.weights.tolist(),
        "deviation": float(form.deviation),
        "channels": [
            {
                "output": channel.output,
                "block": channel.block,
                "gain": float(channel.gain),
                "inputs": [of(q) for q in channel.inputs],
                "amplitude": of(channel.amplitude),
                "low": form.low[index].tolist(),
                "high": form.high[index].tolist(),
            }
            for index, channel in enumerate(form.channels)
        ],
    }


def form_of(data: Mapping[str, Any], component: Component) -> LawForm:
    """The form in the data of a model file; `KeyError`, `TypeError` or `ValueError` where it is wrong."""

    def quantity(entry: Any) -> Quantity:
        return Quantity(str(entry[0]), int(entry[1]), tuple(float(v) for v in entry[2:]))

    items = data["channels"]
    channels = tuple(
        Channel(
            int(item["output"]), int(item["block"]), tuple(quantity(entry) for entry in item["inputs"]),
            None if item["amplitude"] is None else quantity(item["amplitude"]), float(item["gain"]),
        )
        for item in items
    )  # fmt: skip
    low, high = (np.array([item[name] for item in items], dtype=float) for name in ("low", "high"))
    scales, centres, weights = (np.array(data[name], dtype=float) for name in ("scales", "centres", "features"))
    basis, size = FeatureBasis(str(data["kernel"]), scales, centres, weights), float(data["deviation"])
    return LawForm(str(data["port"]), component, str(data["kind"]), channels, basis, low, high, size)

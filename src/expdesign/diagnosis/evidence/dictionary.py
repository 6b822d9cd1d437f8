"""All laws that recordings could show, as whitened directions of the readings with unit mean prior variance."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import Component
from expdesign.chain.ports.families import look_back
from expdesign.chain.ports.features import FeatureBasis, basis_of
from expdesign.chain.ports.law import Injection, Law, LawForm, ports_of
from expdesign.chain.ports.port import Channel, Entry, Port
from expdesign.chain.ports.quantities import Quantity
from expdesign.chain.ports.sight import Sight
from expdesign.diagnosis.evidence.columns import Columns, Dense, Mapped, Summand
from expdesign.estimation.fit import Data
from expdesign.mechanics.robots.robot import Robot

MOST_FEATURES = 90
_TELLING = 0.02
"""Features that change the readings by less, in variances of the noise summed over all rows, are left out: the readings
say nothing of them, and they do nothing to the readings."""


@dataclass(frozen=True)
class Atom:
    """One entry with its directions.

    Attributes:
        component: where it acts.
        columns: whitened derivatives Φ of the readings that count with respect to its weights, shape (M, f).
        gram: ΦᵀΦ, shape (f, f).
        entry: the law, whose channels have gains that make the mean prior variance of the readings 1; None for physics
            of known form.
        basis: features of the law.
        named: physics of known form, for who put it there: what, parameters to start from, and what its weights are in
            units of those that have a size.
        one_sided: whether its one weight cannot be negative.
    """

    component: Component
    columns: Columns
    gram: FloatArray
    entry: Entry | None = None
    basis: FeatureBasis | None = None
    named: tuple[Any, FloatArray, FloatArray] | None = None
    one_sided: bool = False

    @property
    def directions(self) -> FloatArray:
        """Φ itself, which is made every time that it is asked for, shape (M, f)."""
        return self.columns.matrix()

    @property
    def width(self) -> int:
        """Number of weights."""
        return self.columns.width


class Dictionary:
    """Every law at every port, beside a base model.

    Args:
        robot: the robot.
        sample: the rows that laws are sought in; all others have zero residuals and directions.
        values: parameters of the model.
        only: names of ports, or all.

    Attributes:
        atoms: laws at ports, and what `add` has put beside them.
        sight: what ports see.
    """

    def __init__(
        self,
        robot: Robot,
        sample: Data,
        values: FloatArray,
        *,
        only: tuple[str, ...] = (),
    ) -> None:
        symbols, timed = sample.held(robot, (), values)[0].row_symbols(), sample.recordings.time is not None
        axes = [int(axis) for axis in sample.recordings.axes]
        self.sight = Sight(robot, symbols, sample.rows, sample.counts, axes, timed=timed)
        self.atoms: list[Atom] = []
        self._maps: dict[str, tuple[FloatArray, FloatArray]] = {}
        known = _Known()
        efforts = len(robot.stiffness) + 2 * robot.coordinates.n
        look_back(self.sight, [Quantity("effort", index) for index in range(efforts)])
        for port in ports_of(robot):
            if only and port.name not in only:
                continue
            maps = port_map(port, robot, sample, values)
            if not np.any(maps):
                continue
            self._maps[port.name] = maps, maps[sample.counts]
            entries = list(port.entries(self.sight))
            self.sight.look([quantity for entry in entries for quantity in entry.quantities])
            made = (_atom(entry, self._maps[port.name], self.sight, known) for entry in entries)
            self.atoms += [atom for atom in made if atom is not None]

    def made(self, entry: Entry) -> Atom | None:
        """The atom of another entry at a known port; gains of its channels are taken anew."""
        return _atom(entry, self._maps[entry.port], self.sight, _Known())


def port_map(port: Port, robot: Robot, sample: Data, values: FloatArray) -> FloatArray:
    """Whitened derivatives of the readings with respect to u, shape (N, k, width)."""
    injection = Injection(robot, port, port.components[0])
    chain, values = sample.held(robot, (injection,), values)
    start = np.concatenate([values, np.zeros(port.width)])
    sensitivities = chain.predict_with_sensitivities(sample.rows, start)[1][:, sample.recordings.axes]
    maps: FloatArray = sample.whiten(sensitivities[..., len(values) :])
    return maps


@dataclass(frozen=True)
class _Known:
    """Features that several laws share.

    Attributes:
        bases: by inputs, kernel, scales and rank; None for a kernel that vanishes on all of them.
        values: of the same, by the group of inputs that they are taken at, in the rows that count.
        amplitudes: in the rows that count.
    """

    bases: dict[object, FeatureBasis | None] = field(default_factory=dict)
    values: dict[object, FloatArray] = field(default_factory=dict)
    amplitudes: dict[Quantity | None, FloatArray] = field(default_factory=dict)


def _atom(entry: Entry, maps: tuple[FloatArray, FloatArray], sight: Sight, known: _Known) -> Atom | None:
    """`maps`: in all rows, and in those that count."""
    pooled = tuple(dict.fromkeys(channel.inputs for channel in entry.channels))
    key = (pooled, entry.kernel, entry.scales, entry.rank)
    if key not in known.bases:
        inputs = np.concatenate([_inputs(sight, group) for group in pooled])
        rank = max(1, min(entry.rank, MOST_FEATURES // max(entry.blocks, 1)))
        known.bases[key] = basis_of(entry.kernel, np.array(entry.scales), inputs, rank)
    basis = known.bases[key]
    if basis is None:
        return None
    channels = _commensurable(entry.channels, maps[0], sight)
    terms = []
    for channel in channels:
        if (*key, channel.inputs) not in known.values:
            known.values[*key, channel.inputs] = basis.values(_inputs(sight, channel.inputs))
        if channel.amplitude not in known.amplitudes:
            one = np.ones(int(sight.counts.sum()))
            known.amplitudes[channel.amplitude] = (
                one if channel.amplitude is None else _inputs(sight, (channel.amplitude,))[:, 0]
            )
        features = known.values[*key, channel.inputs]
        terms.append(
            Summand(channel.output, channel.block, features, known.amplitudes[channel.amplitude], channel.gain)
        )
    columns = Mapped(maps[1], tuple(terms), entry.blocks)
    flat = columns.matrix()
    gram = flat.T @ flat
    size = float(gram.trace() / max(len(flat), 1))
    if not np.isfinite(size) or size <= 0.0:
        return None
    factor = 1.0 / np.sqrt(size)
    scaled = tuple(replace(channel, gain=channel.gain * factor) for channel in channels)
    return Atom(entry.component, replace(columns, scale=factor), gram / size, replace(entry, channels=scaled), basis)


def known_form(
    component: Component, directions: Dense, what: Any, start: FloatArray, *, one_sided: bool
) -> Atom | None:
    """Physics of known form with parameters of unknown size; None where no reading shows it.

    Args:
        component: where it acts.
        directions: whitened derivatives of the readings (M, d).
        what: that has them.
        start: of all its parameters.
        one_sided: whether its one weight cannot be negative.
    """
    matrix = directions.matrix()
    gram = matrix.T @ matrix
    sizes = np.sqrt(gram.diagonal() / len(matrix))
    shown = sizes > 0.0
    if not shown.any() or not np.isfinite(sizes).all():
        return None
    scale = np.where(shown, 1.0 / np.where(shown, sizes, 1.0), 0.0) / np.sqrt(shown.sum())
    columns, known = replace(directions, scale=scale), (what, start, scale)
    return Atom(component, columns, gram * np.outer(scale, scale), named=known, one_sided=one_sided)


def _inputs(sight: Sight, quantities: tuple[Quantity, ...]) -> FloatArray:
    """In the rows that count, shape (N, d)."""
    return np.column_stack([sight.values(quantity)[sight.counts] for quantity in quantities])


def _commensurable(channels: tuple[Channel, ...], maps: FloatArray, sight: Sight) -> tuple[Channel, ...]:
    """Gains that make amplitudes of different units alike, and translations and rotations of u alike in the readings.

    Channels of one block follow one law, and keep their sizes relative to each other.
    """
    if len({channel.block for channel in channels}) == 1:
        return channels
    d = len(sight.robot.gravity)
    several = maps.shape[2] == sight.robot.coordinates.n and maps.shape[2] > d
    sizes = np.sqrt((maps**2).mean(axis=(0, 1)))
    groups = [np.sqrt((sizes[:d] ** 2).mean()), np.sqrt((sizes[d:] ** 2).mean())] if several else [1.0, 1.0]
    found = []
    for channel in channels:
        size = groups[0 if channel.output < d or not several else 1] or 1.0
        amplitude = 1.0 if channel.amplitude is None else (sight.largest(channel.amplitude) or 1.0)
        if several or channel.amplitude is None or channel.amplitude.kind != "effort":
            found.append(replace(channel, gain=channel.gain / (size * amplitude)))
        else:
            found.append(channel)
    return tuple(found)


def law_of(
    atom: Atom, variance: float, weights: FloatArray, sight: Sight, robot: Robot, number: int
) -> tuple[Law, FloatArray]:
    """The link of a law and its parameters, from its weights in the dictionary's features (f,)."""
    entry, basis = atom.entry, atom.basis
    assert entry is not None
    assert basis is not None
    blocks, rank = entry.blocks, basis.rank
    gram = np.zeros((rank, rank))
    for block in range(blocks):
        own = slice(block * rank, (block + 1) * rank)
        gram += atom.gram[own, own]
    values, vectors = np.linalg.eigh(gram)
    kept = np.flatnonzero(variance * values > _TELLING)[::-1]
    turned = vectors[:, kept if kept.size else [-1]]
    smaller = FeatureBasis(basis.kernel, basis.scales, basis.centres, basis.weights @ turned)
    counts = sight.counts
    low, high = [], []
    for channel in entry.channels:
        # Channels of one block are one law, such as that of a load less that of its reference, with one range.
        alike = {other.inputs for other in entry.channels if other.block == channel.block}
        seen = np.concatenate([np.column_stack([sight.values(q)[counts] for q in inputs]) for inputs in alike])
        low.append(seen.min(axis=0))
        high.append(seen.max(axis=0))
    form = LawForm(
        entry.port, entry.component, entry.form, entry.channels, smaller, np.array(low), np.array(high),
        float(np.sqrt(variance)),
    )  # fmt: skip
    law = Law(robot, form, number)
    start = np.concatenate([turned.T @ weights[b * rank : (b + 1) * rank] for b in range(blocks)])
    return law, np.concatenate([start, np.zeros(len(law.parameters) - len(start))])

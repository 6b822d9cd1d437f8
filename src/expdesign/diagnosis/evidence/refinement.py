"""Scales and settings of one law searched continuously by its evidence, from where the fixed grid led.

A grid of length scales, places, limits and times finds the law; how well it predicts depends on where exactly between
the points of the grid they are. The search is by coordinates, by factors and steps that are halved.
"""

from collections.abc import Callable, Collection, Iterator
from dataclasses import replace
from functools import partial

from expdesign.chain.ports.port import Channel, Entry
from expdesign.chain.ports.quantities import Quantity
from expdesign.diagnosis.evidence.dictionary import Atom
from expdesign.diagnosis.evidence.state import Present

_SWEEPS = 4
_LEAST_DROP = -0.5
"""An input is left out where that costs no more evidence."""


def refined(atom: Atom, of_entry: Callable[[Entry], Atom | None], present: Present) -> tuple[Atom, float] | None:
    """A better law of the same kind beside what is present, and its size; None where there is none."""
    if atom.entry is None:
        return None
    first, variance = present.gain(atom.directions)
    best, size, found = first, variance, atom
    current = replace(atom.entry, channels=tuple(_ungained(c, atom.entry) for c in atom.entry.channels))
    factor = 2.0
    for _ in range(_SWEEPS):
        for move in _moves(current, factor):
            trial = move(current)
            made = of_entry(trial)
            if made is None:
                continue
            gain, variance = present.gain(made.directions)
            dropped = len(trial.scales) < len(current.scales)
            if gain > best + (_LEAST_DROP if dropped else 1e-3):
                best, size, found, current = gain, variance, made, trial
        factor = factor**0.5
    return None if found is atom else (found, size)


def _ungained(channel: Channel, entry: Entry) -> Channel:
    """Channels of one block keep their relative gains, all others take theirs anew, with their signs."""
    return channel if entry.blocks == 1 else replace(channel, gain=1.0 if channel.gain > 0.0 else -1.0)


def _moves(entry: Entry, factor: float) -> Iterator[Callable[[Entry], Entry]]:
    """Changes to try: of all scales, of each scale, of settings, and inputs left out."""
    count, steps = len(entry.scales), (factor, 1.0 / factor)
    if entry.kernel not in ("linear", "constant"):
        yield from (partial(_scaled, some=range(count), by=step) for step in steps)
        for i in range(count if count > 1 else 0):
            yield from (partial(_scaled, some=(i,), by=step) for step in steps)
            yield partial(_dropped, index=i)
    kinds = {q.setting: q.kind for q in reversed(entry.quantities)}
    for setting in dict.fromkeys(q.setting for q in entry.quantities if q.setting):
        for other in _other_settings(kinds[setting], setting, factor):
            yield partial(_with_setting, old=setting, new=other)


def _scaled(entry: Entry, some: Collection[int], by: float) -> Entry:
    return replace(entry, scales=tuple(s * by if i in some else s for i, s in enumerate(entry.scales)))


def _dropped(entry: Entry, index: int) -> Entry:
    """Without one input."""
    if len(entry.scales) < 2 or index >= len(entry.scales):
        return entry
    channels = tuple(replace(c, inputs=tuple(q for i, q in enumerate(c.inputs) if i != index)) for c in entry.channels)
    return replace(entry, channels=channels, scales=tuple(s for i, s in enumerate(entry.scales) if i != index))


def _other_settings(kind: str, setting: tuple[float, ...], factor: float) -> Iterator[tuple[float, ...]]:
    """With one of the numbers changed: a share by steps, times and limits by factors, anything else by its size."""
    for index, value in enumerate(setting):
        if kind == "latched" and index == 1:
            continue
        if kind == "lag" and index == 1:
            changed = [min(max(value + d, 0.0), 1.0) for d in (0.5 * (factor - 1.0), -0.5 * (factor - 1.0))]
        elif kind in ("stop", "lag", "latched"):
            changed = [value * factor**0.5, value / factor**0.5]
        else:
            step = 0.1 * (factor - 1.0) * max(abs(v) for v in setting)
            changed = [value + step, value - step]
        for other in changed:
            if other != value:
                yield tuple(round(other, 9) if i == index else v for i, v in enumerate(setting))


def _with_setting(entry: Entry, old: tuple[float, ...], new: tuple[float, ...]) -> Entry:
    def changed(quantity: Quantity) -> Quantity:
        return replace(quantity, setting=new) if quantity.setting == old else quantity

    channels = (
        replace(c, inputs=tuple(map(changed, c.inputs)), amplitude=c.amplitude and changed(c.amplitude))
        for c in entry.channels
    )
    return replace(entry, channels=tuple(channels))

"""Scales and settings of one law searched continuously by its evidence, from where the fixed grid led.

A grid of length scales, places, limits and times finds the law; how well it predicts depends on where exactly between
the points of the grid they are. The search is by coordinates, by factors and steps that are halved.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace

from expdesign.chain.ports.port import Channel, Entry
from expdesign.chain.ports.quantities import Quantity
from expdesign.diagnosis.evidence.dictionary import Atom
from expdesign.diagnosis.evidence.state import Present

_SWEEPS = 4
_WORTH = 0.5
"""Gain of log evidence by which a refined law must exceed the one it came from."""
_LEAST_DROP = -0.5
"""An input is left out where that costs no more evidence."""


def refined(atom: Atom, of_entry: Callable[[Entry], Atom | None], present: Present) -> tuple[Atom, float] | None:
    """A better law of the same kind beside what is present, and its size; None where there is none."""
    if atom.entry is None:
        return None

    def judged(entry: Entry) -> tuple[float, float, Atom | None]:
        made = of_entry(entry)
        if made is None:
            return -1.0, 0.0, None
        return (*present.gain(made.directions), made)

    first, variance = present.gain(atom.directions)
    best: tuple[float, float, Atom] = (first, variance, atom)
    fresh = replace(atom.entry, channels=tuple(_ungained(c, atom.entry) for c in atom.entry.channels))
    current = fresh
    factor = 2.0
    for _ in range(_SWEEPS):
        for move in _moves(current, factor):
            trial = move(current)
            gain, size, made = judged(trial)
            dropped = len(trial.scales) < len(current.scales)
            if made is not None and gain > best[0] + (_LEAST_DROP if dropped else 1e-3):
                best, current = (gain, size, made), trial
        factor = factor**0.5
    return (best[2], best[1]) if best[0] > first + _WORTH or best[2] is not atom else None


def _ungained(channel: Channel, entry: Entry) -> Channel:
    """Channels of one block keep their relative gains, all others take theirs anew, with their signs."""
    return channel if entry.blocks == 1 else replace(channel, gain=1.0 if channel.gain > 0.0 else -1.0)


Move = Callable[[Entry], Entry]


def _moves(entry: Entry, factor: float) -> Iterator[Move]:
    """Changes to try: of all scales, of each scale, of settings, and inputs left out."""
    count = len(entry.scales)
    if entry.kernel not in ("linear", "constant"):
        for change in (factor, 1.0 / factor):
            yield lambda e, c=change: replace(e, scales=tuple(c * s for s in e.scales))  # type: ignore[misc]
        if count > 1:
            for i in range(count):
                for change in (factor, 1.0 / factor):
                    yield lambda e, i=i, c=change: _scaled(e, i, c)  # type: ignore[misc]
                yield lambda e, i=i: _dropped(e, i)  # type: ignore[misc]
    quantities = [q for q in entry.quantities if q.setting]
    for setting in dict.fromkeys(q.setting for q in quantities):
        kind = next(q.kind for q in quantities if q.setting == setting)
        for i in range(len(setting)):
            for other in _other_settings(kind, setting, i, factor):
                yield lambda e, s=setting, o=other: _with_setting(e, s, o)  # type: ignore[misc]


def _scaled(entry: Entry, index: int, factor: float) -> Entry:
    if index >= len(entry.scales):
        return entry
    return replace(entry, scales=tuple(s * factor if i == index else s for i, s in enumerate(entry.scales)))


def _dropped(entry: Entry, index: int) -> Entry:
    """Without one input."""
    if len(entry.scales) < 2 or index >= len(entry.scales):
        return entry
    channels = tuple(replace(c, inputs=tuple(q for i, q in enumerate(c.inputs) if i != index)) for c in entry.channels)
    return replace(entry, channels=channels, scales=tuple(s for i, s in enumerate(entry.scales) if i != index))


def _other_settings(kind: str, setting: tuple[float, ...], index: int, factor: float) -> Iterator[tuple[float, ...]]:
    value = setting[index]
    if kind == "lag" and index == 1:
        changed = [min(max(value + d, 0.0), 1.0) for d in (0.5 * (factor - 1.0), -0.5 * (factor - 1.0))]
    elif kind in ("stop", "lag", "latched"):
        if kind == "latched" and index == 1:
            return
        changed = [value * factor**0.5, value / factor**0.5]
    else:
        step = 0.1 * (factor - 1.0) * max(abs(v) for v in setting)
        changed = [value + step, value - step]
    for other in changed:
        if other != value:
            yield tuple(round(other, 9) if i == index else v for i, v in enumerate(setting))


def _with_setting(entry: Entry, old: tuple[float, ...], new: tuple[float, ...]) -> Entry:
    def changed(quantity: Quantity | None) -> Quantity | None:
        if quantity is None or quantity.setting != old:
            return quantity
        return replace(quantity, setting=new)

    channels = []
    for channel in entry.channels:
        inputs = tuple(q for q in (changed(q) for q in channel.inputs) if q is not None)
        channels.append(replace(channel, inputs=inputs, amplitude=changed(channel.amplitude)))
    return replace(entry, channels=tuple(channels))

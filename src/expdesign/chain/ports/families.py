"""Prior families that several ports share: covariance functions over what a port sees, lengths on a fixed grid."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from expdesign.chain.ports.port import Channel, Prior
from expdesign.chain.ports.quantities import Quantity
from expdesign.chain.ports.sight import Sight
from expdesign.chain.row import LAGS

FINE = (0.25, 0.5, 1.0, 2.0)
"""Length scales over one input, in standard deviations of it."""
COARSE = (1.0, 2.0, 4.0)
"""The same over several inputs."""
PERIODS = 14
"""Periods that are tried, so that at least about three of them fit into the range of a length."""
_BEYOND = (0.05, 0.1, 0.14, 0.2, 0.28, 0.4, 0.8)
"""Where guides end, in ranges of the place beyond its range."""
_AT_START = {"clock": "started", "temperature": "warmth", "slow_temperature": "slow_warmth"}
"""What changes slowly, and what the same was at the first row of the series."""
_JUMPS = 20
"""Times at which something may have jumped, evenly among the rows; the search goes on between them."""
SHARES = (0.05, 0.15, 0.3, 0.6, 1.0)
"""Thresholds of a bank of stop operators, as shares of the largest value that they follow."""


def smooth_over(sight: Sight, form: str, inputs: tuple[Quantity, ...], rank: int = 16) -> Iterator[Prior]:
    """Squared exponentials over what varies of the inputs."""
    alone = sum(sight.spread(quantity) > 0.0 for quantity in inputs) == 1
    return _over("squared_exponential", FINE if alone else COARSE, sight, form, inputs, rank)


def _over(
    kernel: str, factors: tuple[float, ...], sight: Sight, form: str, inputs: tuple[Quantity, ...], rank: int = 30
) -> Iterator[Prior]:
    varying = tuple(quantity for quantity in inputs if sight.spread(quantity) > 0.0)
    for factor in factors if varying else ():
        yield Prior(form, kernel, varying, tuple(factor * sight.spread(q) for q in varying), rank)


kinks_over = partial(_over, "arc_cosine", (0.5, 1.5))
"""Half-planes over what varies of several inputs."""
steps_over = partial(_over, "step_cosine", (0.3, 2.0))
"""Steps at half-planes of several inputs: what gives way until it touches."""


def of_effort(sight: Sight, effort: Quantity) -> Iterator[Prior]:
    """Laws of an effort that vanish without it: smooth, with corners, with a step at 0."""
    largest, spread = sight.largest(effort), sight.spread(effort)
    if spread == 0.0:
        return
    for factor in FINE:
        yield Prior("force law", "pinned", (effort,), (factor * spread,), 12)
    yield Prior("force law", "wiener", (effort,), (largest,), 16)
    yield Prior("force law", "integrated_wiener", (effort,), (largest,), 12)
    sign = Quantity("effort_sign", effort.index)
    if effort.kind == "effort" and sight.varies(sign):
        # To either side its own way: what has play may rest at one end of it.
        yield Prior("step at zero", "wiener", (sign,), (1.0,), 2)


def over_time(sight: Sight, form: str) -> Iterator[Prior]:
    """Slow change: since the first row of all, and since the start of the series."""
    if not sight.timed:
        return
    for kind in ("clock", "elapsed"):
        time = Quantity(kind)
        if sight.varies(time):
            yield Prior(form, "wiener", (time,), (sight.largest(time),), 24)
            for factor in (0.2, 0.5, 1.5):
                yield Prior(form, "squared_exponential", (time,), (factor * sight.spread(time),), 24)


def jumps(sight: Sight, form: str = "jump") -> Iterator[Prior]:
    """A change from one row to the next that stays: what slips, is knocked or is screwed down again.

    Of a displacement positions alone show it for longer than a series.
    """
    if not sight.timed or not sight.varies(Quantity("clock")) or (form == "jump" and not sight.positions):
        return
    times = np.unique(sight.values(Quantity("clock"))[sight.counts])
    between = np.unique(np.linspace(0, len(times) - 2, min(_JUMPS, len(times) - 1)).round().astype(int))
    for index in between:
        yield Prior(
            form, "linear", (Quantity("after", 0, (round(float(times[index : index + 2].mean()), 6),)),), (1.0,), 1
        )


def memory_of(sight: Sight, effort: Quantity) -> Iterator[Prior]:
    """What remembers an effort: a bank of stop operators (dry friction), and slow parts (creep)."""
    if sight.spread(effort) == 0.0 or not sight.remembers:
        return
    bank, lags = stops(sight, effort), _lags(sight, effort)
    varying = tuple(q for q in bank if sight.spread(q) > 0.0)
    if varying:
        yield Prior("friction", "linear", varying, tuple(sight.spread(q) for q in varying), len(varying))
    for applied in (0.0, 1.0):
        slow = tuple(q for q in lags if q.setting[1] == applied and sight.spread(q) > 0.0)
        if slow:
            yield Prior("creep", "linear", slow, tuple(sight.spread(q) for q in slow), len(slow))
        for quantity in slow:
            yield Prior("creep", "linear", (quantity,), (sight.spread(quantity),), 1)


def since_start(sight: Sight, channels: Iterable[Channel]) -> tuple[Channel, ...]:
    """Channels of a displacement, and for each that follows clock or temperature what it was at the series' first row.

    A deflection is the change since then, so that of a displacement f(t) it shows f(t) − f(t_first).
    """
    found = []
    for channel in channels:
        found.append(channel)
        (seen, *others) = channel.inputs
        if seen.kind in _AT_START and not others and not sight.positions:
            first = replace(seen, kind=_AT_START[seen.kind])
            found.append(replace(channel, inputs=(first,), gain=-channel.gain))
    return tuple(found)


def over_temperature(sight: Sight, form: str, index: int) -> Iterator[Prior]:
    """Slow change with the temperature: in proportion, any smooth function of it, and as it is followed slowly.

    A displacement is in proportion to the warming since the series' first row. A compliance has the temperature itself
    for its input, counted from its mean: a constant part is the spring's, which cannot be negative.
    """
    temperature = Quantity("temperature", index)
    straight = Quantity("warming", index)
    if form == "compliance":
        straight = Quantity("temperature", index, (round(float(sight.values(temperature)[sight.counts].mean()), 3),))
    if sight.varies(straight):
        yield Prior(form, "linear", (straight,), (sight.spread(straight),), 1)
    yield from smooth_over(sight, form, (temperature,), 8)
    yield from after_temperature(sight, form)


def after_temperature(sight: Sight, form: str) -> Iterator[Prior]:
    """Slow change in proportion to a temperature that follows the recorded one to first order (`row.LAGS`)."""
    slow = [Quantity("slow_temperature", index) for index in range(len(LAGS))] if sight.timed else []
    sight.look(slow)
    for quantity in slow:
        counted = replace(quantity, setting=(round(float(sight.values(quantity)[sight.counts].mean()), 3),))
        if sight.varies(quantity):
            yield Prior(form, "linear", (counted,), (sight.spread(quantity),), 1)


def by_approach(sight: Sight, actuator: int) -> Iterator[Prior]:
    """A place that depends on the way in which an actuator came there; deflections are relative to the same place."""
    last = Quantity("approach", actuator)
    if sight.positions and sight.varies(last):
        yield Prior("approach", "linear", (last,), (1.0,), 1)


def look_back(sight: Sight, efforts: Iterable[Quantity]) -> None:
    """Evaluate together whatever remembers these efforts: one by one that takes longer than everything else."""
    if sight.remembers:
        sight.look(q for effort in efforts for q in (*stops(sight, effort), *_lags(sight, effort)))


def stops(sight: Sight, effort: Quantity) -> tuple[Quantity, ...]:
    """A bank of stop operators of an effort."""
    largest = sight.largest(effort)
    return tuple(Quantity("stop", effort.index, (round(share * largest, 12),)) for share in SHARES)


def _lags(sight: Sight, effort: Quantity) -> tuple[Quantity, ...]:
    times = time_constants(sight)
    return tuple(Quantity("lag", effort.index, (time, applied)) for applied in (0.0, 1.0) for time in times)


def time_constants(sight: Sight) -> tuple[float, ...]:
    """Time constants (s) from a third of the usual interval to three times the longest series."""
    if not sight.timed:
        return ()
    elapsed = sight.values(Quantity("elapsed"))
    steps = sight.values(Quantity("clock"))
    gaps = np.diff(steps)[np.diff(sight.rows.series) == 0]
    gaps = gaps[gaps > 0.0]
    if gaps.size == 0 or elapsed.max() <= 0.0:
        return ()
    shortest, longest = float(np.median(gaps)) / 3.0, 3.0 * float(elapsed.max())
    return tuple(round(float(t), 6) for t in np.geomspace(shortest, max(longest, 2.0 * shortest), 5))


def guide_ends(sight: Sight, place: Quantity) -> list[Quantity]:
    """Reciprocals of what guides overlap, for ends of the guides at several distances beyond the range of a place."""
    values = sight.values(place)[sight.counts]
    low, high = float(values.min()), float(values.max())
    found = []
    for share in _BEYOND:
        for end, way in ((high + share * (high - low), 1.0), (low - share * (high - low), -1.0)):
            found.append(Quantity("overlap", place.index, (round(end, 6), way)))
    return [overlap for overlap in found if sight.spread(overlap) > 0.0]


def repeating(sight: Sight, form: str, length: Quantity) -> Iterator[Prior]:
    """Errors that repeat with a length: a grid of periods."""
    spread = sight.spread(length)
    if spread > 0.0:
        for period in np.geomspace(0.1 * spread, 1.2 * spread, PERIODS):
            yield Prior(form, "periodic", (length,), (float(period),), 4)

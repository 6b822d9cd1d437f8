"""What the fit of an arm's positions says of the instrument: places that jump between rows, and its scale.

A marker that was seated anew leaves residuals that jump once in the axes of the tip, an instrument that was moved in
its own. A jump is a change point of the mean of a marker's residuals in the order of recording (F-test, for all
places), larger than what is left beside it and, unlike a drift, as large between the rows next to it.

An instrument whose scale is 1 + s reads (1 + s)·y. Positions tell s from lengths only by how machines are made: with
priors of manufacture the cost of the linearised fit falls by Δ where s is free within a prior of its own.
"""

from collections.abc import Iterator

import numpy as np
from scipy.special import fdtrc

from expdesign.arrays import FloatArray, IntArray
from expdesign.assurance.plausibility.finding import Implausibility
from expdesign.chain.readings.position import MarkerPosition
from expdesign.chain.recordings.recordings import Recordings
from expdesign.estimation.arm import ArmCalibration
from expdesign.estimation.arm_problem import sizes_of
from expdesign.estimation.gaussian import Gaussian
from expdesign.mechanics.robots.orientation import arrays_in_space, rotations_of

SHORTEST = 4
"""Rows of a marker between two changes of its place."""
NEAR, SHARP = 6, 0.6
"""Rows on either side that are compared closely, and the part of a jump that has to be between them."""
CHANCE = 1e-6
"""p-value of a jump, for all places that were tried."""
LARGE = 2.0
"""RMS of what is left beside a jump, in parts of which it is large."""
SCALE = 0.01
"""Standard deviation of an instrument's scale beforehand: of a camera's target that was printed or measured wrong."""
LIKELIER = 20.0
"""Fall of the cost from which a scale is named: e¹⁰ times the likelihood."""


def instrument_findings(found: ArmCalibration, recordings: Recordings) -> list[Implausibility]:
    """Jumps and a scale that the fit of all rows shows."""
    train, reading = recordings.rows(found.fitted), found.fit.chain.reading
    if not isinstance(reading, MarkerPosition) or reading.unplaced or (train.axes < 3).sum() != 3:
        return []
    jump = max(_jumps(found, train, reading), key=lambda each: each[0], default=None)
    findings = [] if jump is None else [jump[1]]
    return [*findings, *_scale(found, train)]


def _jumps(found: ArmCalibration, train: Recordings, reading: MarkerPosition) -> Iterator[tuple[float, Implausibility]]:
    """Each marker whose place changes, with the largest jump (m)."""
    fit, robot = found.fit, found.fit.chain.robot
    assert train.marker is not None
    own = fit.values[fit.chain.compliances : fit.chain.base]
    frames = rotations_of(reading.frames(own)[:, 3:])[train.marker]
    tips = arrays_in_space(train.configurations[:, :3], robot.jacobians(train.configurations).rotation)[1]
    left = (fit.residuals * found.noise.deviations)[:, :3]
    for index, marker in enumerate(train.markers):
        mine = np.flatnonzero((train.marker == index) & np.isfinite(train.deflections[:, :3]).all(axis=1))
        if len(mine) < 2 * SHORTEST:
            continue
        on_tip = np.einsum("nji,njk,nk->ni", tips[mine], frames[mine], left[mine])
        seated, moved = (change_points(each) for each in (on_tip, left[mine]))
        if not seated and not moved:
            continue
        session = _within(on_tip, seated) <= _within(left[mine], moved)
        values, changes = (on_tip, seated) if session else (left[mine], moved)
        means = np.array([part.mean(axis=0) for part in np.split(values, changes)])
        sizes = np.linalg.norm(np.diff(means, axis=0), axis=1)
        lines = [int(train.lines[mine[change]]) for change in changes]
        jumps = ", ".join(f"{1e3 * size:.2g} mm before row {line}" for size, line in zip(sizes, lines, strict=True))
        where = f"in the axes of {'the tip' if session else 'the instrument'}"
        what = f"what is left of marker `{marker}` jumps {where}: by {jumps}"
        did, column = ("the marker seated anew", "session") if session else ("the instrument moved", "station")
        likely = f"Was {did}? Add a column `{column}`: 1 before the first of these rows, and one more from each on."
        yield float(sizes.max()), Implausibility(what, likely)


def change_points(values: FloatArray) -> list[int]:
    """Rows from which on the mean of values (N, 3) is another one, in their order."""
    count = len(values)
    if count < 2 * SHORTEST:
        return []
    places: IntArray = np.arange(SHORTEST, count - SHORTEST + 1)
    sums, total = np.cumsum(values, axis=0), float(((values - values.mean(axis=0)) ** 2).sum())
    before = sums[places - 1]
    jumps = (sums[-1] - before) / (count - places)[:, None] - before / places[:, None]
    between = places * (count - places) / count * (jumps**2).sum(axis=1)
    best = int(np.argmax(between))
    place, jump, within = int(places[best]), jumps[best], max(total - float(between[best]), 1e-300)
    dof = 3 * (count - 2)
    chance = len(places) * float(fdtrc(3, dof, between[best] / 3.0 / (within / dof)))
    near = min(NEAR, place, count - place)
    local = values[place : place + near].mean(axis=0) - values[place - near : place].mean(axis=0)
    size = float(np.linalg.norm(jump))
    sharp = float(local @ jump) > SHARP * size**2
    if chance > CHANCE or not sharp or size < LARGE * np.sqrt(within / count):
        return []
    return [*change_points(values[:place]), place, *(place + each for each in change_points(values[place:]))]


def _within(values: FloatArray, changes: list[int]) -> float:
    """Sum of squares about the means of the parts."""
    return sum(float(((part - part.mean(axis=0)) ** 2).sum()) for part in np.split(values, changes))


def _scale(found: ArmCalibration, train: Recordings) -> list[Implausibility]:
    """A scale of the instrument that is far likelier than lengths which are all off by the same part."""
    fit, live = found.fit, found.minimal.kept
    sizes = found.minimal.widened(sizes_of(fit.chain)[0])[live]
    neutral = np.array([parameter.neutral for parameter in fit.chain.parameters])
    readings = np.flatnonzero(train.axes < 3)
    seen = np.isfinite(train.deflections[:, readings])
    predicted = (train.deflections / found.noise.deviations - fit.residuals)[:, readings][seen]
    columns, right = fit.sensitivities[:, readings][seen][:, live], fit.residuals[:, readings][seen]
    off = np.where(np.isfinite(sizes), (neutral - fit.values)[live], 0.0)
    without = Gaussian(columns, right, sizes, off)
    whole = Gaussian(np.column_stack([columns, predicted]), right, np.append(sizes, SCALE), np.append(off, 0.0))
    fall, scale = without.chi2 - whole.chi2, float(whole.estimate[-1])
    if fall < LIKELIER:
        return []
    times = f"e^{0.5 * fall:.0f} times likelier"
    what = f"a scale of the instrument of {1.0 + scale:.4f} is {times} than lengths that are all off by the same part"
    likely = (
        f"Are distances {100.0 * abs(scale):.2g} % too {'large' if scale > 0.0 else 'small'} (the size of a target, a "
        f"unit)? Multiply positions by {1.0 / (1.0 + scale):.5f}. Positions alone do not tell a scale from lengths; a "
        "known length does."
    )
    return [Implausibility(what, likely)]

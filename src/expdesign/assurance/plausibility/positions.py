"""Positions of markers: would another unit, frame or sign make them fit the robot?

The instrument is registered and the markers are placed for the nominal robot at the commands as they are, and as they
would be under each hypothesis. The misfit is the RMS of what the registration leaves over, in parts of the spread of
the readings: below a per cent for any machine that was built, near one where angles are in degrees or a frame is
left-handed, since no rotation maps a mirrored cloud of points onto the other.
"""

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations, product

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.assurance.plausibility.finding import Finding, extent
from expdesign.assurance.plausibility.mistakes.numbers import agreeing_rows
from expdesign.assurance.plausibility.options import DEFAULT
from expdesign.chain.readings.choice import reading_of
from expdesign.chain.readings.position import MarkerPosition
from expdesign.chain.readings.registration import registration_residuals
from expdesign.chain.recordings.recordings import POSITION, Recordings
from expdesign.errors import NotIdentifiableError
from expdesign.mechanics.robots.kinematic_tree import PAYLOAD_COLUMNS
from expdesign.mechanics.robots.robot import Robot

POOR = 0.05
"""Share of the spread of the readings that a registration of the nominal robot leaves over only for a mistake."""
GAIN = 4.0
"""Factor by which a hypothesis must reduce the misfit."""
_FEWEST = 8
"""Fitted rows below which a registration fits anything."""
_LARGER = 3.0
"""Spread of the readings over that of the tip's nominal places, beyond which they cannot be in the same unit."""
_ARM = 0.2
"""m; how far from the tip a marker may be taken to sit."""
_FARTHEST, _SLACK = 2.0, 2.0
"""Times the span of the robot, and m: no payload is farther away than both together."""
_DEGREES = 180.0 / np.pi
_ROWS = 120
"""Rows with which hypotheses are compared."""


def positions_findings(recordings: Recordings, robot: Robot) -> list[Finding]:
    """What speaks against units, signs and frames of positions of markers, beside commands of a serial robot."""
    some = np.flatnonzero(~recordings.test)
    some = some[:: -(-len(some) // _ROWS) or 1]
    train = recordings.rows(some)
    if not robot.jointed:
        return []
    payloads = _payloads(recordings, robot)
    if payloads or len(train) < _FEWEST:
        return payloads
    units = _units(train, robot)
    if units:
        return units
    stated = _misfit(train, robot)
    if stated is None or stated < POOR:
        return [] if stated is None else _copies(recordings, train, robot)
    tried = [(_misfit(other, robot), text) for text, other in (*_hypotheses(train, robot), *_shifts(recordings, some))]
    least, text = min(((misfit, text) for misfit, text in tried if misfit is not None), default=(np.inf, ""))
    if GAIN * least >= stated:
        return []
    left = f"{100 * stated:.0f} % of the spread of the positions is left after registration"
    return [Finding(f"{left}, where {100 * least:.2g} % would be", text)]


def _payloads(recordings: Recordings, robot: Robot) -> list[Finding]:
    """Payloads of the tip and of other links whose centres of mass are farther away than the robot could hold them."""
    tree, size = robot.links.tree, extent(robot) or 0.0
    centres = {"com_x_m": recordings.payload[:, 1:]} if recordings.payload is not None else {}
    for carrier in tree.carriers:
        first = robot.configuration.index(f"{carrier}_{PAYLOAD_COLUMNS[1]}")
        centres[robot.configuration[first]] = recordings.configurations[:, first : first + 3]
    found = []
    for column, centre in centres.items():
        farthest = float(np.linalg.norm(centre, axis=1).max(initial=0.0))
        if farthest > _FARTHEST * size + _SLACK:
            what = f"a payload's centre of mass lies {farthest:.3g} m away, but the robot spans {size:.3g} m"
            likely = "Write centres of mass in m: they look like mm."
            found.append(Finding(what, likely, f"column {column}", impossible=True))
    return found


def _units(train: Recordings, robot: Robot) -> list[Finding]:
    """Readings that spread over many times what the tip does are in another unit, whatever the frames."""
    rotations = robot.jacobians(train.configurations).rotation.reshape(len(train), -1)
    own, tip, turn = (_spread(x) for x in (train.deflections, robot.position(train.configurations), rotations))
    nominal = tip + _ARM * turn
    ratio = own / max(nominal, 1e-12)
    for factor, unit in ((1e3, "mm"), (1e6, "µm")):
        if factor / _LARGER < ratio < factor * _LARGER:
            what = f"the positions spread over {own:.3g} m, and the tip of the robot over {tip:.3g} m"
            return [Finding(what, f"Write them in m: they look like {unit}.", f"column {POSITION[0]}", impossible=True)]
    return []


def _spread(points: FloatArray) -> float:
    """RMS distance of points (N, d) from their mean."""
    return float(np.sqrt(((points - points.mean(axis=0)) ** 2).sum(axis=1).mean()))


def _hypotheses(train: Recordings, robot: Robot) -> Iterator[tuple[str, Recordings]]:
    def commands(factors: FloatArray) -> Recordings:
        return replace(train, configurations=train.configurations * factors)

    def readings(values: FloatArray) -> Recordings:
        return replace(train, deflections=values)

    names = robot.configuration
    angles = np.array([name.endswith("_rad") for name in names])
    yield (
        "Are the joint coordinates in degrees? They have to be in rad.",
        commands(np.where(angles, 1.0 / _DEGREES, 1.0)),
    )
    yield (
        "Is the instrument's frame left-handed, or one of px_m, py_m and pz_m of the wrong sign?",
        readings(train.deflections * [-1.0, 1.0, 1.0]),
    )
    for index in range(len(robot.stiffness)):
        turned = np.ones(len(names))
        turned[index] = -1.0
        yield f"Has {names[index]} the wrong sign?", commands(turned)
        turned[index] = 1.0 / _DEGREES if angles[index] else 1e-3
        yield f"Is {names[index]} in {'degrees' if angles[index] else 'mm'}?", commands(turned)
    for first, second in combinations(range(len(robot.stiffness)), 2):
        order = np.arange(len(names))
        order[[first, second]] = second, first
        swapped = replace(train, configurations=train.configurations[:, order])
        yield f"Are the columns {names[first]} and {names[second]} swapped?", swapped
    yield from _slips(train, robot)


def _shifts(recordings: Recordings, some: IntArray) -> Iterator[tuple[str, Recordings]]:
    """Some rows with the readings of the next ones, or of those before."""
    for shift, word in ((-1, "late"), (1, "early")):
        rows = some[(some - shift >= 0) & (some - shift < len(recordings))]
        shifted = replace(recordings, deflections=np.roll(recordings.deflections, shift, axis=0)).rows(rows)
        yield f"Do the readings stand one row too {word}? Shift them against the other columns.", shifted


def _slips(train: Recordings, robot: Robot) -> Iterator[tuple[str, Recordings]]:
    """A single reading with a slipped decimal point or the wrong sign, in the rows that fit worst."""
    left = _left(train, robot)
    for row in np.argsort(-np.linalg.norm(left, axis=1))[:2] if left is not None else ():
        for axis, factor in product(range(3), (10.0, 0.1, 100.0, 0.01, 1000.0, 0.001, -1.0)):
            readings = train.deflections.copy()
            readings[row, axis] /= factor
            times = f"{factor:g} times too large" if factor > 1.0 else f"{1.0 / factor:g} times too small"
            what = "of the wrong sign" if factor < 0.0 else f"{times}: did the decimal point slip"
            value = f"{POSITION[axis]} = {train.deflections[row, axis]:g} in row {train.lines[row]}"
            yield f"Is {value} {what}? Correct it.", replace(train, deflections=readings)


def _copies(recordings: Recordings, train: Recordings, robot: Robot) -> list[Finding]:
    """Rows whose positions agree far closer than positions repeat; `train` are those that are fitted."""
    left = _left(train, robot)
    if left is None:
        return []
    noise = np.sqrt((left**2).mean(axis=0)) / DEFAULT.repeatability**2
    runs = agreeing_rows(recordings.deflections, noise, DEFAULT.chance)
    if not runs:
        return []
    first, other = (recordings.lines[runs[0].first - back] for back in (runs[0].offset, 0))
    what = f"the readings of row {other} agree with those of row {first} far closer than readings repeat"
    return [Finding(what, "Were rows copied? Every row has to be measured; take them out.")]


def _left(train: Recordings, robot: Robot) -> FloatArray | None:
    """What registration leaves of every reading (m), shape (N, 3); None where nothing can be registered."""
    try:
        reading = reading_of(robot, train)
    except NotIdentifiableError:
        return None
    assert isinstance(reading, MarkerPosition)
    return registration_residuals(reading, robot, train)


def _misfit(train: Recordings, robot: Robot) -> float | None:
    """RMS of what registration leaves in parts of the spread of the readings; None where nothing can be registered."""
    left, spread = _left(train, robot), _spread(train.deflections)
    return float(np.sqrt((left**2).sum(axis=1).mean())) / spread if left is not None and spread > 0.0 else None

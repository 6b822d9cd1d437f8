"""Positions of markers: would another unit, frame or sign make them fit the robot?

The instrument is registered and the markers are placed for the nominal robot at the commands as they are, and as they
would be under each hypothesis. The misfit is the RMS of what the registration leaves over, in parts of the spread of
the readings: below a per cent for any machine that was built, near one where angles are in degrees or a frame is
left-handed, since no rotation maps a mirrored cloud of points onto the other. Measured orientations are judged by the
RMS angle that is left when every target is turned on its tip as suits best.
"""

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations, product

import numpy as np
from scipy.spatial.transform import Rotation

from expdesign.arrays import FloatArray, IntArray
from expdesign.assurance.plausibility.finding import Implausibility, extent
from expdesign.assurance.plausibility.mistakes.columns import DEGREE
from expdesign.assurance.plausibility.mistakes.numbers import agreeing_rows
from expdesign.assurance.plausibility.mistakes.rows import SHIFTS, SLIPS, divided, slip_text
from expdesign.assurance.plausibility.options import DEFAULT, MARKERS
from expdesign.chain.readings.choice import reading_of
from expdesign.chain.readings.position import MarkerPosition
from expdesign.chain.readings.registration import registration_residuals
from expdesign.chain.recordings.recordings import POSITION, Recordings, complete_positions
from expdesign.errors import NotIdentifiableError
from expdesign.mechanics.robots.kinematic_tree import PAYLOAD_COLUMNS, KinematicTree
from expdesign.mechanics.robots.robot import Robot


def positions_findings(recordings: Recordings, robot: Robot) -> list[Implausibility]:
    """What speaks against units, signs and frames of positions of markers, beside commands of a serial robot."""
    if not robot.jointed or 0 not in recordings.axes:
        return []
    positions = complete_positions(recordings)
    some = _some(positions)
    train = positions.rows(some)
    payloads = _payloads(recordings, robot)
    if payloads or len(train) < MARKERS.fewest:
        return payloads
    units = _units(train, robot)
    if units:
        return units
    standing = _standing(robot.links.tree)
    stated = _misfit(train, robot)
    if stated is None or stated < MARKERS.poor:
        return (
            standing
            if stated is None
            else [*standing, *_orientations(recordings, robot), *_copies(positions, train, robot)]
        )
    tried = [(_misfit(other, robot), text) for text, other in (*_hypotheses(train, robot), *_shifts(positions, some))]
    least, text = min(((misfit, text) for misfit, text in tried if misfit is not None), default=(np.inf, ""))
    if MARKERS.gain * least >= stated:
        return []
    left = f"{100 * stated:.0f} % of the spread of the positions is left after registration"
    return [Implausibility(f"{left}, where {100 * least:.2g} % would be", text, otherwise=True)]


def _some(recordings: Recordings) -> IntArray:
    """Fitted rows, spread evenly, with which hypotheses are compared."""
    fitted = np.flatnonzero(~recordings.test)
    return fitted[:: -(-len(fitted) // MARKERS.rows) or 1]


def _payloads(recordings: Recordings, robot: Robot) -> list[Implausibility]:
    """Payloads of the tip and of other links whose centres of mass are farther away than the robot could hold them."""
    tree, size = robot.links.tree, extent(robot) or 0.0
    centres = {"com_x_m": recordings.payload[:, 1:]} if recordings.payload is not None else {}
    for carrier in tree.carriers:
        first = robot.configuration.index(f"{carrier}_{PAYLOAD_COLUMNS[1]}")
        centres[robot.configuration[first]] = recordings.configurations[:, first : first + 3]
    found = []
    for column, centre in centres.items():
        farthest = float(np.linalg.norm(centre, axis=1).max(initial=0.0))
        if farthest > MARKERS.farthest * size + MARKERS.slack:
            what = f"a payload's centre of mass lies {farthest:.3g} m away, but the robot spans {size:.3g} m"
            likely = "Write centres of mass in m: they look like mm."
            found.append(Implausibility(what, likely, f"column {column}", impossible=True))
    return found


def _units(train: Recordings, robot: Robot) -> list[Implausibility]:
    """Readings that spread over many times what the tip does are in another unit, whatever the frames."""
    rotations = robot.jacobians(train.configurations).rotation.reshape(len(train), -1)
    own, tip, turn = (_spread(x) for x in (train.deflections, robot.position(train.configurations), rotations))
    nominal = tip + MARKERS.arm * turn
    ratio = own / max(nominal, 1e-12)
    for factor, unit in ((1e3, "mm"), (1e6, "µm")):
        if factor / MARKERS.larger < ratio < factor * MARKERS.larger:
            what = f"the positions spread over {own:.3g} m, and the tip of the robot over {tip:.3g} m"
            return [
                Implausibility(
                    what, f"Write them in m: they look like {unit}.", f"column {POSITION[0]}", impossible=True
                )
            ]
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
        commands(np.where(angles, DEGREE, 1.0)),
    )
    yield (
        "Is the instrument's frame left-handed, or one of px_m, py_m and pz_m of the wrong sign?",
        readings(train.deflections * [-1.0, 1.0, 1.0]),
    )
    for index in range(len(robot.stiffness)):
        turned = np.ones(len(names))
        turned[index] = -1.0
        yield f"Has {names[index]} the wrong sign?", commands(turned)
        turned[index] = DEGREE if angles[index] else 1e-3
        yield f"Is {names[index]} in {'degrees' if angles[index] else 'mm'}?", commands(turned)
    for first, second in combinations(range(len(robot.stiffness)), 2):
        order = np.arange(len(names))
        order[[first, second]] = second, first
        swapped = replace(train, configurations=train.configurations[:, order])
        yield f"Are the columns {names[first]} and {names[second]} swapped?", swapped
    yield from _tips(train, robot)
    yield from _slips(train, robot)


def _tips(train: Recordings, robot: Robot) -> Iterator[tuple[str, Recordings]]:
    """Markers on another of the tips than the rows say; all of them where there are two."""
    tips, numbers = robot.links.tree.tips, robot.tip_numbers(train.configurations)
    for index, marker in enumerate(train.markers if len(tips) > 1 else ()):
        mine = np.asarray(train.marker) == index
        for number in set(range(1, len(tips) + 1)) - set(numbers[mine].tolist()):
            moved = train.configurations.copy()
            moved[mine, -1] = number
            yield f"Does marker `{marker}` sit on `{tips[number - 1]}`?", replace(train, configurations=moved)
    if len(tips) == 2:
        moved = train.configurations.copy()
        moved[:, -1] = 3 - moved[:, -1]
        text = f"Are `{tips[0]}` and `{tips[1]}` swapped in the column tip?"
        yield text, replace(train, configurations=moved)


def _standing(tree: KinematicTree) -> list[Implausibility]:
    """Joints off the chain whose place nobody says, although they move weight that the chain carries."""
    joints = tree.urdf.joints.values()
    mass = {
        joint.name: tree.urdf.links[joint.child].mass
        + sum(tree.urdf.links[each.child].mass for each in joints if _hangs_on(each.parent, joint.child, tree))
        for joint in joints
        if joint.moves and tree.motion(joint) is None and tree.carries(joint.parent)
    }
    heavy = [name for name, own in mass.items() if own > MARKERS.heavy * float(tree.masses().sum())]
    if not heavy:
        return []
    named = ", ".join(f"`{name}`" for name in heavy)
    what = f"{named} of the URDF move up to {max(mass.values()):.3g} kg and have no column"
    likely = (
        f"They are taken to stand at 0. If they did not, add `branch_joints: [{', '.join(heavy)}]` and their columns."
    )
    return [Implausibility(what, likely, "robot file")]


def _hangs_on(link: str, ancestor: str, tree: KinematicTree) -> bool:
    """Whether a link is another one, or hangs on it."""
    above = {joint.child: joint.parent for joint in tree.urdf.joints.values()}
    while link != ancestor and link in above:
        link = above[link]
    return link == ancestor


def _orientations(recordings: Recordings, robot: Robot) -> list[Implausibility]:
    """Measured orientations that do not turn as the tip does, and would if they were written otherwise."""
    if recordings.aim is None:
        return []
    turned = recordings.rows(np.flatnonzero(np.isfinite(recordings.deflections).all(axis=1)))
    train = turned.rows(_some(turned))
    stated = _angle(train, robot) if len(train) >= MARKERS.fewest else None
    if stated is None or stated < MARKERS.turned or train.aim is None:
        return []
    other = Rotation.from_matrix(train.aim)
    x, y, z, w = other.as_quat().T
    angles = other.as_euler("xyz")
    hypotheses = {
        "Was a quaternion written as x, y, z, w and read as w, x, y, z?": np.column_stack([w, x, y, z]),
        "Was a quaternion written as w, x, y, z and read as x, y, z, w?": np.column_stack([y, z, w, x]),
        "Are they the instrument's orientations in the target's axes? Transpose them.": other.inv().as_quat(),
        "Are the angles in degrees? They have to be in rad.": Rotation.from_euler("xyz", angles * DEGREE).as_quat(),
        "Are the angles about moving axes, first z, then y, then x, in another order? They have to make Rz·Ry·Rx.":
            Rotation.from_euler("XYZ", angles).as_quat(),
    }  # fmt: skip
    tried = [
        (_angle(replace(train, aim=Rotation.from_quat(quaternions).as_matrix()), robot) or np.inf, text)
        for text, quaternions in hypotheses.items()
    ]
    least, text = min(tried)
    if MARKERS.gain * least >= stated:
        return []
    what = (
        f"the measured orientations are off by {stated:.2g} rad (RMS) after registration, and would be by {least:.2g}"
    )
    return [Implausibility(what, text, "column measured_rx_rad")]


def _angle(train: Recordings, robot: Robot) -> float | None:
    """RMS angle (rad) between measured orientations and those of the registered robot; None where none is measured."""
    registered = _registered(train, robot)
    if registered is None or train.aim is None:
        return None
    expected = registered.orientations(robot, train, registered.start)
    left = Rotation.from_matrix(expected @ train.aim.swapaxes(1, 2)).magnitude()
    return float(np.sqrt((left**2).mean()))


def _shifts(recordings: Recordings, some: IntArray) -> Iterator[tuple[str, Recordings]]:
    """Some rows with the readings of the next ones, or of those before."""
    for shift, word in SHIFTS:
        rows = some[(some - shift >= 0) & (some - shift < len(recordings))]
        shifted = replace(recordings, deflections=np.roll(recordings.deflections, shift, axis=0)).rows(rows)
        yield f"Do the readings stand one row too {word}? Shift them against the other columns.", shifted


def _slips(train: Recordings, robot: Robot) -> Iterator[tuple[str, Recordings]]:
    """A single reading with a slipped decimal point or the wrong sign, in the rows that fit worst."""
    left = _left(train, robot)
    for row in np.argsort(-np.linalg.norm(left, axis=1))[:2] if left is not None else ():
        for axis, factor in product(range(3), SLIPS):
            what = f"{POSITION[axis]} = {train.deflections[row, axis]:g} in row {train.lines[row]}"
            readings = divided(train.deflections, (row, axis), factor)
            yield slip_text(what, factor), replace(train, deflections=readings)


def _copies(recordings: Recordings, train: Recordings, robot: Robot) -> list[Implausibility]:
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
    return [Implausibility(what, "Were rows copied? Every row has to be measured; take them out.")]


def _left(train: Recordings, robot: Robot) -> FloatArray | None:
    """What registration leaves of every reading (m), shape (N, 3); None where nothing can be registered."""
    registered = _registered(train, robot)
    return None if registered is None else registration_residuals(registered, robot, train)


def _registered(train: Recordings, robot: Robot) -> MarkerPosition | None:
    """The registered instrument and its markers; None where nothing can be registered."""
    try:
        reading = reading_of(robot, train)
    except NotIdentifiableError:
        return None
    assert isinstance(reading, MarkerPosition)
    return reading


def _misfit(train: Recordings, robot: Robot) -> float | None:
    """RMS of what registration leaves in parts of the spread of the readings; None where nothing can be registered."""
    left, spread = _left(train, robot), _spread(train.deflections)
    return float(np.sqrt((left**2).sum(axis=1).mean())) / spread if left is not None and spread > 0.0 else None

"""Absolute readings of an arm read otherwise: which convention, coupling, frame or order would make them fit?

Each entry of `INTERPRETATIONS` proposes other readings of the same recordings, with what to write so that they are read
so. The instrument is registered, unless its pose is stated, and the markers are placed for the robot as drawn under
every one (`registration`). Where the recordings as they are do not fit, the one that fits best is named, if it fits and
by far better.
"""

from collections.abc import Callable, Iterator
from copy import copy
from dataclasses import replace
from itertools import product

import numpy as np
from scipy.spatial.transform import Rotation

from expdesign.arrays import BoolArray, FloatArray, TextArray
from expdesign.assurance.plausibility.evidence import Alternative
from expdesign.assurance.plausibility.finding import Implausibility
from expdesign.assurance.plausibility.mistakes.columns import DEGREE, signs, swaps
from expdesign.assurance.plausibility.mistakes.rows import SHIFTS, shifted, slipped
from expdesign.assurance.plausibility.registration import (
    FEWEST,
    POOR,
    TURNED,
    Misfit,
    left_of,
    misfit_of,
    placed,
    registered,
    some,
    spread_of,
)
from expdesign.chain.recordings.recordings import POSITION, STATION, Recordings, regrouped
from expdesign.mechanics.robots.orientation import arrays_in_space
from expdesign.mechanics.robots.robot import Robot

GAIN = 4.0
"""Factor by which an interpretation must reduce the misfit."""
CERTAIN = 0.3
"""Misfit of an interpretation beyond which no other kind is tried: 1.5 % of the spread and 1.7°."""


def explained(recordings: Recordings, robot: Robot, stated: Misfit) -> Implausibility | None:
    """The interpretation under which recordings fit whose misfit as they are is `stated`; None where under none."""
    whole = placed(recordings)
    best: tuple[Alternative, Misfit] | None = None
    for proposed in INTERPRETATIONS.values():
        if best is not None and best[1].size < min(CERTAIN, stated.size / GAIN):
            break
        for each in proposed(whole, robot):
            misfit = misfit_of(each.sample, _unplaced(robot) if each.placed else robot)
            if misfit is not None and (best is None or misfit.size < best[1].size):
                best = each, misfit
    if best is None or best[1].size >= min(1.0, stated.size / GAIN):
        return None
    what = f"the readings do not fit the robot: {stated.sentence} are left after registration, where "
    where = "column measured_rx_rad" if stated.share < stated.angle else ""
    return Implausibility(f"{what}{best[1].sentence} would be", best[0].sentence, where, otherwise=True)


def _unplaced(robot: Robot) -> Robot:
    """The robot without what its file says of the instrument."""
    other = copy(robot)
    other.instrument = None
    return other


def _stand(recordings: Recordings, robot: Robot) -> Iterator[Alternative]:
    """Another pose of the instrument than the stated one: O itself, the inverse, another convention, or any."""
    stated = robot.instrument
    reading = None if stated is None else registered(some(recordings), _unplaced(robot))
    if stated is None or reading is None:
        return
    found = reading.frames(reading.start)[0]
    place, turn = stated[:3], Rotation.from_euler("xyz", stated[3:])
    meant = [
        ("Are the positions in the base's frame?", np.zeros(3), Rotation.identity()),
        ("Is it inverse, the base in the instrument's axes?", -turn.inv().apply(place), turn.inv()),
        ("Is its place in mm?", 1e-3 * place, turn),
        *((text, place, made(stated[None, 3:], turn.as_matrix()[None])[0]) for text, made in CONVENTIONS[1:]),
    ]
    far = POOR * spread_of(recordings.deflections[:, :3])
    text = f"Is `instrument` of the robot file another pose? With {_pose(np.round(found, 4))} they fit."
    for question, where, turned in meant:
        off = (turned.inv() * Rotation.from_euler("xyz", found[3:])).magnitude()
        if np.linalg.norm(where - found[:3]) < far and off < TURNED:
            text += f" {question} Write `instrument: {_pose(np.append(where, turned.as_euler('xyz')))}`."
            break
    text += " Without the key the pose is estimated."
    yield Alternative(text, recordings, placed=True)


def _pose(values: FloatArray) -> str:
    return f"[{', '.join(f'{value + 0.0:.7g}' for value in np.round(values, 6))}]"


def _commanded(recordings: Recordings, matrix: FloatArray) -> Recordings:
    """The joint coordinates, which stand first among the commands, of every row times a matrix."""
    commands, count = recordings.configurations.copy(), len(matrix)
    commands[:, :count] = commands[:, :count] @ matrix.T
    return replace(recordings, configurations=commands)


def _units(recordings: Recordings, robot: Robot) -> Iterator[Alternative]:
    """All joints in degrees; single ones in another unit, or of the wrong sign."""
    names = robot.configuration[: len(robot.stiffness)]
    factors = np.array([DEGREE if name.endswith("_rad") else 1e-3 for name in names])
    text = "Are the joint coordinates in degrees? They have to be in rad."
    yield Alternative(text, _commanded(recordings, np.diag(np.where(factors == DEGREE, DEGREE, 1.0))))
    for index, (name, (text, turned)) in enumerate(zip(names, signs(names), strict=True)):
        yield Alternative(text, _commanded(recordings, turned))
        scaled = np.diag(np.where(np.arange(len(names)) == index, factors, 1.0))
        unit = "degrees" if name.endswith("_rad") else "mm"
        yield Alternative(f"Is {name} in {unit}?", _commanded(recordings, scaled))


def _frames(recordings: Recordings, robot: Robot) -> Iterator[Alternative]:
    """A left-handed frame of the instrument."""
    mirrored = recordings.deflections * np.where(recordings.axes == 0, -1.0, 1.0)
    text = "Is the instrument's frame left-handed, or one of px_m, py_m and pz_m of the wrong sign?"
    yield Alternative(text, replace(recordings, deflections=mirrored), placed=True)


def _swaps(recordings: Recordings, robot: Robot) -> Iterator[Alternative]:
    """Two columns of commands exchanged."""
    pairs = swaps(robot.configuration[: len(robot.stiffness)])
    return (Alternative(text, _commanded(recordings, matrix)) for text, matrix in pairs)


def _couplings(recordings: Recordings, robot: Robot) -> Iterator[Alternative]:
    """A joint whose motor is stated against the link before the last one: FANUC arms, parallelograms, wrists."""
    joints, names = robot.links.tree.coordinates, robot.configuration
    for index in range(1, len(joints)):
        if joints[index].unit != "rad" or joints[index - 1].unit != "rad":
            continue
        own, before = joints[index].joint, joints[index - 1].joint
        for sign, word in ((1.0, "+"), (-1.0, "−")):
            follows = f"couplings: {{{own}: {{follows: {{{own}_motor: 1, {before}: {sign:g}}}}}}}"
            text = (
                f"Is joint {index + 1} driven from the link before joint {index}, as the elbow of FANUC arms and of "
                f"parallelograms is, so that its angle is {names[index]} {word} {names[index - 1]}? Write `{follows}` "
                f"into the robot file, and a revolute joint `{own}_motor` off the chain into the URDF; {names[index]} "
                "is then the motor's."
            )
            matrix = np.eye(len(joints))
            matrix[index, index - 1] = sign
            yield Alternative(text, _commanded(recordings, matrix))


def _tips(recordings: Recordings, robot: Robot) -> Iterator[Alternative]:
    """Markers on another of the tips than the rows say; all of them where there are two; a station for each tip."""
    tips, numbers = robot.links.tree.tips, robot.tip_numbers(recordings.configurations)
    if len(tips) < 2:
        return

    def on(mine: BoolArray, number: FloatArray | int) -> Recordings:
        moved = recordings.configurations.copy()
        moved[:, -1] = np.where(mine, number, moved[:, -1])
        return replace(recordings, configurations=moved)

    for index, marker in enumerate(recordings.markers):
        mine = np.asarray(recordings.marker) == index
        for number in set(range(1, len(tips) + 1)) - set(numbers[mine].tolist()):
            yield Alternative(f"Does marker `{marker}` sit on `{tips[number - 1]}`?", on(mine, number))
    if len(tips) == 2:
        text = f"Are `{tips[0]}` and `{tips[1]}` swapped in the column tip?"
        yield Alternative(text, on(np.full(len(recordings), True), 3 - recordings.configurations[:, -1]))
    text = (
        "Was the instrument moved between the tips? Add a column `station` that names where it stood: one station for "
        f"each of {', '.join(f'`{tip}`' for tip in tips)}."
    )
    groups = np.array([tips[int(n) - 1] for n in numbers], dtype=object)
    yield Alternative(text, regrouped(recordings, STATION, groups))


def _stations(recordings: Recordings, robot: Robot) -> Iterator[Alternative]:
    """An instrument that was moved once: the change point of the rigid motion between robot and readings."""
    reading = None if any(recordings.stations) else registered(some(recordings), robot)
    if reading is None or reading.instrument is not None:
        return
    places, read, first = np.zeros((len(recordings.markers), 3)), recordings, 0
    for _ in range(3):  # places of markers are those of the split before
        first = _change_point(recordings, robot, places)
        if first == 0:
            return
        groups: TextArray = np.where(recordings.sequence >= recordings.sequence[first], "2", "1")
        read = regrouped(recordings, STATION, groups)
        again = registered(some(read), robot)
        if again is None:
            return
        known = dict(zip(again.sited, again.marked(again.start), strict=True))
        places = np.array([known.get(site, np.zeros(3)) for site in recordings.sites or recordings.markers])
    line = int(recordings.lines[first])
    text = f"Was the instrument moved before row {line}? Add a column `station`: 1 before that row, 2 from it on."
    yield Alternative(text, read)


def _change_point(recordings: Recordings, robot: Robot, places: FloatArray) -> int:
    """The row from which on another rigid motion maps readings onto markers best, for markers at `places` (m, 3).

    Sums of squares of both parts are those of Kabsch's registration, from sums over rows; 0 where there are too few.
    """
    q = recordings.configurations
    positions, rotations = arrays_in_space(robot.position(q), robot.jacobians(q).rotation)
    points = positions + np.einsum("nij,nj->ni", rotations, places[recordings.marker])
    read, count = recordings.deflections[:, :3], len(recordings)
    if count < 2 * FEWEST:
        return 0
    points, read = points - points.mean(axis=0), read - read.mean(axis=0)
    rows = np.concatenate(
        [np.ones((count, 1)), points, read, (points**2 + read**2).sum(axis=1, keepdims=True),
         np.einsum("ni,nj->nij", points, read).reshape(count, 9)], axis=1,
    )  # fmt: skip
    before = np.cumsum(rows, axis=0)[FEWEST - 1 : count - FEWEST]
    total = rows.sum(axis=0)
    cost = _left(before) + _left(total - before)
    return int(np.argmin(cost)) + FEWEST


def _left(sums: FloatArray) -> FloatArray:
    """Σ|R·p + t − y|² of the best rigid motion, from sums of 1, p, y, |p|² + |y|² and p·yᵀ (K, 17), shape (K,)."""
    count, points, read = sums[:, 0], sums[:, 1:4], sums[:, 4:7]
    product_of = sums[:, 8:].reshape(-1, 3, 3) - np.einsum("k,ki,kj->kij", 1.0 / count, points, read)
    squares = sums[:, 7] - ((points**2).sum(axis=1) + (read**2).sum(axis=1)) / count
    singular = np.linalg.svd(product_of, compute_uv=False)
    singular[:, 2] *= np.sign(np.linalg.det(product_of))
    left: FloatArray = squares - 2.0 * singular.sum(axis=1)
    return left


def _slips(recordings: Recordings, robot: Robot) -> Iterator[Alternative]:
    """A single reading with a slipped decimal point or the wrong sign, in the rows that fit worst."""
    tried = some(recordings)
    left = left_of(tried, robot)
    worst = () if left is None else tried.sequence[np.argsort(-np.linalg.norm(left, axis=1))[:2]]
    for number, axis in product(worst, range(3)):
        row = int(np.flatnonzero(recordings.sequence == number)[0])
        yield from slipped(recordings, row, axis, POSITION[axis])


def _shifts(recordings: Recordings, robot: Robot) -> Iterator[Alternative]:
    """Rows with the readings of the next ones, or of those before."""
    for shift, word in SHIFTS:
        text = f"Do the readings stand one row too {word}? Shift them against the other columns."
        yield Alternative(text, shifted(recordings, shift, "deflections", "aim", "angles"))


Turn = Callable[[FloatArray, FloatArray], Rotation]
"""Orientations from the three numbers as they were written (N, 3), and from the matrices that were made from them."""


def _quaternion(order: list[int]) -> Turn:
    return lambda angles, aim: Rotation.from_quat(Rotation.from_matrix(aim).as_quat()[:, order])


CONVENTIONS: tuple[tuple[str, Turn], ...] = (
    ("", lambda angles, aim: Rotation.from_matrix(aim)),
    ("Are the three numbers rotation vectors (axis times angle), as Universal Robots writes them? Convert them to "
     "rx, ry, rz of Rz·Ry·Rx: `Rotation.from_rotvec(v).as_euler(\"xyz\")` of SciPy.",
     lambda angles, aim: Rotation.from_rotvec(angles)),
    ("Are they A, B, C about z, y, x, as KUKA writes them, in the columns of rx, ry, rz? Write C, B, A: rx is the "
     "angle about x.", lambda angles, aim: Rotation.from_euler("ZYX", angles)),
    ("Are the angles about moving axes, first x, then y, then z (Rx·Ry·Rz)? Convert them: "
     "`Rotation.from_euler(\"XYZ\", a).as_euler(\"xyz\")` of SciPy makes Rz·Ry·Rx.",
     lambda angles, aim: Rotation.from_euler("XYZ", angles)),
    ("Are the angles about fixed axes, first z, then y, then x (Rx·Ry·Rz), the one about z in the first column? "
     "Convert them: `Rotation.from_euler(\"zyx\", a).as_euler(\"xyz\")` of SciPy.",
     lambda angles, aim: Rotation.from_euler("zyx", angles)),
    ("Are they O, A, T or Euler angles about z, y and z again? Convert them: "
     "`Rotation.from_euler(\"ZYZ\", a).as_euler(\"xyz\")` of SciPy.",
     lambda angles, aim: Rotation.from_euler("ZYZ", angles)),
    ("Are the angles in degrees? They have to be in rad.",
     lambda angles, aim: Rotation.from_euler("xyz", angles * DEGREE)),
    ("Was a quaternion written as x, y, z, w and read as w, x, y, z?", _quaternion([3, 0, 1, 2])),
    ("Was a quaternion written as w, x, y, z and read as x, y, z, w?", _quaternion([1, 2, 3, 0])),
)  # fmt: skip
"""How three numbers may be meant, with what to write; the first is as they are read."""


def _orientations(recordings: Recordings, robot: Robot) -> Iterator[Alternative]:
    """Conventions of orientations; those of the instrument in the target's axes; whole poses that are inverse."""
    aim, angles = recordings.aim, recordings.angles
    if aim is None or recordings.deflections.shape[1] < 6:
        return
    angles = Rotation.from_matrix(aim).as_euler("xyz") if angles is None else angles
    turned = [(text, turn(angles, aim).as_matrix()) for text, turn in CONVENTIONS]
    transposed = "Are they the instrument's orientations in the target's axes? Transpose them.", aim.swapaxes(1, 2)
    for text, other in (*turned[1:], transposed):
        yield Alternative(text, replace(recordings, aim=other))
    inverse = (
        "Are the poses inverse, the instrument's in the frame of the target, as of a camera on the tip (eye in "
        "hand)? Invert the poses: R' = Rᵀ, p' = −Rᵀ·p."
    )
    for text, other in turned:
        read = recordings.deflections.copy()
        read[:, :3] = -np.einsum("nji,nj->ni", other, read[:, :3])
        complete = np.flatnonzero(np.isfinite(read).all(axis=1))
        whole = replace(recordings, aim=other.swapaxes(1, 2), deflections=read).rows(complete)
        yield Alternative(f"{inverse} {text}".strip(), whole)


INTERPRETATIONS: dict[str, Callable[[Recordings, Robot], Iterator[Alternative]]] = {
    "another pose of the instrument than is stated": _stand,
    "joints in other units or of the wrong sign": _units,
    "a left-handed frame of the instrument": _frames,
    "orientations in other conventions, inverse poses": _orientations,
    "coupled joints": _couplings,
    "markers on other tips, a station for each tip": _tips,
    "an instrument that was moved once": _stations,
    "readings one row too early or late": _shifts,
    "a slipped decimal point or sign": _slips,
    "two swapped columns of commands": _swaps,
}
"""Kinds of readings of the same recordings, likelier ones first."""


def unexplained(left: str, robot: Robot) -> Implausibility:
    """What is said of readings (`left`: what a fit leaves of them) that fit under no interpretation that was tried."""
    likely = "Compare the robot file and the columns with what was measured."
    if robot.jointed:
        tried = [name for name, kind in INTERPRETATIONS.items() if kind is not _stand or robot.instrument is not None]
        likely = f"Tried without success: {'; '.join(tried)}. {likely}"
    return Implausibility(f"the readings do not fit the robot: {left} are left after the fit", likely, otherwise=True)

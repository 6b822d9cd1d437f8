"""Positions of markers: impossible payloads and units, copied rows, and what another interpretation explains."""

import numpy as np

from expdesign.assurance.plausibility.evidence import REPEATABILITY
from expdesign.assurance.plausibility.finding import Implausibility, extent, outside
from expdesign.assurance.plausibility.interpretations import explained
from expdesign.assurance.plausibility.mistakes.numbers import copies
from expdesign.assurance.plausibility.registration import FEWEST, left_of, misfit_of, placed, some, spread_of
from expdesign.assurance.plausibility.targets import deflection_findings
from expdesign.chain.recordings.recordings import POSITION, Recordings, complete_positions
from expdesign.mechanics.robots.kinematic_tree import PAYLOAD_COLUMNS, KinematicTree
from expdesign.mechanics.robots.robot import Robot

HEAVY = 0.02
"""Share of the moved mass from which a joint that has no column is worth a word."""
LARGER = 3.0
"""Spread of the readings over that of the tip's nominal places, beyond which they cannot be in one unit."""
ARM = 0.2
"""m; how far from the tip a marker may be taken to sit."""
FARTHEST, SLACK = 2.0, 2.0
"""Times the span of the robot, and m: no payload is farther away than both together."""


def positions_findings(recordings: Recordings, robot: Robot) -> list[Implausibility]:
    """What speaks against units, signs and frames of positions of markers, beside commands of a serial robot."""
    if not robot.jointed or 0 not in recordings.axes:
        return []
    return [*_frames(recordings, robot), *_loads(recordings, robot)]


def _frames(recordings: Recordings, robot: Robot) -> list[Implausibility]:
    """What speaks against units and frames of positions and payloads, whatever the loads do."""
    positions = complete_positions(recordings)
    train = some(positions)
    payloads = _payloads(recordings, robot)
    if payloads or len(train) < FEWEST:
        return payloads
    units = _units(train, robot)
    if units:
        return units
    standing = _standing(robot.links.tree)
    stated = misfit_of(placed(recordings), robot)
    if stated is None:
        return standing
    if stated.size < 1.0:
        left = left_of(train, robot)
        noise = None if left is None else np.sqrt((left**2).mean(axis=0)) / REPEATABILITY**2
        return [*standing, *([] if noise is None else copies(positions, noise))]
    found = explained(recordings, robot, stated)
    return [] if found is None else [found]


def _payloads(recordings: Recordings, robot: Robot) -> list[Implausibility]:
    """Payloads of the tip and of other links whose centres of mass are farther away than the robot could hold them."""
    tree, size = robot.links.tree, extent(robot) or 0.0
    centres = {"com_x_m": recordings.payload[:, 1:]} if recordings.payload is not None else {}
    for carrier in tree.carriers:
        first = robot.configuration.index(f"{carrier}_{PAYLOAD_COLUMNS[1]}")
        centres[robot.configuration[first]] = recordings.configurations[:, first : first + 3]
    found = list[Implausibility]()
    for column, centre in centres.items():
        farthest = float(np.linalg.norm(centre, axis=1).max(initial=0.0))
        what = f"a payload's centre of mass lies {{:.3g}} m away, but the robot spans {size:.3g} m"
        likely = "Write centres of mass in m: they look like mm."
        found += outside(farthest, 0.0, FARTHEST * size + SLACK, what, likely, f"column {column}", 1.0)
    return found


def _loads(recordings: Recordings, robot: Robot) -> list[Implausibility]:
    """Loads that would bend the arm of the robot file, without its own weight, by more than one that serves bends."""
    forward = robot.jacobians(recordings.configurations).forward
    forces = np.einsum("nij,ni->nj", forward, recordings.absolute) * robot.compliance
    deflections = np.einsum("nij,nj->ni", forward, forces)
    row = int(np.argmax(np.linalg.norm(deflections, axis=1)))
    return deflection_findings(robot, deflections[[row]], f"row {recordings.lines[row]}")


def _units(train: Recordings, robot: Robot) -> list[Implausibility]:
    """Readings that spread over many times what the tip does are in another unit, whatever the frames."""
    rotations = robot.jacobians(train.configurations).rotation.reshape(len(train), -1)
    own, tip, turn = (spread_of(x) for x in (train.deflections, robot.position(train.configurations), rotations))
    nominal = tip + ARM * turn
    ratio = own / max(nominal, 1e-12)
    what = f"the positions spread over {own:.3g} m, and the tip of the robot over {tip:.3g} m"
    near = ("mm", "µm")[int(ratio > 1e3 * LARGER)]
    where, most = f"column {POSITION[0]}", 1e6 * LARGER
    likely = f"Write them in m: they look like {near}."
    return outside(ratio, 0.0, 1e3 / LARGER, what, likely, where, 1.0) if ratio < most else []


def _standing(tree: KinematicTree) -> list[Implausibility]:
    """Joints off the chain whose place nobody says, although they move weight that the chain carries."""
    joints = tree.urdf.joints.values()
    mass = {
        joint.name: tree.urdf.links[joint.child].mass
        + sum(tree.urdf.links[each.child].mass for each in joints if _hangs_on(each.parent, joint.child, tree))
        for joint in joints
        if joint.moves and tree.motion(joint) is None and tree.carries(joint.parent)
    }
    heavy = [name for name, own in mass.items() if own > HEAVY * float(tree.masses().sum())]
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

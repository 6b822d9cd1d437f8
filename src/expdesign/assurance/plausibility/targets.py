"""Poses, loads and deflections against the robot that has them.

Targets of a compensation: the same, and against what the model was calibrated with.
"""

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.assurance.plausibility.finding import Implausibility, extent, largest
from expdesign.chain.models.estimable import FORCE, MASS, MOMENT, Calibrated, quantities
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.mechanics.robots.robot import Robot

_UNITS = {
    MASS: ("mass", "kg", "grams"),
    FORCE: ("force", "N", "mN, or a mass in grams"),
    MOMENT: ("moment", "N·m", "N·mm, or a centre of mass in millimetres"),
}


FAR = 8.0
"""Times the robot's size at which no centre of mass and no pose is."""
SOFT, SOFT_ARM, BROKEN = 0.003, 0.05, 0.5
"""Deflections in parts of the robot's size that are suspicious for robots on legs and for arms, and impossible."""
TURNED, TURNED_ARM, OVERTURNED = 0.05, 0.1, 1.0
"""rad of deflection that are suspicious for robots on legs and for arms, and impossible."""
PLATFORM_ANGLE = 1.8
"""rad that no platform on legs turns by."""
HEAVY, OTHER_UNIT = 3.0, 100.0
"""Times the largest calibrated load that are suspicious, and that are another unit."""
LEVER = 0.05
"""Part of the robot's size: moments below the largest force times this lever are not compared."""


def target_findings(
    points: LoadedPoints, robot: Robot, calibrated: Calibrated | None, known: str = "that was calibrated"
) -> list[Implausibility]:
    """What speaks against poses and loads, before anything is computed of them."""
    found = [*pose_findings(robot, points.configurations, "", lines=points.lines), *_centres(points, robot)]
    return found if calibrated is None else [*found, *load_findings(points, robot, calibrated, known)]


def correction_findings(
    robot: Robot, points: LoadedPoints, translation: FloatArray, rotation: FloatArray
) -> list[Implausibility]:
    """What speaks against corrections (m, rad), shape (N,), of a model that does not say how it was calibrated."""
    for values, axis in ((translation, 0), (rotation, robot.coordinates.translations)):
        row = int(np.argmax(values))
        deflection = np.zeros((1, max(robot.coordinates.n, axis + 1)))
        deflection[0, axis] = values[row]
        found = deflection_finding(robot, deflection, f"row {points.lines[row]}")
        if found is not None:
            return [found]
    return []


def _centres(points: LoadedPoints, robot: Robot) -> list[Implausibility]:
    if points.payload is None or points.payload.shape[1] < 2:
        return []
    row = int(np.argmax(np.abs(points.payload[:, 1:]).max(axis=1)))
    return centre_findings(robot, points.payload[row, 1:], f"row {points.lines[row]}")


def load_findings(points: LoadedPoints, robot: Robot, calibrated: Calibrated, known: str) -> list[Implausibility]:
    """The row whose load exceeds what is `known` by most; a mass stands for its force, and both for its moment."""
    size = extent(robot)
    for name, values in sorted(quantities(points, robot).items(), key=lambda item: item[0] != MASS):
        if name not in _UNITS or name not in calibrated.ranges:
            continue
        largest = calibrated.ranges[name][1]
        if name == MOMENT and size is not None:
            largest = max(largest, LEVER * size * calibrated.ranges[FORCE][1])
        row = int(np.argmax(values))
        if largest <= 0.0 or values[row] <= HEAVY * largest:
            continue
        noun, unit, other = _UNITS[name]
        ratio = values[row] / largest
        what = f"the {noun} is {values[row]:.6g} {unit}, {ratio:.0f} times the largest {known} ({largest:.4g})"
        return [Implausibility(what, f"Is it in {other}? It has to be in {unit}.", f"row {points.lines[row]}",
                        bool(ratio > OTHER_UNIT))]  # fmt: skip
    return []


def pose_findings(
    robot: Robot, poses: FloatArray, where: str, names: tuple[str, ...] = (), lines: IntArray | None = None
) -> list[Implausibility]:
    """What speaks against the units of poses (s, n_q), or (s, 6) of the tip or the instrument in columns `names`.

    Of poses on `lines` (s,) of a file, the row of the largest is named.
    """
    size = extent(robot)
    found = []
    turns = 2.0 * np.pi
    if robot.configuration == robot.coordinates.pose:  # what stands beside a platform may be turned at will
        turns = np.pi if names else PLATFORM_ANGLE
    for axis, name in enumerate(names or robot.configuration):
        most = largest(poses[:, axis])
        if lines is not None:
            where = f"row {lines[int(np.argmax(np.abs(poses[:, axis])))]}"
        if name.endswith("_rad"):
            if most > turns * 1.0001:
                what = f"{name} would be {most:.3g} rad, i.e. {np.degrees(most):.3g}°"
                found.append(Implausibility(what, "Is it in degrees? It has to be in rad.", where))
        elif size is not None and most > FAR * size:
            what = f"{name} would be {most:.3g} m, and the robot is {size:.3g} m large"
            found.append(Implausibility(what, "Is it in millimetres? It has to be in m.", where))
    return found


def centre_findings(robot: Robot, centres: FloatArray, where: str) -> list[Implausibility]:
    """What speaks against the unit of centres of mass (m), of any shape."""
    size, far = extent(robot), largest(centres)
    if size is None or far <= FAR * size:
        return []
    what = f"a centre of mass would be {far:.3g} m away from a robot of {size:.3g} m"
    return [Implausibility(what, "Is it in millimetres? It has to be in m.", where, far > 10.0 * FAR * size)]


def deflection_finding(robot: Robot, values: FloatArray, where: str) -> Implausibility | None:
    """What speaks against deflections (s, n) under loads (m, rad)."""
    split, size = robot.coordinates.translations, extent(robot)
    soft = SOFT if robot.configuration == robot.coordinates.pose else SOFT_ARM
    moved, turned = largest(values[:, :split]), largest(values[:, split:])
    likely = (
        "Is a mass in grams, a centre of mass in millimetres, a force in mN, or `actuator_stiffness` in N/µm or N/mm?"
    )
    if size is not None and moved > soft * size:
        what = f"the load would deflect the robot of {size:.3g} m by {moved:.3g} m"
        return Implausibility(what, likely, where, moved > BROKEN * size)
    if turned > (TURNED_ARM if robot.jointed else TURNED):
        turns = f"turn the {'tip' if robot.jointed else 'platform'} by {turned:.3g} rad ({np.degrees(turned):.3g}°)"
        what = f"the load would {turns}"
        return Implausibility(what, likely, where, turned > OVERTURNED)
    return None

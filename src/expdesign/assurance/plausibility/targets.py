"""Poses, loads and deflections against the robot that has them.

Targets of a compensation: the same, and against what the model was calibrated with.
"""

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.assurance.plausibility.finding import Implausibility, extent, largest, outside
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
    shift, turn = int(np.argmax(translation)), int(np.argmax(rotation))
    return [
        *_moved(robot, float(translation[shift]), f"row {points.lines[shift]}"),
        *_turned(robot, float(rotation[turn]), f"row {points.lines[turn]}"),
    ][:1]


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
        most, (noun, unit, other) = calibrated.ranges[name][1], _UNITS[name]
        if name == MOMENT and size is not None:
            most = max(most, LEVER * size * calibrated.ranges[FORCE][1])
        row = int(np.argmax(values))
        ratio = values[row] / most if most > 0.0 else 0.0
        what = f"the {noun} is {values[row]:.6g} {unit}, {{:.0f}} times the largest {known} ({most:.4g})"
        likely, where = f"Is it in {other}? It has to be in {unit}.", f"row {points.lines[row]}"
        if found := outside(ratio, 0.0, HEAVY, what, likely, where, OTHER_UNIT / HEAVY):
            return found
    return []


def pose_findings(
    robot: Robot, poses: FloatArray, where: str, names: tuple[str, ...] = (), lines: IntArray | None = None
) -> list[Implausibility]:
    """What speaks against the units of poses (s, n_q), or (s, 6) of the tip or the instrument in columns `names`.

    Of poses on `lines` (s,) of a file, the row of the largest is named.
    """
    size = extent(robot)
    found = list[Implausibility]()
    turns = 2.0 * np.pi
    if robot.configuration == robot.coordinates.pose:  # what stands beside a platform may be turned at will
        turns = np.pi if names else PLATFORM_ANGLE
    for axis, name in enumerate(names or robot.configuration):
        most = largest(poses[:, axis])
        if lines is not None:
            where = f"row {lines[int(np.argmax(np.abs(poses[:, axis])))]}"
        if name.endswith("_rad"):
            what = f"{name} would be {{:.3g}} rad, i.e. {np.degrees(most):.3g}°"
            found += outside(most, 0.0, turns * 1.0001, what, "Is it in degrees? It has to be in rad.", where)
        elif size is not None:
            what = f"{name} would be {{:.3g}} m, and the robot is {size:.3g} m large"
            found += outside(most, 0.0, FAR * size, what, "Is it in millimetres? It has to be in m.", where)
    return found


def centre_findings(robot: Robot, centres: FloatArray, where: str) -> list[Implausibility]:
    """What speaks against the unit of centres of mass (m), of any shape."""
    size = extent(robot) or np.nan
    what = f"a centre of mass would be {{:.3g}} m away from a robot of {size:.3g} m"
    return outside(largest(centres), 0.0, FAR * size, what, "Is it in millimetres? It has to be in m.", where, 10.0)


def deflection_findings(robot: Robot, values: FloatArray, where: str) -> list[Implausibility]:
    """What speaks against deflections (s, n) under loads (m, rad)."""
    split = robot.coordinates.translations
    found = _moved(robot, largest(values[:, :split]), where)
    return found or _turned(robot, largest(values[:, split:]), where)


_LIKELY = "Is a mass in grams, a centre of mass in millimetres, a force in mN, or `actuator_stiffness` in N/µm or N/mm?"


def _moved(robot: Robot, moved: float, where: str) -> list[Implausibility]:
    """Of how far (m) the load moves the robot."""
    size, soft = extent(robot) or np.nan, SOFT if robot.configuration == robot.coordinates.pose else SOFT_ARM
    what = f"the load would deflect the robot of {size:.3g} m by {{:.3g}} m"
    return outside(moved, 0.0, soft * size, what, _LIKELY, where, BROKEN / soft)


def _turned(robot: Robot, turned: float, where: str) -> list[Implausibility]:
    """Of how far (rad) the load turns it."""
    part, most = ("tip", TURNED_ARM) if robot.jointed else ("platform", TURNED)
    what = f"the load would turn the {part} by {{:.3g}} rad ({np.degrees(turned):.3g}°)"
    return outside(turned, 0.0, most, what, _LIKELY, where, OVERTURNED / most)

"""Robot files: geometry in millimetres, stiffness in N/µm, gravity in mm/s², limits that exclude the robot itself."""

import numpy as np

from expdesign.assurance.plausibility.finding import Implausibility, extent
from expdesign.assurance.plausibility.options import ROBOT
from expdesign.mechanics.robots.drawing import Drawing
from expdesign.mechanics.robots.robot import Robot


def robot_findings(robot: Robot) -> list[Implausibility]:
    """What speaks against a robot file."""
    return [*_size(robot), *_proportions(robot), *_limits(robot), *_stiffness(robot), *_gravity(robot)]


def _size(robot: Robot) -> list[Implausibility]:
    size = extent(robot)
    if size is None or ROBOT.sizes[0] <= size <= ROBOT.sizes[1]:
        return []
    unit = "millimetres" if size > ROBOT.sizes[1] else "kilometres, or metres divided by 1000 once too often"
    return [Implausibility(f"the robot would be {size:.3g} m large", f"Is its geometry in {unit}? It has to be in m.")]


def _proportions(robot: Robot) -> list[Implausibility]:
    drawing = robot.drawing(robot.reference_configuration())
    if drawing is None:
        return []
    sizes = _part_sizes(drawing)
    if len(sizes) < 2:
        return []
    big, small = max(sizes, key=lambda name: sizes[name]), min(sizes, key=lambda name: sizes[name])
    if sizes[big] <= ROBOT.disproportion * sizes[small]:
        return []
    what = f"the {big} would be {sizes[big]:.3g} m and the {small} {sizes[small]:.3g} m large"
    return [Implausibility(what, f"Is one of them in millimetres (with home, which is the length of the {big})?")]


def _part_sizes(drawing: Drawing) -> dict[str, float]:
    """Sizes (m) of the base, the platform and the longest actuator, as far as they are drawn."""
    sizes: dict[str, float] = {}
    for part in drawing.parts:
        for path in part.paths:
            points = drawing.points[..., list(path), :].reshape(-1, drawing.points.shape[-1])
            size = float(np.linalg.norm(np.ptp(points, axis=0)))
            sizes[part.role] = max(sizes.get(part.role, 0.0), size)
    return {name: size for name, size in sizes.items() if size > 0.0}


def _limits(robot: Robot) -> list[Implausibility]:
    reference = robot.reference_configuration()
    excess, size = float(robot.limit_excess(reference)), extent(robot)
    if size is None or not excess > ROBOT.excluded * min(size, ROBOT.sizes[1]):
        return []
    what = f"the limits exclude the robot's own reference pose by far: {robot.limit_message(reference)}"
    return [Implausibility(what, "Is the geometry, or are the limits, in millimetres? Both have to be in m.", "", True)]


def _stiffness(robot: Robot) -> list[Implausibility]:
    found = []
    rotary = np.array([robot.configuration != robot.coordinates.pose and name.endswith("_rad")
                       for name in robot.configuration[: len(robot.stiffness)]])  # fmt: skip
    for kind, (low, high), unit, other in (
        (False, ROBOT.linear, "N/m", "N/µm or N/mm"),
        (True, ROBOT.rotary, "N·m/rad", "N·m/mrad or per degree"),
    ):
        if not np.isfinite(robot.stiffness).all():
            continue  # none is stated
        values = robot.stiffness[rotary[: len(robot.stiffness)] == kind] if robot.actuated else robot.stiffness
        if not values.size:
            continue
        for value in (float(values.min()), float(values.max())):
            if not low <= value <= high:
                what = f"no machine has an actuator stiffness of {value:.3g} {unit}"
                impossible = not low / ROBOT.impossible <= value <= high * ROBOT.impossible
                found.append(Implausibility(what, f"Is it in {other}?", "actuator_stiffness", impossible))
                break
        if values.max() > ROBOT.unequal * values.min():
            what = f"the stiffest actuator would be {values.max() / values.min():.3g} times as stiff as the softest"
            found.append(Implausibility(what, "Is one of them in another unit?", "actuator_stiffness"))
    return found


def _gravity(robot: Robot) -> list[Implausibility]:
    size = float(np.linalg.norm(robot.gravity))
    if size == 0.0 or ROBOT.gravity[0] <= size <= ROBOT.gravity[1]:
        return []
    likely = "Is it in mm/s²?" if size > ROBOT.gravity[1] else "Is it in parts of g? It has to be in m/s²."
    return [Implausibility(f"gravity would be {size:.3g} m/s²", likely, "gravity_m_s2")]

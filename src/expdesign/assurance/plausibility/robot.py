"""Robot files: geometry in millimetres, stiffness in N/µm, masses in g, gravity in mm/s², limits without the robot."""

from itertools import combinations

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.assurance.plausibility.finding import Implausibility, extent, outside
from expdesign.assurance.plausibility.targets import pose_findings
from expdesign.coordinates import SPATIAL
from expdesign.mechanics.robots.drawing import Drawing
from expdesign.mechanics.robots.robot import STANDARD_GRAVITY, Robot

SIZES = (0.002, 40.0)
"""m; that machines have."""
LINEAR, ROTARY = (1e4, 1e11), (1.0, 1e10)
"""N/m and N·m/rad, of actuators."""
IMPOSSIBLE = 100.0
"""Factor beyond these ranges from which a number is no machine's, and not merely unusual."""
UNEQUAL = 3e3
"""Ratio of the stiffest to the softest actuator of one kind beyond which one is in another unit."""
GRAVITY = (0.5, 30.0)
"""m/s²; from the Moon's to that of any centrifuge that a robot stands in."""
_EARTH = (9.7, 9.9)
"""m/s²."""
_EARTH_IN = ((1000.0, "in mm/s²"), (100.0, "in cm/s²"), (1.0 / 0.3048, "in ft/s²"), (10.0, "10 times too large"),
             (0.1, "10 times too small"), (1.0 / 9.80665, "in parts of g, or a direction"))  # fmt: skip
"""Earth's gravity otherwise, as so many times its size in m/s²: that of no body where robots stand."""
_UPRIGHT = 0.9
"""Cosine of the angle from the last axis of O within which gravity points up."""
DISPROPORTION = 60.0
"""Ratio of the sizes of two parts of one robot beyond which one is in another unit."""
EXCLUDED = 0.6
"""Part of the robot's size by which limits may not exclude its own reference pose."""
SAG, POSES = 0.1, 100
"""rad or m that no joint of an arm yields by under its own weight; poses at which that is found."""


def robot_findings(robot: Robot) -> list[Implausibility]:
    """What speaks against a robot file."""
    drawing = robot.drawing(robot.reference_configuration())
    drawn = [] if drawing is None else [*_sizes(robot, drawing), *_limits(robot)]
    found = [*drawn, *_stiffness(robot), *gravity_findings(robot.gravity, "gravity_m_s2")]
    if robot.instrument is not None:
        found += pose_findings(robot, robot.instrument[None], "instrument", SPATIAL.pose)
    return [*found, *([] if drawing is None else _legs(drawing)), *_sag(robot)]


COINCIDENT, STRAIGHT = 0.6, 0.02
"""Degrees that joints of a pair are apart at least, as half angles; part of a leg's length that legs pass at."""


def _legs(drawing: Drawing) -> list[Implausibility]:
    """Joints of pairs that coincide nearly, as by a half angle in rad, and legs that run through each other."""
    legs = {name: ends for name, ends in drawing.components.items() if name.startswith("leg ")}
    if len(legs) < 3 or drawing.points.shape[-1] != 3:
        return []
    ends = np.array([drawing.points[[path[0], path[-1]]] for path in legs.values()])
    found = []
    for side, name in enumerate(("base", "platform")):
        points = ends[:, side]
        radius = float(np.linalg.norm(points - points.mean(axis=0), axis=1).mean())
        apart = np.linalg.norm(points[:, None] - points[None], axis=-1)[np.triu_indices(len(points), 1)]
        half = float(np.degrees(np.arcsin(min(apart.min() / (2.0 * radius), 1.0)))) if radius > 0.0 else 0.0
        if 1e-6 < half < COINCIDENT:
            what = f"joints of the {name} are only {1e3 * apart.min():.2g} mm apart, a half angle of {half:.3g}°"
            likely = f"Is `half_angle_deg` in rad? {half:.3g} rad are {np.degrees(half):.3g}°; write half of the angle."
            found.append(Implausibility(what, likely, name))
    named = combinations(zip(legs, ends, strict=True), 2)
    if pairs := ", ".join(f"{one} and {other}" for (one, first), (other, second) in named if _cross(first, second)):
        what = f"{pairs} cross at the reference pose"
        likely = "Are joints of the platform in another order than those of the base? A row is a leg in both."
        found.append(Implausibility(what, likely, "platform"))
    return found


def _cross(one: FloatArray, other: FloatArray) -> bool:
    """Whether two segments (2, 3) pass, away from their ends, by less than a part of their length."""
    first, second, between = one[1] - one[0], other[1] - other[0], other[0] - one[0]
    matrix = np.column_stack([first, -second])
    places, _, rank, _ = np.linalg.lstsq(matrix, between, rcond=1e-9)
    apart = float(np.linalg.norm(matrix @ places - between))
    length = min(float(np.linalg.norm(first)), float(np.linalg.norm(second)))
    return bool(rank == 2 and (places > 0.02).all() and (places < 0.98).all() and apart < STRAIGHT * length)


def _sizes(robot: Robot, drawing: Drawing) -> list[Implausibility]:
    """Of the robot, and of its parts beside each other."""
    size = extent(robot) or np.nan
    unit = "millimetres" if size > SIZES[1] else "kilometres, or metres divided by 1000 once too often"
    likely = f"Is its geometry in {unit}? It has to be in m."
    found, parts = outside(size, *SIZES, "the robot would be {:.3g} m large", likely), _part_sizes(drawing)
    if len(parts) < 2:
        return found
    big, small = max(parts, key=lambda name: parts[name]), min(parts, key=lambda name: parts[name])
    what = f"the {big} would be {parts[big]:.3g} m and the {small} {parts[small]:.3g} m large"
    likely = f"Is one of them in millimetres (with home, which is the length of the {big})?"
    return [*found, *outside(parts[big] / parts[small], 0.0, DISPROPORTION, what, likely)]


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
    reference, size = robot.reference_configuration(), extent(robot)
    if size is None:
        return []
    what = f"the limits exclude the robot's own reference pose by far: {robot.limit_message(reference)}"
    likely = "Is the geometry, or are the limits, in millimetres? Both have to be in m."
    return outside(float(robot.limit_excess(reference)), -np.inf, EXCLUDED * min(size, SIZES[1]), what, likely, "", 1.0)


def _stiffness(robot: Robot) -> list[Implausibility]:
    """Of actuators of one kind, where it is stated."""
    found, stated = list[Implausibility](), bool(np.isfinite(robot.stiffness).all())
    joints = robot.actuated and robot.configuration != robot.coordinates.pose
    rotary = np.array([joints and unit == "rad" for unit in robot.units])
    for kind, limits, unit, other in (
        (False, LINEAR, "N/m", "N/µm or N/mm"),
        (True, ROTARY, "N·m/rad", "N·m/mrad or per degree"),
    ):
        values = robot.stiffness[rotary == kind] if stated else np.zeros(0)
        if not values.size:
            continue
        low, high = float(values.min()), float(values.max())
        value = low if low < limits[0] else high
        what, where = f"no machine has an actuator stiffness of {{:.3g}} {unit}", "actuator_stiffness"
        found += outside(value, *limits, what, f"Is it in {other}?", where, IMPOSSIBLE)
        what = "the stiffest actuator would be {:.3g} times as stiff as the softest"
        found += outside(high / low, 0.0, UNEQUAL, what, "Is one of them in another unit?", where)
    return found


def _sag(robot: Robot) -> list[Implausibility]:
    """An arm whose own weight, with gravity of 1 g along any axis, bends a joint by what no joint yields."""
    if not robot.jointed:
        return []
    count, generator = len(robot.stiffness), np.random.default_rng(0)
    poses = np.tile(robot.reference_configuration(), (POSES, 1))
    low, high = (np.clip(limit, -np.pi, np.pi) for limit in robot.actuator_limits)
    poses[:, :count] = generator.uniform(low, high, (POSES, count))
    weight = robot.own_weight(poses[:, None], STANDARD_GRAVITY * np.eye(len(robot.gravity)))
    torque = np.linalg.norm(weight, axis=1).max(axis=0)
    sag = torque * robot.compliance
    worst = int(np.argmax(sag))
    unit, moment = ("rad", "N·m") if robot.units[worst] == "rad" else ("m", "N")
    load = f"the arm's own weight of up to {torque[worst]:.3g} {moment}"
    what = f"{robot.actuators[worst]} would yield by {{:.3g}} {unit} under {load}"
    likely = "Is its `actuator_stiffness` per arcmin or in kN·m/rad, or a mass of the URDF in grams?"
    return outside(float(sag[worst]), 0.0, SAG, what, likely, "actuator_stiffness")


def gravity_findings(gravity: FloatArray, where: str) -> list[Implausibility]:
    """What speaks against gravity (m/s², shape (d,)): another unit, a direction alone, or another sign."""
    size = float(np.linalg.norm(gravity))
    other = next((text for factor, text in _EARTH_IN if _EARTH[0] <= size / factor <= _EARTH[1]), "")
    low, high = (np.inf, 0.0) if other else GRAVITY
    other = other or ("in another unit" if size > GRAVITY[1] else "in parts of g, or a direction")
    likely = f"Is it {other}? It has to be in m/s²; Earth's is 9.81."
    found = outside(size, low, high, "gravity would be {:.3g} m/s²", likely, where) if size > 0.0 else []
    what = f"gravity points up, along +{'xyz'[len(gravity) - 1]} of the base"
    likely = "Does it have the wrong sign? It is right where the robot hangs upside down."
    return [*found, *outside(float(gravity[-1]), -np.inf, _UPRIGHT * size, what, likely, where)]

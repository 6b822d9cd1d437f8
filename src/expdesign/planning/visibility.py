"""Whether the instrument sees its reflectors (`experiment.constraints.visibility`).

A reflector returns light that comes from within a cone about its own direction (some 30° to either side
for a corner cube in a sphere). The straight line from the instrument's station to it has to pass the robot: links are
capsules around the lines of its drawing, as for collisions. The link that carries the tip does not count, since
reflectors sit on it: their cone says from where that link hides them.
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.mechanics.robots.drawing import Drawing
from expdesign.mechanics.robots.robot import Robot
from expdesign.planning.schema import VisibilitySection
from expdesign.planning.tips import tip_number, tips_of

_AT_TIP = 1e-9
"""m between the end of a line and the tip, below which the line is the link that carries it."""


@dataclass(frozen=True)
class Reflector:
    """Where a reflector sits and where it looks.

    Attributes:
        place: in the tip's frame (m), shape (3,).
        direction: unit vector in the tip's frame, shape (3,).
        acceptance: largest angle between it and the line to the station (rad).
        tip: number of the tip it sits on; 0 where the robot has one tip, or one sits on each.
    """

    place: FloatArray
    direction: FloatArray
    acceptance: float
    tip: int = 0


@dataclass(frozen=True)
class Visibility:
    """What has to be seen.

    Attributes:
        station: of the instrument in O (m), shape (3,).
        reflectors: at least one.
        radius: of the links (m).
        least: how many reflectors of the tip that is measured have to be seen; all of them if None.
    """

    station: FloatArray
    reflectors: tuple[Reflector, ...]
    radius: float
    least: int | None = None

    def excess(self, robot: Robot, configurations: FloatArray) -> FloatArray:
        """How far configurations (..., n_q) are from being seen, ≤ 0 where they are: angle beyond the cone (rad), and
        depth of the line of sight in a link (m), shape (..., 2).
        """
        flat = configurations.reshape(-1, configurations.shape[-1])
        origin, rotation = robot.position(flat), robot.jacobians(flat).rotation
        tips, drawing = robot.tip_numbers(flat), robot.drawing(flat)
        parts = [self._of(each, origin, rotation, tips, drawing) for each in self.reflectors]
        found = np.stack(parts, axis=1)
        # Those that are seen best have to be seen; a reflector of another tip is never among them.
        worst = found.max(axis=-1)
        order = np.argsort(worst, axis=1, kind="stable")
        ranked = np.take_along_axis(found, order[..., None], axis=1)
        mine = np.isfinite(worst).sum(axis=1)
        needed = np.maximum(mine if self.least is None else np.minimum(self.least, mine), 1)
        asked = np.arange(len(self.reflectors)) < needed[:, None]
        result: FloatArray = np.where(asked[..., None], ranked, -np.inf).max(axis=1)
        return result.reshape(*configurations.shape[:-1], 2)

    def _of(
        self, reflector: Reflector, origin: FloatArray, rotation: FloatArray, tips: IntArray, drawing: Drawing | None
    ) -> FloatArray:
        """Excess of one reflector (N, 2), infinite in rows of another tip."""
        place = origin + rotation @ reflector.place
        line = self.station - place
        cosine = ((rotation @ reflector.direction) * line).sum(axis=-1) / np.linalg.norm(line, axis=-1)
        cone = np.arccos(np.clip(cosine, -1.0, 1.0)) - reflector.acceptance
        depth = np.full(len(cone), -np.inf)
        links = (
            []
            if drawing is None
            else [(drawing.points[:, a], drawing.points[:, b]) for a, b in drawing.segments("base", "actuator")]
        )
        for start, end in links:
            carries = np.minimum(np.linalg.norm(start - origin, axis=1), np.linalg.norm(end - origin, axis=1)) < _AT_TIP
            near = self.radius - distance_between(np.broadcast_to(self.station, place.shape), place, start, end)
            depth = np.maximum(depth, np.where(carries, -np.inf, near))
        other = (tips != reflector.tip) if reflector.tip else np.zeros(len(cone), dtype=bool)
        return np.where(other[:, None], np.inf, np.stack([cone, depth], axis=1))

    def sentence(self, excess: FloatArray) -> str:
        """What keeps a configuration with this excess (2,) from being seen, in words."""
        cone, depth = excess.tolist()
        if cone > 0.0:
            return f"a reflector looks {np.degrees(cone):.3g}° past its acceptance, away from the station"
        return f"a link is {1e3 * depth:.3g} mm within the line of sight"


def distance_between(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> FloatArray:
    """Distances of the segments from a to b and from c to d (m), all (N, 3), shape (N,).

    The lines' nearest points are clamped one after the other (Ericson, Real-Time Collision Detection, 2005, 5.1.9).
    """
    u, v, w = b - a, d - c, a - c
    uu, vv, uv = (u * u).sum(axis=-1), (v * v).sum(axis=-1), (u * v).sum(axis=-1)
    uw, vw = (u * w).sum(axis=-1), (v * w).sum(axis=-1)
    tiny = np.finfo(float).tiny
    across = uu * vv - uv**2
    s = np.where(across > 1e-12 * uu * vv, np.clip((uv * vw - uw * vv) / np.maximum(across, tiny), 0.0, 1.0), 0.0)
    t = np.clip((uv * s + vw) / np.maximum(vv, tiny), 0.0, 1.0)
    s = np.clip((uv * t - uw) / np.maximum(uu, tiny), 0.0, 1.0)
    distance: FloatArray = np.linalg.norm(w + s[:, None] * u - t[:, None] * v, axis=-1)
    return distance


def read_visibility(section: VisibilitySection | None, robot: Robot) -> Visibility | None:
    """The demand of a configuration, or None where there is none.

    Raises:
        InputError: the robot has no tip in space, a direction has no length, or too many reflectors are demanded.
    """
    if section is None:
        return None
    if len(robot.gravity) != 3:
        raise section.where().fault(f"a {robot.kind} moves in a plane, where nothing is seen", "Take the key out.")
    reflectors = []
    for stated in section.reflectors:
        direction = np.array(stated.direction)
        length = float(np.linalg.norm(direction))
        if not length > 0.0:
            what, remedy = "a direction has a length", "Write e.g. `[0, 0, 1]`, in the tip's frame."
            raise stated.where("direction").fault(what, remedy)
        tip = int(tip_number(stated.tip, robot, stated.where("tip"))[0]) if stated.tip is not None else 0
        reflectors.append(Reflector(np.array(stated.at_m), direction / length, stated.acceptance_rad, tip))
    for number, name in enumerate(tips_of(robot), start=1):
        if not any(each.tip in (0, number) for each in reflectors):
            what = f"no reflector sits on `{name}`, so that it can never be measured"
            raise section.where("reflectors").fault(what, "Add one, or leave it out of `poses.tips`.")
    if section.least is not None and section.least > len(reflectors):
        what = f"{section.least} are more than the {len(reflectors)} reflectors"
        raise section.where("least").fault(what, "Demand fewer.")
    return Visibility(np.array(section.station_m), tuple(reflectors), section.link_radius_m, section.least)

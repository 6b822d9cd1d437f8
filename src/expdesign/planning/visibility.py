"""Whether the instrument sees its reflectors (`experiment.constraints.visibility`).

A reflector returns light that comes from within a cone about its own direction (some 30° to either side
for a corner cube in a sphere). The straight line from the instrument's station to it has to pass the robot: links are
capsules around the lines of its drawing, as for collisions. The link that carries the tip does not count, since
reflectors sit on it: their cone says from where that link hides them.
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.mechanics.robots.robot import Robot
from expdesign.planning.schema import VisibilitySection
from expdesign.planning.tips import tip_number, tips_of

_AT_TIP = 1e-9
"""m between the end of a line and the tip, below which the line is the link that carries it."""


@dataclass(frozen=True)
class Visibility:
    """What has to be seen: one of r reflectors or several.

    Attributes:
        station: of the instrument in O (m), shape (3,).
        places: of the reflectors in the tip's frame (m), shape (r, 3).
        directions: unit vectors along which they look, in the tip's frame, shape (r, 3).
        acceptances: largest angles between these and the lines to the station (rad), shape (r,).
        radius: of the links (m).
        tips: number of the tip that each sits on; 0 where the robot has one tip, or one sits on each, shape (r,).
        least: how many reflectors of the tip that is measured have to be seen; all of them if None.
    """

    station: FloatArray
    places: FloatArray
    directions: FloatArray
    acceptances: FloatArray
    radius: float
    tips: IntArray
    least: int | None = None

    def excess(self, robot: Robot, configurations: FloatArray) -> FloatArray:
        """How far configurations (..., n_q) are from being seen, ≤ 0 where they are: angle beyond the cone (rad), and
        depth of the line of sight in a link (m), shape (..., 2).
        """
        found = self._each(robot, configurations.reshape(-1, configurations.shape[-1]))
        # Those that are seen best have to be seen; a reflector of another tip is never among them.
        worst = found.max(axis=-1)
        order = np.argsort(worst, axis=1, kind="stable")
        ranked = np.take_along_axis(found, order[..., None], axis=1)
        mine = np.isfinite(worst).sum(axis=1)
        needed = np.maximum(mine if self.least is None else np.minimum(self.least, mine), 1)
        asked = np.arange(len(self.tips)) < needed[:, None]
        result: FloatArray = np.where(asked[..., None], ranked, -np.inf).max(axis=1)
        return result.reshape(*configurations.shape[:-1], 2)

    def _each(self, robot: Robot, configurations: FloatArray) -> FloatArray:
        """Excess of every reflector at configurations (N, n_q), infinite for those of another tip, (N, r, 2)."""
        origin, rotation = robot.position(configurations)[:, None], robot.jacobians(configurations).rotation
        place = origin + self.places @ rotation.swapaxes(-1, -2)
        line = self.station - place
        looks = self.directions @ rotation.swapaxes(-1, -2)
        cosine = (looks * line).sum(axis=-1) / np.linalg.norm(line, axis=-1)
        cone = np.arccos(np.clip(cosine, -1.0, 1.0)) - self.acceptances
        depth, drawing = np.full(cone.shape, -np.inf), robot.drawing(configurations)
        links = (
            () if drawing is None else [drawing.points[:, list(ends)] for ends in drawing.segments("base", "actuator")]
        )
        for start, end in (np.split(link, 2, axis=1) for link in links):
            carries = np.minimum(*(np.linalg.norm(one - origin, axis=-1) for one in (start, end))) < _AT_TIP
            near = self.radius - distance_between(self.station, place, start, end)
            depth = np.maximum(depth, np.where(carries, -np.inf, near))
        other = (self.tips != 0) & (self.tips != robot.tip_numbers(configurations)[:, None])
        return np.where(other[..., None], np.inf, np.stack([cone, depth], axis=-1))

    def sentence(self, excess: FloatArray) -> str:
        """What keeps a configuration with this excess (2,) from being seen, in words."""
        cone, depth = excess.tolist()
        if cone > 0.0:
            return f"a reflector looks {np.degrees(cone):.3g}° past its acceptance, away from the station"
        return f"a link is {1e3 * depth:.3g} mm within the line of sight"


def distance_between(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> FloatArray:
    """Distances of the segments from a to b and from c to d (m), all (..., 3), shape (...).

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
    distance: FloatArray = np.linalg.norm(w + s[..., None] * u - t[..., None] * v, axis=-1)
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
    directions = np.array([stated.direction for stated in section.reflectors])
    lengths = np.linalg.norm(directions, axis=1, keepdims=True)
    tips = np.zeros(len(directions), dtype=np.int64)
    for index, stated in enumerate(section.reflectors):
        if not lengths[index] > 0.0:
            raise stated.where("direction").fault(
                "a direction has a length", "Write e.g. `[0, 0, 1]`, in the tip's frame."
            )
        if stated.tip is not None:
            tips[index] = tip_number(stated.tip, robot, stated.where("tip"))[0]
    for number, name in enumerate(tips_of(robot), start=1):
        if not np.isin(tips, (0, number)).any():
            what = f"no reflector sits on `{name}`, so that it can never be measured"
            raise section.where("reflectors").fault(what, "Add one, or leave it out of `poses.tips`.")
    if section.least is not None and section.least > len(tips):
        what = f"{section.least} are more than the {len(tips)} reflectors"
        raise section.where("least").fault(what, "Demand fewer.")
    return Visibility(
        station=np.array(section.station_m),
        places=np.array([stated.at_m for stated in section.reflectors]),
        directions=directions / lengths,
        acceptances=np.array([stated.acceptance_rad for stated in section.reflectors]),
        radius=section.link_radius_m,
        tips=tips,
        least=section.least,
    )

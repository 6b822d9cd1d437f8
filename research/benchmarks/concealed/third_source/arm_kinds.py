"""How each kind of an arm is built: from a setting to what an arm conceals by size."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pandas as pd

from ..arms import Arm
from ..campaigns import JOINTS
from ..hexapods import Array
from . import bodies, curves
from .arms import Chain, Concealing, Line, Yields
from .setting import Setting, series

OfSize = Callable[[float], Concealing]
Place = Setting[Arm]


def _joint(place: Place, extra: Callable[[float, Array, Array, Array], Array]) -> OfSize:
    """A joint turns further by `extra(size, torque, torque without load, command)` (N m and rad to rad)."""
    command = place.rows[JOINTS[place.member]].to_numpy(dtype=float)

    def of_size(size: float) -> Concealing:
        def turns(torques: Array, rest: Array, rows: pd.DataFrame) -> Array:
            further = extra(size, torques[:, place.member], rest[:, place.member], command)
            return np.asarray(torques / place.machine.stiffness + place.only(further))

        return Concealing(turns)

    return of_size


def _strain_wave(place: Place) -> OfSize:
    wound, most, stretch = curves.windup(place.drawn["knee"], place.drawn["second"]), place.most, place.stretch

    def extra(size: float, torque: Array, rest: Array, command: Array) -> Array:
        path, friction, limit = (torque - rest) / most, np.zeros(len(torque)), size * place.drawn["friction"]
        for own in series(place.rows):
            friction[own] = curves.dahl(path[own], limit, limit)
        return np.asarray(stretch * (size * wound(torque / most) - friction))

    return _joint(place, extra)


def _gear_mesh(place: Place) -> OfSize:
    teeth, own = round(place.drawn["teeth"]), float(place.machine.stiffness[place.member])

    def extra(size: float, torque: Array, rest: Array, command: Array) -> Array:
        phase = command / (2 * np.pi) * teeth + place.drawn["phase"]
        return np.asarray(size * torque / own * curves.mesh_compliance(phase, place.drawn["ratio"]))

    return _joint(place, extra)


def _turning_bearing(place: Place) -> OfSize:
    station, own = place.member + 1, float(place.machine.stiffness[place.member])
    waves = 1 + place.drawn["share"] * np.cos(2 * (place.rows[JOINTS[place.member]] - place.drawn["phase"])).to_numpy()
    across = 1.0 - np.abs(np.array(place.machine.links[place.member].axis))

    def of_size(size: float) -> Concealing:
        def tilts(wrench: Array, rows: pd.DataFrame) -> Array:
            return np.hstack([0 * wrench[:, :3], size / own * waves[:, None] * across * wrench[:, 3:]])

        return Concealing(yields={station: tilts})

    return of_size


def _yields(matrix: Array) -> Yields:
    return lambda wrench, rows: wrench @ matrix.T


def _frame(way: Array) -> Array:
    """Rotation of a frame whose z lies along `way`."""
    across = np.cross([0.3, 1.0, 0.2], way)
    axes = np.column_stack([across, np.cross(way, across), way])
    return np.asarray(axes / np.linalg.norm(axes, axis=0))


def _ends(place: Place) -> tuple[int, Array]:
    """Station at the end of the chosen link, and the way to it in the link's frame (m)."""
    return place.member + 2, np.array(place.machine.links[place.member + 1].place, dtype=float)


def _solid_link(place: Place) -> OfSize:
    station, way = _ends(place)
    length, drawn = float(np.linalg.norm(way)), place.drawn
    matrix = bodies.block(length, drawn["width"] * length, drawn["depth"] * length, drawn["taper"])
    both = np.kron(np.eye(2), _frame(way))
    matrix = both @ matrix @ both.T / matrix[3, 3] / float(place.machine.stiffness[place.member])
    return lambda size: Concealing(yields={station: _yields(size * matrix)})


def _pedestal(place: Place) -> OfSize:
    matrix = bodies.block(*(place.drawn[name] for name in ("height", "width", "depth", "taper")))
    matrix = matrix / matrix[3, 3] / float(place.machine.stiffness[0])
    return lambda size: Concealing(yields={0: _yields(size * matrix)})


def _eccentric_encoder(place: Place) -> OfSize:
    return _joint(place, lambda size, torque, rest, command: size * np.sin(command + place.drawn["phase"]))


def _approach_band(place: Place) -> OfSize:
    """The first configuration is reached from the zero position; rows of a series do not move the joint."""
    command = place.rows[JOINTS[place.member]].to_numpy(dtype=float)
    starts = [own[0] for own in series(place.rows)]
    came = np.sign(np.diff(command[starts], prepend=0.0))
    short = -0.5 * np.repeat(came, [len(own) for own in series(place.rows)])
    return _joint(place, lambda size, torque, rest, command: size * short)


def _umbilical(place: Place) -> OfSize:
    turned, drawn = place.drawn["direction"], place.drawn
    stand = Chain(place.machine)
    reached = np.array([stand.rigid(q)[0] for q in place.rows[list(JOINTS)].to_numpy(dtype=float)])
    away = 1.2 * float(np.hypot(*reached[:, :2].T).max())
    anchor = np.array([away * np.cos(turned), away * np.sin(turned), drawn["height"]])
    length = drawn["slack"] * float(np.linalg.norm(reached - anchor, axis=1).max())

    def of_size(size: float) -> Concealing:
        cable = Line((0, 6), (anchor, np.array(place.machine.flange)), lambda span: curves.catenary(span, length, size))
        return Concealing(lines=(cable,))

    return of_size


def _counterbalance(place: Place) -> OfSize:
    """Between the first link, beside the second joint, and the upper arm."""
    arm, lean = place.drawn["arm"], place.drawn["lean"]
    seat = np.array(place.machine.links[1].place) + 1.2 * arm * np.array([np.cos(lean), 0.0, np.sin(lean)])
    eye = 1.5 * arm * np.array([0.0, 0.0, 1.0])
    longest = 2.7 * arm

    def force(span: Array) -> Array:
        length = np.linalg.norm(span, axis=1, keepdims=True)
        pressed = 1 / (1 - (longest - length) / longest / place.drawn["gas"])
        return np.asarray(span / length * pressed)

    return lambda size: Concealing(lines=(Line((1, 2), (seat, eye), lambda span: size * force(span)),))


def _warm_link(place: Place) -> OfSize:
    station, way = _ends(place)
    rows, length = place.rows, float(np.linalg.norm(way))
    times, room = (rows[name].to_numpy(dtype=float) for name in ("time_s", "temperature_degC"))
    mean, moment = bodies.wall(times, room, place.drawn["diffusion_s"])
    bent, side = moment * place.drawn["slenderness"], place.drawn["side"]  # κL over the expansion
    away = -np.array([np.cos(side), np.sin(side), 0.0])
    twist = np.zeros((len(rows), 6))
    twist[:, :3] = bent[:, None] * length / 2 * away + mean[:, None] * length * np.array([0, 0, 1.0])
    twist[:, 3:] = bent[:, None] * np.cross([0, 0, 1.0], away)
    twist = twist @ np.kron(np.eye(2), _frame(way)).T
    return lambda size: Concealing(yields={station: lambda wrench, rows: size * twist})


BUILDS: dict[str, Callable[[Place], OfSize]] = {
    "strain_wave": _strain_wave,
    "gear_mesh": _gear_mesh,
    "turning_bearing": _turning_bearing,
    "solid_link": _solid_link,
    "pedestal": _pedestal,
    "eccentric_encoder": _eccentric_encoder,
    "approach_band": _approach_band,
    "umbilical": _umbilical,
    "counterbalance": _counterbalance,
    "warm_link": _warm_link,
}
MEMBERS = {  # indices of the joints or links that may be drawn, where not any that is loaded
    "turning_bearing": (0, 1, 2),
    "solid_link": (1, 2),
    "pedestal": (0,),
    "counterbalance": (1,),
    "warm_link": (1, 2),
    "umbilical": (5,),
    "eccentric_encoder": (0, 1, 2, 3, 4),
    "approach_band": (0, 1, 2, 3, 4),
}

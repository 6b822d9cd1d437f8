"""How each kind of a hexapod is built: from a setting to machines by size."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pandas as pd

from ..campaigns import wrenches
from ..hexapods import Array, Hexapod
from . import bodies, curves
from .hexapods import Machine
from .setting import Setting, series, since_start

OfSize = Callable[[float], Machine]
Place = Setting[Hexapod]


def _leg(place: Place, extra: Callable[[float, Array, pd.DataFrame], Array]) -> OfSize:
    """One leg is longer by `extra(size, its force over the largest, rows)` times its largest stretch."""

    def of_size(size: float) -> Machine:
        def longer(forces: Array, rows: pd.DataFrame) -> Array:
            further = extra(size, forces[:, place.member] / place.most, rows)
            return np.asarray(forces / place.machine.stiffness + place.only(place.stretch * further))

        return Machine(place.machine, longer=longer)

    return of_size


def _bearing_pair(place: Place) -> OfSize:
    moved = curves.bearing_pair(place.drawn["unloads_at"])
    whole = float(moved(np.array(1.0)))
    return _leg(place, lambda size, force, rows: size / whole * moved(force))


def _worn_screw(place: Place) -> OfSize:
    contact, rests_at = place.drawn["contact"], place.drawn["rests_at"]

    def extra(size: float, force: Array, rows: pd.DataFrame) -> Array:
        play = np.where(force > 0, 1 - rests_at, -rests_at) * (force != 0)
        return np.asarray(size * (play + contact * np.sign(force) * np.abs(force) ** (2 / 3)))

    return _leg(place, extra)


def _oil_film(place: Place) -> OfSize:
    moved = curves.hydrostatic(place.drawn["pressure_ratio"], place.drawn["used"])
    return _leg(place, lambda size, force, rows: size * moved(force))


def _presliding(place: Place) -> OfSize:
    def extra(size: float, force: Array, rows: pd.DataFrame) -> Array:
        friction = np.zeros(len(force))
        for own in series(rows):
            friction[own] = curves.dahl(force[own], size, size * place.drawn["presliding"])
        return -friction

    return _leg(place, extra)


def _findley_creep(place: Place) -> OfSize:
    times, exponent = place.rows["time_s"].to_numpy(dtype=float), place.drawn["exponent"]

    def crept(loads: Array, rows: pd.DataFrame) -> Array:
        """Loads leave between series; what has not yet come back is in the unloaded reading."""
        ends = [own[-1] for own in series(rows)][:-1]
        stops = np.insert(times, np.array(ends) + 1, times[ends] + 5.0)
        steps = np.insert(loads, np.array(ends) + 1, 0.0, axis=0)
        real = np.delete(np.arange(len(stops)), np.array(ends) + 1 + np.arange(len(ends)))
        return since_start(curves.findley(steps, stops, exponent)[real], rows)

    if place.drawn["of_all"] < 0.5:
        return _leg(place, lambda size, force, rows: size * crept(force, rows))
    scale = _base_scale(place.machine)

    def of_size(size: float) -> Machine:
        return _on_base(place.machine, lambda wrench, rows: size * crept(wrench * scale, rows))

    return of_size


def _base_scale(hexapod: Hexapod) -> Array:
    """Compliances (6) of three mounts under the base, each as compliant as a leg."""
    mount, radius = 1.0 / float(hexapod.stiffness.mean()), float(np.hypot(*hexapod.base[0, :2]))
    return np.array([mount / 3] * 3 + [2 * mount / 3 / radius**2] * 2 + [mount / 3 / radius**2])


def _on_base(hexapod: Hexapod, moved: Callable[[Array, pd.DataFrame], Array]) -> Machine:
    """The base moves as a rigid body by a twist (rows × 6) at O, which depends on the wrench on it there."""

    def feet(pulls: Array, rows: pd.DataFrame) -> Array:
        wrench = np.hstack([pulls.sum(axis=1), np.cross(hexapod.base, pulls).sum(axis=1)])
        twist = moved(wrench, rows)
        return np.asarray(twist[:, None, :3] + np.cross(twist[:, None, 3:], hexapod.base))

    return Machine(hexapod, feet=feet)


def _rubber_mounts(place: Place) -> OfSize:
    radius, mount = 1.2 * float(np.hypot(*place.machine.base[0, :2])), 1.0 / float(place.machine.stiffness.mean())
    angles = place.drawn["lateral"] * 20 + 2 * np.pi / 3 * np.arange(3)
    at = radius * np.column_stack([np.cos(angles), np.sin(angles)])
    # Vertical forces of three mounts by (Fz, Mx, My): sum f = Fz, sum f y = Mx, −sum f x = My.
    share = np.linalg.inv(np.vstack([np.ones(3), at[:, 1], -at[:, 0]]))
    vertical = _wrenches_on_base(place)[:, [2, 3, 4]] @ share.T
    most, side = float(np.abs(vertical).max()), place.drawn["lateral"]

    def of_size(size: float) -> Machine:
        yielding = size * mount

        def moved(wrench: Array, rows: pd.DataFrame) -> Array:
            forces = wrench[:, [2, 3, 4]] @ share.T / most
            sunk = [curves.rubber(one, place.drawn["softens"], place.drawn["damage"]) for one in forces.T]
            rise_turn = yielding * most * np.array(sunk).T @ share
            slide = yielding / side / 3 * wrench[:, [0, 1, 5]] / [1.0, 1.0, radius**2]
            return np.column_stack([slide[:, :2], rise_turn, slide[:, 2]])

        return _on_base(place.machine, moved)

    return of_size


def _wrenches_on_base(place: Place) -> Array:
    """Wrench of each row at O (rows × 6, N, N m)."""
    forces, hexapod = wrenches(place.machine, place.rows), place.machine
    origin = place.rows[["x_m", "y_m", "z_m"]].to_numpy(dtype=float) + hexapod.home
    return np.hstack([forces[:, :3], forces[:, 3:] + np.cross(origin, forces[:, :3])])


def _opening_foot(place: Place) -> OfSize:
    """A ring of 24 places of contact with bolts between; each opens where it is pulled by more than its preload."""
    hexapod, first = place.machine, 2 * (place.member // 2)
    pair, reach = [first, first + 1], float(np.hypot(*hexapod.base[0, :2]))
    lever = hexapod.base[pair] - hexapod.base[pair].mean(axis=0) + [0, 0, place.drawn["height"] * reach]
    around = 2 * np.pi * np.arange(24) / 24
    radius, preload = place.drawn["radius"] * reach, place.drawn["preload"] * place.most
    opens = np.column_stack([np.ones(24), radius * np.sin(around), -radius * np.cos(around)])

    def of_size(size: float) -> Machine:
        closed = float(hexapod.stiffness.mean()) / size / 24
        bolts, apart = 0.15 * closed, preload / 24 / (0.85 * closed)

        def feet(pulls: Array, rows: pd.DataFrame) -> Array:
            own = pulls[:, pair]
            force = np.column_stack([own[..., 2].sum(axis=1), np.cross(lever, own).sum(axis=1)[:, :2]])
            found = np.zeros_like(pulls)
            for row, load in enumerate(force):
                twist = np.linalg.solve(closed * opens.T @ opens, load)
                for _ in range(40):
                    gaps = opens @ twist
                    local = np.where(gaps > apart, bolts, closed)
                    carried = np.where(gaps > apart, bolts * gaps + (closed - bolts) * apart, closed * gaps)
                    change = np.linalg.solve(opens.T @ (local[:, None] * opens), load - opens.T @ carried)
                    twist = twist + change
                    if np.abs(change).max() < 1e-13:
                        break
                rise, *tilt = twist
                found[row, pair] = np.array([0, 0, rise]) + np.cross([*tilt, 0.0], lever)
            return found

        return Machine(hexapod, feet=feet)

    return of_size


def _plate_platform(place: Place) -> OfSize:
    hexapod = place.machine
    radius = float(np.hypot(*hexapod.platform[:, :2].T).max())
    plate = bodies.Plate(place.drawn["overhang"] * radius, hub=place.drawn["hub"] * radius)
    compliance = _scaled(plate.compliance(hexapod.platform), hexapod)

    def of_size(size: float) -> Machine:
        return Machine(hexapod, heads=lambda pulls, rows: _apply(size * compliance, pulls))

    return of_size


def _plate_base(place: Place) -> OfSize:
    hexapod = place.machine
    radius = float(np.hypot(*hexapod.base[:, :2].T).max())
    feet = [np.arctan2(*hexapod.base[[2 * k, 2 * k + 1]].mean(axis=0)[1::-1]) for k in range(3)]
    between = np.array(feet) + 2 * np.pi / 3 * place.drawn["turned"]
    bolts = radius * np.column_stack([np.cos(between), np.sin(between)])
    plate = bodies.Plate(place.drawn["overhang"] * radius, bolts=bolts)
    stands = hexapod.base + np.array([0, 0, place.drawn["height"] * radius])
    compliance = _scaled(plate.compliance(stands), hexapod)

    def of_size(size: float) -> Machine:
        return Machine(hexapod, feet=lambda pulls, rows: _apply(size * compliance, pulls))

    return of_size


def _scaled(compliance: Array, hexapod: Hexapod) -> Array:
    """The compliance of which the largest across the plate is that of a leg."""
    return np.asarray(compliance / compliance[2::3, 2::3].max() / float(hexapod.stiffness.mean()))


def _apply(compliance: Array, forces: Array) -> Array:
    return np.asarray((forces.reshape(-1, 18) @ compliance.T).reshape(-1, 6, 3))


def _warm_wall(place: Place) -> OfSize:
    """The base is on top of a wall six times as high as thick; its warm face looks along `direction`."""
    hexapod, rows = place.machine, place.rows
    times, room = (rows[name].to_numpy(dtype=float) for name in ("time_s", "temperature_degC"))
    height, angle = float(np.linalg.norm(hexapod.home)), place.drawn["direction"]
    mean, moment = bodies.wall(times, room, place.drawn["diffusion_s"])
    bent = moment * 6.0  # κL over the expansion
    away = -np.array([np.cos(angle), np.sin(angle), 0.0])  # the face that is longer pushes the top away
    twist = np.zeros((len(rows), 6))
    twist[:, :3] = bent[:, None] * height / 2 * away + mean[:, None] * height * np.array([0, 0, 1.0])
    twist[:, 3:] = bent[:, None] * np.cross([0, 0, 1.0], away)
    relative = since_start(twist, rows)
    return lambda size: _on_base(hexapod, lambda wrench, rows: size * relative)


def _bellows(place: Place) -> OfSize:
    hexapod = place.machine
    diameter = 2 * place.drawn["diameter"] * float(np.hypot(*hexapod.platform[0, :2]))
    length, aside = float(np.linalg.norm(hexapod.home)), place.drawn["aside"] * diameter / 2
    lateral, angular = 1.5 * (diameter / length) ** 2, diameter**2 / 8
    springs = np.diag([lateral, lateral, 1.0, angular, angular, angular])
    shift = np.eye(6)  # motion of the bellows' end, aside along x
    shift[1, 5], shift[2, 4] = aside, -aside
    matrix = shift.T @ springs @ shift * float(hexapod.stiffness.sum())
    return lambda size: Machine(hexapod, spring=size * matrix)


def _crossed_gauge(place: Place) -> OfSize:
    source, target = _two_axes(place, 3)

    def of_size(size: float) -> Machine:
        def read(found: Array, rows: pd.DataFrame) -> Array:
            crossed = found.copy()
            crossed[:, target] += size * found[:, source]
            return crossed

        return Machine(place.machine, read=read)

    return of_size


def _two_axes(place: Place, targets: int) -> tuple[int, int]:
    """A translation or force, and another of the first `targets` axes."""
    source = min(int(3 * place.drawn["from"]), 2)
    others = [axis for axis in range(targets) if axis != source]
    return source, others[min(int(len(others) * place.drawn["to"]), len(others) - 1)]


def _lagging_gauge(place: Place) -> OfSize:
    rows, axis = place.rows, min(int(6 * place.drawn["axis"]), 5)
    times, room = (rows[name].to_numpy(dtype=float) for name in ("time_s", "temperature_degC"))
    fine = np.linspace(times[0], times[-1], 4000)
    outside, own = np.interp(fine, times, room), np.full(4000, room[0])
    share = 1 - np.exp(-(fine[1] - fine[0]) / place.drawn["lag_s"])
    for step in range(1, 4000):
        own[step] = own[step - 1] + share * (outside[step] - own[step - 1])
    zero = since_start(np.interp(times, fine, own), rows) * float(place.campaign.std[axis])

    def of_size(size: float) -> Machine:
        shift = np.zeros((len(rows), 6))
        shift[:, axis] = size * zero
        return Machine(place.machine, read=lambda found, rows: found + shift)

    return of_size


def _crossed_cell(place: Place) -> OfSize:
    source, target = _two_axes(place, 6)
    largest = np.abs(wrenches(place.machine, place.rows)).max(axis=0)
    share = float(largest[target] / largest[source])

    def of_size(size: float) -> Machine:
        def load(written: Array) -> Array:
            acting = written.copy()
            acting[:, target] -= size * share * written[:, source]
            return acting

        return Machine(place.machine, load=load)

    return of_size


BUILDS: dict[str, Callable[[Place], OfSize]] = {
    "bearing_pair": _bearing_pair,
    "worn_screw": _worn_screw,
    "oil_film": _oil_film,
    "presliding": _presliding,
    "findley_creep": _findley_creep,
    "rubber_mounts": _rubber_mounts,
    "opening_foot": _opening_foot,
    "plate_platform": _plate_platform,
    "plate_base": _plate_base,
    "warm_wall": _warm_wall,
    "bellows": _bellows,
    "crossed_gauge": _crossed_gauge,
    "lagging_gauge": _lagging_gauge,
    "crossed_cell": _crossed_cell,
}

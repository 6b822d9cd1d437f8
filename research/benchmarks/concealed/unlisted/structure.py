"""Recipes: unlisted physics of platform, payload, base, instrument and environment."""

from __future__ import annotations

import numpy as np

from ..case import UnsuitableError
from ..experiments import Experiment, Wishes
from ..hidden import Hidden, Recipe, unit
from ..linear_model import Array, leg_forces, maps_of
from .place import (
    hidden,
    horizontal,
    largest_force,
    leg_compliance,
    moments,
    poses,
    positions,
    series_span,
    spread,
)


def _threshold(values: Array, rng: np.random.Generator) -> tuple[float, float]:
    """A value that 30-60 % of the loaded rows exceed, and the largest."""
    loaded = values[values > 1e-6 * max(float(values.max()), 1e-9)]
    if len(loaded) < 0.3 * len(values):
        raise UnsuitableError("too few rows load it")
    return float(np.quantile(loaded, rng.uniform(0.4, 0.7))), float(loaded.max())


def _opening_bolt(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    holding, most = _threshold(np.hypot(*moments(experiment)[:, :2].T), rng)
    high = 2e-3 / (most - holding)
    return hidden("opening_bolt", 1e-4 * high, high, lambda s: {"holding_Nm": holding, "opened_rad_per_Nm": s})


def _dishing_plate(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    own, knee = leg_compliance(experiment), largest_force(experiment) * rng.uniform(0.1, 0.4)
    return hidden("dishing_plate", 0.01 * own, 20 * own, lambda s: {"compliance_m_per_N": s, "stiffening_N": knee})


def _dragging_mount(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    own, holding = leg_compliance(experiment), largest_force(experiment) * rng.uniform(0.05, 0.2)
    return hidden("dragging_mount", 0.01 * own, 10 * own, lambda s: {"compliance_m_per_N": s, "holding_N": holding})


def _sloshing(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    high = 2.0 * experiment.machine.reach
    return hidden("sloshing", 1e-2 * high, high, lambda s: {"shift_m": s})


def _drooping(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    axis, high = unit(rng, 3), 0.3 * experiment.machine.reach / largest_force(experiment)
    return hidden("drooping_payload", 1e-2 * high, high, lambda s: {"compliance_m_per_N": s, "axis": axis})


def _away(experiment: Experiment, rng: np.random.Generator) -> tuple[Array, Array]:
    """A post beside the machine (in O), and where something from there is fixed to the platform (in P)."""
    robot, reach, angle = experiment.machine.robot, experiment.machine.reach, rng.uniform(0, 2 * np.pi)
    if robot.planar:
        return robot.home + 0.8 * np.array([np.cos(angle), np.sin(angle), 0.0]), np.zeros(3)
    away = reach * np.array([1.2 * np.cos(angle), 1.2 * np.sin(angle), rng.uniform(-0.3, 0.6)])
    local = reach * np.array([0.5 * np.cos(angle + 0.7), 0.5 * np.sin(angle + 0.7), 0.1])
    return robot.home + away, local


def _hose(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    robot = experiment.machine.robot
    post, local = _away(experiment, rng)
    chords = np.array([np.linalg.norm(robot.pose(pose).point(local) - post) for pose in poses(experiment)])
    length = float(chords.max()) * rng.uniform(1.03, 1.15)
    high = largest_force(experiment) / length
    down = [0.0, -1.0, 0.0] if robot.planar else [0.0, 0.0, -1.0]
    return hidden(
        "hose",
        1e-3 * high,
        high,
        lambda s: {"post_m": post, "platform_m": local, "length_m": length, "weight_N_per_m": s, "down": down},
    )


def _bellows(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    planar = experiment.machine.robot.planar
    axis = np.append(unit(rng, 2), 0.0) if planar else unit(rng, 3)
    half = spread(positions(experiment) @ axis, 5e-3) / 2
    local = np.zeros(3) if planar else experiment.machine.reach * np.append(0.4 * unit(rng, 2), 0.2)
    high, share = largest_force(experiment), rng.uniform(0, 1)
    return hidden(
        "bellows",
        2e-3 * high,
        high,
        lambda s: {"axis": axis, "thrust_N": share * s, "rate_N_per_m": s / half, "platform_m": local},
    )


def _wind(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    direction = horizontal(rng, False)
    normal, high = unit(rng, 3), largest_force(experiment)
    normal = (direction + 0.8 * normal) / np.linalg.norm(direction + 0.8 * normal)
    centre = experiment.machine.reach * np.array([0.0, 0.0, rng.uniform(0.2, 1.0)])
    return hidden(
        "wind",
        5e-3 * high,
        1.5 * high,
        lambda s: {"force_N": s, "direction": direction, "normal": normal, "centre_m": centre},
    )


def _taut_wire(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    post, local = _away(experiment, rng)
    own = 1.0 / leg_compliance(experiment)
    preload = 0.3 * largest_force(experiment)
    return hidden(
        "taut_wire",
        1e-2 * own,
        3 * own,
        lambda s: {"post_m": post, "platform_m": local, "stiffness_N_per_m": s, "preload_N": preload},
    )


def _rubber_base(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    planar, own, force = experiment.machine.robot.planar, leg_compliance(experiment), largest_force(experiment)
    ratios, knee = rng.lognormal(0, 0.7, 3), force * rng.uniform(0.1, 0.5)
    if planar:
        ratios[2] = 1e-6
    lever = experiment.machine.reach
    turning, moment = 0.0 if planar else own / lever**2, float(np.abs(moments(experiment, on_base=True)).max())
    return hidden(
        "rubber_base",
        0.01,
        10.0,
        lambda s: {
            "compliance_m_per_N": s * own * ratios,
            "stiffening_N": knee,
            "tilting_rad_per_Nm": s * turning,
            "stiffening_Nm": 0.3 * moment,
        },
    )


def _sinking_floor(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    own, tau = leg_compliance(experiment), series_span(experiment) * rng.uniform(0.02, 0.2)
    tilting = rng.uniform(0.2, 1.5) / experiment.machine.reach**2
    return hidden(
        "sinking_floor",
        2e-3,
        2.0,
        lambda s: {"sinking_m_per_N": s * own, "tilting_rad_per_Nm": s * own * tilting, "tau_s": tau},
    )


def _lifting_foot(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    axis = horizontal(rng, experiment.machine.robot.planar)
    holding, most = _threshold(moments(experiment, on_base=True) @ axis, rng)
    high = 1e-3 / (most - holding)
    return hidden(
        "lifting_foot",
        1e-4 * high,
        high,
        lambda s: {"axis": axis, "holding_Nm": holding, "tilting_rad_per_Nm": s},
    )


def _swaying(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    axis = horizontal(rng, experiment.machine.robot.planar)
    period = float(experiment.rows["time_s"].max()) * rng.uniform(0.1, 0.4)
    return hidden(
        "swaying_building",
        1e-7,
        1e-3,
        lambda s: {"axis": axis, "amplitude_rad": s, "period_s": period, "phase_rad": float(period % 6.28)},
    )


def _base_gradient(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    robot = experiment.machine.robot
    direction = np.array([1.0, 0.0, 0.0]) if robot.planar else horizontal(rng, False)
    spread(experiment.rows["temperature_degC"].to_numpy(dtype=float), 0.3)
    return hidden(
        "base_gradient",
        1e-7,
        3e-4,
        lambda s: {"strain_per_K": s, "direction": direction, "base_m": robot.base_joints},
    )


def _deflections(experiment: Experiment) -> Array:
    """Deflections of the positions by the base model (m)."""
    robot, rows, compliance = experiment.machine.robot, experiment.rows, 1.0 / experiment.machine.true_stiffness
    each = zip(maps_of(robot, rows), leg_forces(robot, rows), strict=True)
    return np.array([maps.pose @ (compliance * force) for maps, force in each])[:, :3]


def _axes(experiment: Experiment) -> list[int]:
    found = [axis for axis in experiment.measured if axis < 3]
    if not found:
        raise UnsuitableError("no positions are measured")
    return found


def _cross_talk(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    largest, form = float(np.abs(_deflections(experiment)).max()), np.zeros((3, 3))
    for axis in _axes(experiment):
        form[axis] = rng.uniform(-1, 1, 3) * (rng.random(3) < 0.6)
        form[axis, (axis + 1) % (2 if experiment.machine.robot.planar else 3)] = rng.choice([-1.0, 1.0])
    return hidden("gauge_cross_talk", 0.01, 1.5, lambda s: {"quadratic_per_m": s / largest * form})


def _interpolation(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    period, amplitude = float(np.abs(_deflections(experiment)).max()) / rng.uniform(0.8, 2.5), np.zeros(3)
    amplitude[_axes(experiment)] = 1.0
    return hidden(
        "interpolation_error", 1e-8, 0.12 * period, lambda s: {"amplitude_m": s * amplitude, "period_m": period}
    )


def _lost_motion(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    axis = int(rng.choice(_axes(experiment)))
    most = float(np.abs(_deflections(experiment)[:, axis]).max())
    return hidden("gauge_lost_motion", 1e-2 * most, most, lambda s: {"play_m": s, "axis": axis})


def _refraction(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    robot = experiment.machine.robot
    up = 1 if robot.planar else 2
    if up not in experiment.measured:
        raise UnsuitableError("height is not measured")
    near = 2.5 * float(np.abs(positions(experiment)).max())
    angle = rng.uniform(0, 2 * np.pi)
    stand = near * np.array([np.cos(angle), np.sin(angle), 0.0])
    return hidden("refraction", 1e-7, 3e-3, lambda s: {"bending_per_m_K": s, "instrument_m": stand, "up": up})


_THERMAL = Wishes(time=True, temperature=True)
_READING = Wishes(positions=True, large=True)

STRUCTURE = (
    Recipe("opening_bolt", lambda rng: Wishes(), _opening_bolt, planar=False),
    Recipe("dishing_plate", lambda rng: Wishes(load="wrench", large=True), _dishing_plate, planar=False),
    Recipe("dragging_mount", lambda rng: Wishes(load="wrench", path="stairs"), _dragging_mount),
    Recipe("sloshing", lambda rng: Wishes(load="payload", wide=True), _sloshing, planar=False),
    Recipe("drooping_payload", lambda rng: Wishes(load="payload"), _drooping, planar=False),
    Recipe("hose", lambda rng: Wishes(wide=True), _hose),
    Recipe("bellows", lambda rng: Wishes(wide=True), _bellows),
    Recipe("wind", lambda rng: Wishes(wide=True), _wind, planar=False),
    Recipe("taut_wire", lambda rng: Wishes(wide=True), _taut_wire),
    Recipe("rubber_base", lambda rng: Wishes(), _rubber_base),
    Recipe("sinking_floor", lambda rng: Wishes(path="hold", time=True), _sinking_floor, planar=False),
    Recipe("lifting_foot", lambda rng: Wishes(), _lifting_foot),
    Recipe("swaying_building", lambda rng: _THERMAL, _swaying),
    Recipe("base_gradient", lambda rng: _THERMAL, _base_gradient),
    Recipe("gauge_cross_talk", lambda rng: _READING, _cross_talk),
    Recipe("interpolation_error", lambda rng: _READING, _interpolation),
    Recipe("gauge_lost_motion", lambda rng: Wishes(positions=True, path="stairs", large=True), _lost_motion),
    Recipe("refraction", lambda rng: Wishes(time=True, temperature=True, positions=True, wide=True), _refraction),
)

"""Recipes: unlisted physics of legs, their joints and the geometry."""

from __future__ import annotations

import numpy as np

from research.laboratory.kinematics import leg_lengths

from ..case import UnsuitableError
from ..experiments import Experiment, Wishes
from ..hidden import Hidden, Recipe, leg_or_all, pick_leg, unit
from .place import hidden, leg_compliance, lengths, positions, series_span, spread, swivels

_COMPLIANCE = Wishes(large=True, wide=True)


def _leg(experiment: Experiment, rng: np.random.Generator, reversals: bool = False) -> tuple[int, str]:
    leg = pick_leg(experiment, rng, reversals)
    return leg, f"leg {leg + 1}"


def _screw_length(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    leg, name = _leg(experiment, rng)
    own = lengths(experiment)[:, leg]
    middle, half = float(own.mean()), spread(own, 5e-3) / 2
    sign = 1.0 if rng.random() < 0.8 else -1.0
    return hidden(
        "screw_length",
        0.02,
        0.9,
        lambda size: {"component": name, "slope_per_m": sign * size / half, "middle_m": middle},
    )


def _screw_wear(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    leg, name = _leg(experiment, rng)
    own = lengths(experiment)[:, leg]
    centre, width = float(np.quantile(own, rng.uniform(0.25, 0.75))), spread(own, 5e-3) * rng.uniform(0.1, 0.2)
    return hidden(
        "screw_wear",
        0.02,
        2.0,
        lambda size: {"component": name, "softening": size, "centre_m": centre, "width_m": width},
    )


def _warm_leg(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    component = leg_or_all(experiment, rng)
    warmth = experiment.rows["temperature_degC"].to_numpy(dtype=float)
    middle, half = float(warmth.mean()), spread(warmth, 0.8) / 2
    return hidden(
        "warm_leg",
        0.02,
        0.8,
        lambda size: {"component": component, "slope_per_K": size / half, "reference_degC": middle},
    )


def _place_friction(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    leg, name = _leg(experiment, rng)
    own = lengths(experiment)[:, leg]
    tight, width = float(np.quantile(own, rng.uniform(0.1, 0.9))), spread(own, 5e-3) * rng.uniform(0.2, 0.4)
    most = 0.8 * float(np.abs(experiment.forces[:, leg]).max())
    return hidden(
        "place_friction",
        1e-3 * most,
        most,
        lambda size: {"component": name, "breakaway_N": size, "tight_m": tight, "width_m": width},
    )


def _bouc_wen(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    component = leg_or_all(experiment, rng)
    limit = float(np.abs(experiment.forces).max()) * rng.uniform(0.15, 0.5)
    return hidden("bouc_wen", 0.02, 1.5, lambda size: {"component": component, "ratio": size, "saturation_N": limit})


def _seating(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    component = leg_or_all(experiment, rng)
    return hidden("seating", 0.02, 1.5, lambda size: {"component": component, "set_ratio": size})


def _holding_droop(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    component, span = leg_or_all(experiment, rng), series_span(experiment)
    after, width = span * rng.uniform(0.3, 0.7), span * rng.uniform(0.03, 0.15)
    return hidden(
        "holding_droop",
        0.02,
        1.5,
        lambda size: {"component": component, "ratio": size, "after_s": after, "width_s": width},
    )


def _sagging_leg(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    component = leg_or_all(experiment, rng, every=0.5)
    vertical = [0.0, 1.0, 0.0] if experiment.machine.robot.planar else [0.0, 0.0, 1.0]
    return hidden("sagging_leg", 0.05, 5.0, lambda size: {"component": component, "ratio": size, "vertical": vertical})


def _place_backlash(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    leg, name = _leg(experiment, rng, reversals=True)
    own = lengths(experiment)[:, leg]
    worn, width = float(np.quantile(own, rng.uniform(0.3, 0.7))), spread(own, 5e-3) * rng.uniform(0.15, 0.3)
    return hidden(
        "place_backlash", 2e-7, 1e-4, lambda size: {"component": name, "gap_m": size, "worn_m": worn, "width_m": width}
    )


def _encoder_defect(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    leg, name = _leg(experiment, rng)
    own = lengths(experiment)[:, leg]
    place, width = float(np.quantile(own, rng.uniform(0.25, 0.75))), spread(own, 5e-3) * rng.uniform(0.08, 0.18)
    return hidden(
        "encoder_defect",
        1e-7,
        1e-4,
        lambda size: {"component": name, "height_m": size, "place_m": place, "width_m": width},
    )


def _feed_forward(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    component = leg_or_all(experiment, rng, every=0.6)
    planar = experiment.machine.robot.planar
    direction = np.append(unit(rng, 2), 0.0) if planar else unit(rng, 3)
    half = spread(positions(experiment) @ direction, 5e-3) / 2
    return hidden(
        "load_feed_forward",
        0.02,
        0.9,
        lambda size: {"component": component, "gain_per_m": size / half, "direction": direction},
    )


def _shared_supply(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    typical = float(np.abs(experiment.forces).sum(axis=1).max())
    return hidden("shared_supply", 0.02, 1.0, lambda size: {"sag": size, "typical_N": typical})


def _length_scale(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    leg, name = _leg(experiment, rng)
    robot = experiment.machine.robot
    home = robot.pose(np.zeros(2 if robot.planar else 6))
    zero = float(leg_lengths(robot.base_joints, robot.platform_joints, home)[leg])
    half = spread(lengths(experiment)[:, leg], 5e-3) / 2
    limit = 0.06 * experiment.machine.reach / half
    return hidden("length_scale", 1e-2 * limit, limit, lambda size: {"component": name, "scale": size, "zero_m": zero})


def _needle_bearing(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    leg, name = _leg(experiment, rng)
    pitch = spread(swivels(experiment, leg), 0.03) * rng.uniform(0.8, 1.6)
    phase, fork = float(rng.uniform(0, 2 * np.pi)), 0.0 if experiment.machine.robot.planar else float(rng.uniform(0, 3))
    return hidden(
        "needle_bearing",
        0.02,
        2.0,
        lambda size: {
            "component": name,
            "ratio": size,
            "pitch_rad": pitch,
            "phase_rad": phase,
            "fork_rad": fork,
        },
    )


def _worn_socket(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    leg, name = _leg(experiment, rng)
    angles = swivels(experiment, leg)
    spread(angles, 0.03)
    seat = float(np.quantile(angles, rng.uniform(0.3, 0.6)))
    over = float(angles.max()) - seat
    if over < 0.01:
        raise UnsuitableError("the joint hardly swivels")
    return hidden(
        "worn_socket", 0.02, 2.5, lambda size: {"component": name, "ratio": size, "seat_rad": seat, "span_rad": over}
    )


def _smeared_backlash(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    leg, name = _leg(experiment, rng, reversals=True)
    seat = float(np.abs(experiment.forces[:, leg]).max()) * rng.uniform(0.05, 0.25)
    return hidden("smeared_backlash", 2e-7, 1e-4, lambda size: {"component": name, "gap_m": size, "seat_N": seat})


def _dahl_friction(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    component = leg_or_all(experiment, rng)
    most = 0.25 * float(np.abs(experiment.forces).max())  # much more, and the bristles are a spring beside the spring
    bristle = rng.uniform(4.0, 20.0) / leg_compliance(experiment)
    return hidden(
        "dahl_friction",
        1e-3 * most,
        most,
        lambda size: {"component": component, "friction_N": size, "bristle_N_per_m": bristle},
    )


def _other_creep(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    component = leg_or_all(experiment, rng)
    kind = str(rng.choice(["stretched", "logarithmic", "power", "two_maxwell"]))
    tau = series_span(experiment) * rng.uniform(0.05, 0.5)
    shape = 1 / 3 if kind == "power" else float(rng.uniform(0.35, 0.6))
    return hidden(
        "other_creep",
        5e-3,
        1.5,
        lambda size: {"component": component, "kind": kind, "ratio": size, "tau_s": tau, "shape": shape},
    )


def _other_spring(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    shape = str(rng.choice(["preload_loss", "smeared_bilinear", "exponential", "root"]))
    leg, name = _leg(experiment, rng, reversals=shape == "smeared_bilinear")
    scale = float(np.abs(experiment.forces[:, leg]).max()) * rng.uniform(0.1, 0.4)
    return hidden(
        "other_spring", 0.02, 3.0, lambda size: {"component": name, "shape": shape, "size": size, "scale_N": scale}
    )


def _other_drift(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    component = leg_or_all(experiment, rng)
    kind = str(rng.choice(["saturating", "oscillating", "quadratic"]))
    if kind == "quadratic":
        warmth = experiment.rows["temperature_degC"].to_numpy(dtype=float)
        scale, origin = spread(warmth, 0.5), float(warmth.mean())
    else:
        whole = float(experiment.rows["time_s"].max())
        scale, origin = whole * (rng.uniform(0.1, 0.4) if kind == "saturating" else rng.uniform(0.15, 0.5)), 0.0
    return hidden(
        "other_drift",
        1e-7,
        2e-4,
        lambda size: {"component": component, "kind": kind, "growth_m": size, "scale": scale, "origin": origin},
    )


LEGS = (
    Recipe("screw_length", lambda rng: _COMPLIANCE, _screw_length),
    Recipe("screw_wear", lambda rng: _COMPLIANCE, _screw_wear),
    Recipe("warm_leg", lambda rng: Wishes(large=True, time=True, temperature=True), _warm_leg),
    Recipe("place_friction", lambda rng: Wishes(path="stairs", large=True, wide=True), _place_friction),
    Recipe("bouc_wen", lambda rng: Wishes(path="stairs", large=True), _bouc_wen),
    Recipe("seating", lambda rng: Wishes(path="stairs", large=True), _seating),
    Recipe("holding_droop", lambda rng: Wishes(path="hold", time=True, large=True), _holding_droop),
    Recipe("sagging_leg", lambda rng: _COMPLIANCE, _sagging_leg),
    Recipe("place_backlash", lambda rng: Wishes(reversals=True, wide=True), _place_backlash),
    Recipe("encoder_defect", lambda rng: Wishes(series=16, wide=True), _encoder_defect),
    Recipe("load_feed_forward", lambda rng: _COMPLIANCE, _feed_forward),
    Recipe("shared_supply", lambda rng: Wishes(large=True), _shared_supply),
    Recipe("length_scale", lambda rng: _COMPLIANCE, _length_scale),
    Recipe("needle_bearing", lambda rng: _COMPLIANCE, _needle_bearing),
    Recipe("worn_socket", lambda rng: _COMPLIANCE, _worn_socket),
)

FORMS = (
    Recipe("smeared_backlash", lambda rng: Wishes(reversals=True), _smeared_backlash),
    Recipe("dahl_friction", lambda rng: Wishes(path="stairs", large=True), _dahl_friction),
    Recipe("other_creep", lambda rng: Wishes(path="hold", time=True), _other_creep),
    Recipe("other_spring", lambda rng: Wishes(large=True, reversals=rng.random() < 0.7), _other_spring),
    Recipe("other_drift", lambda rng: Wishes(time=True, temperature=True), _other_drift),
)

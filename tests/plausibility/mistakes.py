"""Sixty-odd mistakes that people make, each with a word of the unit, sign or part that has to be named."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

Change = Callable[[dict[str, Any]], None]


def _scaled(value: Any, factor: float) -> Any:
    if isinstance(value, list):
        return [_scaled(one, factor) for one in value]
    if isinstance(value, dict):
        return {key: _scaled(one, factor) for key, one in value.items()}
    return value * factor


def scale(*keys: tuple[str, float]) -> Change:
    """Multiply what stands under dotted keys (`targets.*.pose` for all targets) by factors."""

    def change(content: dict[str, Any]) -> None:
        for key, factor in keys:
            _visit(content, key.split("."), partial(_scaled, factor=factor))

    return change


def put(key: str, new: Any) -> Change:
    """Put a value under a dotted key."""
    return lambda content: _visit(content, key.split("."), lambda _: new)


def _visit(place: Any, path: list[str], act: Callable[[Any], Any]) -> None:
    head, *rest = path
    keys = range(len(place)) if head == "*" else [int(head) if isinstance(place, list) else head]
    for key in keys:
        if rest:
            _visit(place[key], rest, act)
        else:
            place[key] = act(place.get(key) if isinstance(place, dict) else place[key])


_H, _L, _A, _B, _R = "hexapod-h1", "hexapod-120kg", "ur5", "bipod", "rubin-camera"
_STD, _LOAD, _BOUNDS = "experiment.deflection_noise.std", "experiment.load", "experiment.poses.bounds"
_DEGREES = 180.0 / np.pi
_GEOMETRY = tuple((f"robot.{key}", 1e3) for key in ("base_joints", "platform_joints", "home"))

CONFIGURATIONS: dict[str, tuple[str, Change, str]] = {
    "a key of an earlier version": (_H, put("optimiser", {"bound_seconds": 3.0}), "has no effect"),
    "geometry in mm": (_H, scale(*_GEOMETRY), "millimetres"),
    "geometry and limits in mm": (_H, scale(*_GEOMETRY, ("robot.limits.leg_length", 1e3)), "millimetres"),
    "limits in mm": (_H, scale(("robot.limits.leg_length", 1e3)), "millimetres"),
    "home in mm": (_H, scale(("robot.home", 1e3)), "millimetres"),
    "base in mm": (_H, scale(("robot.base_joints", 1e3)), "millimetres"),
    "platform in mm": (_H, scale(("robot.platform_joints", 1e3)), "millimetres"),
    "bipod in mm": (_B, scale(("robot.base_joints", 1e3), ("robot.home", 1e3)), "millimetres"),
    "stiffness in N/µm": (_H, scale(("robot.actuator_stiffness", 1e-6)), "N/µm"),
    "stiffness in N/mm": (_L, scale(("robot.actuator_stiffness", 1e-3)), "N/mm"),
    "stiffness 20 N/m": (_H, put("robot.actuator_stiffness", [20.0] * 6), "N/µm"),
    "stiffness in mN/m": (_L, scale(("robot.actuator_stiffness", 1e6)), "N/µm"),
    "one leg in N/µm": (_H, put("robot.actuator_stiffness.2", 5.24), "N/µm"),
    "one leg in N/mm": (_R, put("robot.actuator_stiffness.0", 1.5e4), "another unit"),
    "joint stiffness per degree": (_A, scale(("robot.actuator_stiffness", 1e-5)), "actuator_stiffness"),
    "a joint's stiffness in kN·m/rad": (_A, scale(("robot.actuator_stiffness.0", 1e-3)), "arm's own weight of up to"),
    "the instrument's pose in degrees": (_A, put("robot.instrument", [2.3, 1.6, 0.4, 0.6, -1.1, 137.5]), "degrees"),
    "gravity in mm/s²": (_H, put("robot.gravity_m_s2", [0.0, 0.0, -9806.65]), "mm/s²"),
    "gravity in g": (_R, put("robot.gravity_m_s2", [0.0, 0.0, -0.01]), "parts of g"),
    "noise of 2 m": (_H, put(f"{_STD}.dx_m", 2.0), "µm or mm"),
    "noise in µm": (_H, scale((_STD, 1e6)), "µm"),
    "noise in mm": (_A, scale((_STD, 1e3)), "mm"),
    "rotational noise in µrad": (_H, put(f"{_STD}.drx_rad", 2.0), "µrad"),
    "rotational noise in mrad": (_A, put(f"{_STD}.drz_rad", 0.15), "mrad"),
    "noise as variance": (_H, put(_STD, {"dx_m": 2.5e-13, "dy_m": 2.5e-13, "dz_m": 2.5e-13}), "variance"),
    "noise divided twice": (_L, scale((_STD, 1e-6)), "divided by 1e6 twice"),
    "experiment's mass in g": (_H, put(f"{_LOAD}.mass_kg", {"choices": [5000, 10000, 26500]}), "grams"),
    "target's mass in g": (_H, put("targets.0.payload.mass_kg", 26500.0), "grams"),
    "all masses in g": (_L, scale((f"{_LOAD}.mass_kg", 1e3), ("targets.*.payload.mass_kg", 1e3)), "grams"),
    "arm's masses in g": (_A, scale((f"{_LOAD}.mass_kg", 1e3), ("targets.*.payload.mass_kg", 1e3)), "grams"),
    "masses in t": (_R, scale((f"{_LOAD}.mass_kg", 1e-3)), "one of them"),
    "centre of mass 100 m away": (_H, put(f"{_LOAD}.com_x_m", 100.0), "millimetres"),
    "centre of mass in mm": (_H, put(f"{_LOAD}.com_x_m", [-100.0, 100.0]), "millimetres"),
    "target's centre of mass in mm": (_L, put("targets.0.payload.com_m", [0.0, 0.0, 150.0]), "millimetres"),
    "arm's centre of mass in mm": (_A, put(f"{_LOAD}.com_z_m", [50.0, 150.0]), "millimetres"),
    "bounds in mm": (_H, put(f"{_BOUNDS}.x_m", [-30.0, 30.0]), "millimetres"),
    "bipod's bounds in mm": (_B, put(f"{_BOUNDS}.x_m", [-300.0, 300.0]), "millimetres"),
    "bounds in degrees": (_H, put(f"{_BOUNDS}.rx_rad", [-8.6, 8.6]), "degrees"),
    "few degrees": (_L, put(f"{_BOUNDS}.ry_rad", [-3.0, 3.0]), "degrees"),
    "joints in degrees": (_A, put(f"{_BOUNDS}.q2_rad", [-126.0, -30.0]), "degrees"),
    "target in degrees": (_A, put("targets.0.pose", [0.0, -74.0, 86.0, -103.0, -90.0, 0.0]), "degrees"),
    "target's pose in mm": (_B, put("targets.0.pose", [100.0, -50.0]), "millimetres"),
    "tolerance in µm": (_H, put("targets.0.tolerance.dz_m", 1.0), "µm"),
    "tolerance in mm": (_A, put("targets.0.tolerance.dx_m", 0.1), "mm"),
    "tolerance in µrad": (_H, put("targets.0.tolerance.drx_rad", 5.0), "µrad"),
    "force in kN": (_B, scale((f"{_LOAD}.fy_N", 1e-3)), "kN"),
    "all forces in kN and mm": (_B, scale((f"{_LOAD}.fy_N", 1e-6), ("targets.*.wrench", 1e-6)), "kN"),
    "force in mN": (_B, scale((f"{_LOAD}.fy_N", 1e3), ("targets.*.wrench", 1e3)), "force"),
    "error of the centre of mass in mm": (_H, put("experiment.load_error.0.std", [1.0, 1.0, 1.0]), "millimetres"),
    "error of the mass in g": (_L, put("experiment.load_error.1.std", 500.0), "grams"),
    "error of the mass left at 0": (_L, put("experiment.load_error.1.std", 0.0), "remove the source"),
    "error of the mass larger than the lightest load": (_H, put("experiment.load_error.1.std", 6.0), "lightest load"),
    "gravity of a target as a direction": (_H, put("targets.0.gravity_m_s2", [0.0, 0.0, -1.0]), "a direction"),
    "gravity of the robot as a direction": (_H, put("robot.gravity_m_s2", [0.0, 0.0, -1.0]), "a direction"),
    "gravity with a slipped decimal point": (_H, put("robot.gravity_m_s2", [0.0, 0.0, -98.1]), "10 times too large"),
    "gravity in cm/s²": (_A, put("targets.0.gravity_m_s2", [0.0, 0.0, -981.0]), "cm/s²"),
    "gravity upwards": (_H, put("robot.gravity_m_s2", [0.0, 0.0, 9.81]), "hangs upside down"),
    "gravity of a target upwards": (_H, put("targets.0.gravity_m_s2", [0.0, 0.0, 9.81]), "hangs upside down"),
    "weights of the experiment that it does not have": (
        _H,
        put("targets.0.payload", {"mass_kg": 500.0, "same_as": "experiment"}),
        "a payload of its own",
    ),
    "error of the direction in mrad": (_H, put("experiment.load_error.2.std", [0.5, 0.5]), "mrad"),
}  # fmt: skip

Frame = Callable[[pd.DataFrame], pd.DataFrame]
LINEAR, ANGULAR = ("dx_m", "dy_m", "dz_m"), ("drx_rad", "dry_rad", "drz_rad")
_DEVIATIONS = {name: f"s{name[1:]}" for name in (*LINEAR, *ANGULAR)}


def times(factor: float, *names: str) -> Frame:
    """Columns in another unit, their standard deviations with them."""

    def change(frame: pd.DataFrame) -> pd.DataFrame:
        frame = frame.copy()
        for name in names:
            frame[name] *= factor
            if abs(factor) != 1.0 and name in _DEVIATIONS:
                frame[_DEVIATIONS[name]] *= factor
        return frame

    return change


def swapped(first: str, second: str) -> Frame:
    return lambda frame: frame.rename(columns={first: second, second: first})


RECORDINGS: dict[str, tuple[str, Frame, str]] = {
    "translations in mm": (_H, times(1e3, *LINEAR), "mm"),
    "translations in mm, and no other unit": (
        _H,
        lambda frame: frame.assign(**{name: 1e3 * frame[name] for name in LINEAR}),
        r"as in `dx_mm`\.$",
    ),
    "translations in m in columns for µm": (_H, times(1e-6, *LINEAR), "in m, in columns that are named for µm"),
    "dz in m in a column for µm": (_H, lambda frame: frame.assign(dz_m=1e-6 * frame["dz_m"]), "dz_m in m .* for µm"),
    "dz in m in a column for mm": (_L, lambda frame: frame.assign(dz_m=1e-3 * frame["dz_m"]), "dz_m in m .* for mm"),
    "translations of an arm in mm": (_A, times(1e3, *LINEAR), "cannot be a deflection|mm"),
    "everything in mm and mrad": (_H, times(1e3, *LINEAR, *ANGULAR), "mm|cannot be a deflection"),
    "translations in µm": (_H, times(1e6, *LINEAR), "cannot be a deflection"),
    "rotations in degrees": (_H, times(_DEGREES, *ANGULAR), "degrees"),
    "rotations in mrad": (_L, times(1e3, *ANGULAR), "mrad"),
    "rotations in µrad": (_H, times(1e6, *ANGULAR), "cannot be a deflection"),
    "all signs": (_H, times(-1.0, *LINEAR, *ANGULAR), "wrong sign"),
    "all signs of an arm": (_A, times(-1.0, *LINEAR, *ANGULAR), "wrong sign"),
    "sign of dz": (_H, times(-1.0, "dz_m"), "dz_m have the wrong sign"),
    "sign of drx": (_H, times(-1.0, "drx_rad"), "drx_rad have the wrong sign"),
    "sign of the rotations": (_L, times(-1.0, *ANGULAR), "rotations have the wrong sign|moments have the wrong sign"),
    "dx and dy swapped": (_H, swapped("dx_m", "dy_m"), "swapped"),
    "drx and dry swapped": (_L, swapped("drx_rad", "dry_rad"), "swapped"),
    "dy and dz swapped in an arm": (_A, swapped("dy_m", "dz_m"), "swapped"),
    "centres of mass swapped": (_H, swapped("com_x_m", "com_y_m"), "swapped"),
    "masses in g": (_H, times(1e3, "mass_kg"), "grams"),
    "centres of mass in mm": (_H, times(1e3, "com_x_m", "com_y_m", "com_z_m"), "millimetres"),
    "commanded angles in degrees": (_H, times(_DEGREES, "rx_rad", "ry_rad", "rz_rad"), "rad|degrees"),
    "positions in mm": (_H, times(1e3, "x_m", "y_m", "z_m"), "Check the unit"),
}  # fmt: skip

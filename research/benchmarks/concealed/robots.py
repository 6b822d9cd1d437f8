"""Robots to experiment on: what is written in the robot file, and what stands in the laboratory."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from research.laboratory import Robot

from .linear_model import Array, Maps


@dataclass(frozen=True)
class Machine:
    """A robot file's mapping without its stiffness, the true stiffness (N/m), and the sizes of experiments with it.

    `weight_kg`: the class of payload; `reach`: radius of the base joints (m); `travel`: half ranges of the pose (m,
    rad).
    """

    label: str
    mapping: dict[str, Any]
    true_stiffness: Array
    described_stiffness: Array
    weight_kg: float
    reach: float
    travel: Array

    def file(self, softness: float = 1.0) -> dict[str, Any]:
        """The robot file; legs that are `softness` times as soft are described so."""
        stiffness = [float(f"{k / softness:.3g}") for k in self.described_stiffness]
        return self.mapping | {"actuator_stiffness": stiffness}

    @property
    def robot(self) -> Robot:
        return Robot.from_mapping(self.file())


def _circle(radius: Array | float, degrees: Array, height: Array | float) -> Array:
    angles = np.deg2rad(degrees)
    return np.column_stack([radius * np.cos(angles), radius * np.sin(angles), np.broadcast_to(height, angles.shape)])


def _stiffness(rng: np.random.Generator, nominal: Array) -> tuple[Array, Array]:
    """True stiffness, and that of the file, wrong by up to 30 %."""
    true = nominal * rng.uniform(0.85, 1.2, len(nominal))
    if rng.random() < 0.5:
        return true, nominal * rng.uniform(0.92, 1.08)
    return true, true * rng.uniform(0.7, 1.3, len(nominal))


_BASE = np.array([-10, 10, 110, 130, 230, 250]) + 90.0
_TOP = np.array([-50, 50, 70, 170, 190, 290]) + 90.0
_TRAVEL = np.array([0.025, 0.025, 0.015, 0.14, 0.14, 0.2])


def _hexapod(
    rng: np.random.Generator,
    label: str,
    base: Array,
    top: Array,
    home: list[float],
    nominal: Array,
    weight: float,
    orientation: str = "fixed-xyz",
) -> Machine:
    reach = float(np.hypot(base[:, 0], base[:, 1]).mean())
    mapping = {
        "name": "hexapod",
        "kind": "hexapod",
        "orientation": orientation,
        "home": home,
        "base_joints": base.round(6).tolist(),
        "platform_joints": top.round(6).tolist(),
    }
    true, described = _stiffness(rng, nominal)
    scale = np.array([reach / 0.24] * 3 + [1.0] * 3)
    return Machine(label, mapping, true, described, weight, reach, _TRAVEL * scale)


def h1(rng: np.random.Generator) -> Machine:
    """H1 of theory.md 2.2, of the 26.5 kg class."""
    base, top = _circle(0.24, _BASE, 0.0), _circle(0.17, _TOP, -0.03)
    return _hexapod(rng, "H1", base, top, [0.0, 0.0, 0.30], np.full(6, 5.24e6), 26.5)


def h_large(rng: np.random.Generator) -> Machine:
    """H_large of theory.md 2.2, for 120 kg."""
    base, top = _circle(0.36, _BASE, 0.0), _circle(0.28, _TOP, -0.04)
    return _hexapod(rng, "H_large", base, top, [0.0, 0.0, 0.44], np.full(6, 60e6), 120.0)


def moving_xyz(rng: np.random.Generator) -> Machine:
    """A regular hexapod of random proportions whose angles are about moving axes."""
    size = rng.uniform(0.8, 1.5)
    side = np.array([-1, 1, -1, 1, -1, 1])
    third = np.array([0, 0, 120, 120, 240, 240]) + 90.0
    base = _circle(0.24 * size, third + side * rng.uniform(6, 14), 0.0)
    top = _circle(rng.uniform(0.15, 0.19) * size, third + side * (60 - rng.uniform(6, 14)), -0.03 * size)
    home = [0.0, 0.0, round(float(rng.uniform(0.27, 0.36) * size), 4)]
    nominal = np.full(6, rng.uniform(5e6, 3e7))
    return _hexapod(rng, "moving-xyz", base, top, home, nominal, 26.5 * size**2, "moving-xyz")


def irregular(rng: np.random.Generator) -> Machine:
    """A hexapod with scattered joints and legs that are unlike each other."""
    while True:
        size = rng.uniform(0.8, 1.6)
        radius = 0.24 * size * rng.uniform(0.8, 1.2, 6)
        base = _circle(radius, _BASE + rng.uniform(-14, 14, 6), 0.05 * size * rng.uniform(-1, 1, 6))
        radius = 0.17 * size * rng.uniform(0.8, 1.2, 6)
        top = _circle(radius, _TOP + rng.uniform(-14, 14, 6), -0.03 * size + 0.04 * size * rng.uniform(-1, 1, 6))
        home = [round(float(v), 4) for v in size * rng.uniform([-0.02, -0.02, 0.27], [0.02, 0.02, 0.36])]
        nominal = rng.uniform(5e6, 2e7) * rng.uniform(0.6, 1.7, 6)
        machine = _hexapod(rng, "irregular", base, top, home, nominal, 26.5 * size**2)
        if Maps.at(machine.robot, np.zeros(6)).condition < 12:
            return machine


def bipod(rng: np.random.Generator) -> Machine:
    """A planar bipod about the size of theory.md 2.1."""
    half = float(rng.uniform(0.4, 0.6))
    low, high = rng.uniform(-0.05, 0.05, 2).tolist()
    mapping = {
        "name": "bipod",
        "kind": "bipod",
        "home": [0.0, round(float(rng.uniform(0.55, 0.75)), 4)],
        "base_joints": [[-round(half, 4), round(low, 4)], [round(half, 4), round(high, 4)]],
    }
    true, described = _stiffness(rng, rng.uniform(0.8e7, 1.5e7, 2))
    return Machine("bipod", mapping, true, described, 60.0, half, np.array([0.25, 0.2]))


HEXAPODS = {"H1": h1, "H_large": h_large, "irregular": irregular, "moving-xyz": moving_xyz}

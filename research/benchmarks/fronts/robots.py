"""Random robots: bipods and hexapods of any proportions, and the six-axis arm of the shipped configurations."""

from typing import Any

import numpy as np

Mapping = dict[str, Any]
Generator = np.random.Generator

ARM = "ur5"
"""The shipped arm, whose two files are copied beside the configurations."""


def rounded(value: float, digits: int = 4) -> float:
    """A number as a person would write it."""
    return float(f"{value:.{digits}g}")


def within(generator: Generator, low: float, high: float) -> float:
    """A number between two, evenly by its logarithm."""
    return rounded(float(np.exp(generator.uniform(np.log(low), np.log(high)))))


def bipod(generator: Generator) -> Mapping:
    """A planar bipod: distance of its feet and home, both stiffnesses."""
    half = within(generator, 0.2, 0.8)
    height = rounded(half * generator.uniform(0.8, 1.8))
    robot: Mapping = {
        "name": "random bipod",
        "kind": "bipod",
        "home": [rounded(half * generator.uniform(-0.3, 0.3)), height],
        "base_joints": [[-half, 0.0], [half, 0.0]],
        "actuator_stiffness": [within(generator, 3e6, 3e7) for _ in range(2)],
    }
    if generator.random() < 0.5:
        lengths = np.hypot(np.array([robot["home"][0] + half, robot["home"][0] - half]), height)
        robot["limits"] = {"leg_length": [rounded(0.75 * lengths.min()), rounded(1.2 * lengths.max())]}
    return robot


def hexapod(generator: Generator) -> Mapping:
    """A hexapod with joints in three pairs, each joint displaced a little, with or without limits of its legs."""
    radius = within(generator, 0.15, 0.6)
    ratio, height = generator.uniform(0.5, 0.95), radius * generator.uniform(0.9, 1.7)
    spread = np.deg2rad(generator.uniform(6.0, 20.0, 2))
    centres = np.deg2rad([0.0, 120.0, 240.0])
    base = np.sort(np.concatenate([centres - spread[0], centres + spread[0]])) + np.deg2rad(90.0)
    turned = centres + np.deg2rad(60.0)
    platform = np.sort(np.concatenate([turned - spread[1], turned + spread[1]])) + np.deg2rad(90.0)
    platform = np.roll(platform, 1)
    below = rounded(-0.1 * radius * generator.random())
    scatter = generator.uniform(-0.02, 0.02, (2, 6, 3)) * radius
    points = [
        np.stack([size * np.cos(angle), size * np.sin(angle), np.full(6, z)], axis=1)
        for size, angle, z in ((radius, base, 0.0), (ratio * radius, platform, below))
    ]
    joints = [(np.asarray(p) + s).round(4) for p, s in zip(points, scatter, strict=True)]
    lengths = np.linalg.norm(joints[1] + [0.0, 0.0, height] - joints[0], axis=1)
    stiffness = within(generator, 3e6, 3e8)
    robot: Mapping = {
        "name": "random hexapod",
        "kind": "hexapod",
        "home": [0.0, 0.0, rounded(height)],
        "base_joints": joints[0].tolist(),
        "platform_joints": joints[1].tolist(),
        "actuator_stiffness": [rounded(stiffness * generator.uniform(0.8, 1.2)) for _ in range(6)],
    }
    if generator.random() < 0.7:
        stroke = generator.uniform(0.08, 0.25)
        robot["limits"] = {"leg_length": [rounded(lengths.min() * (1 - stroke)), rounded(lengths.max() * (1 + stroke))]}
    return robot


def travel(robot: Mapping, generator: Generator) -> dict[str, list[float]]:
    """Ranges of the pose coordinates, some of them narrow or a single value."""
    if robot["kind"] == "serial":
        centre = generator.uniform([-0.5, -1.8, 0.9, -2.0, -1.8, -0.5], [0.5, -1.0, 1.6, -1.0, -1.2, 0.5])
        half = generator.uniform(0.2, 1.0, 6)
        return {f"q{i + 1}_rad": [rounded(c - h), rounded(c + h)] for i, (c, h) in enumerate(zip(centre, half))}
    size = robot["home"][-1]
    reach = generator.uniform(0.05, 0.15 if robot["kind"] == "hexapod" else 0.4) * size
    ranges = {f"{axis}_m": rounded(reach * generator.uniform(0.6, 1.2)) for axis in "xyz"}
    if robot["kind"] == "bipod":
        ranges.pop("z_m")
    else:
        ranges |= {f"r{axis}_rad": rounded(float(generator.uniform(0.04, 0.2))) for axis in "xyz"}
    return {name: [-half, half] for name, half in ranges.items()}

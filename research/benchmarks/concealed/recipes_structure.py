"""Concealed physics of the structure: platform, base, mounts, joints, geometry."""

from __future__ import annotations

import numpy as np

from .experiments import Experiment, Wishes
from .hidden import Hidden, Recipe, Sized, element, leg_or_all, pick_leg, unit
from .linear_model import Array


def _leg_compliance(experiment: Experiment) -> float:
    return float(np.mean(1.0 / experiment.machine.true_stiffness))


def _bushing(experiment: Experiment, rng: np.random.Generator) -> Array:
    """Compliances along and about three axes for size 1, comparable with those of the robot itself."""
    lever = 0.6 * experiment.machine.reach
    along = 0.5 * _leg_compliance(experiment) * rng.lognormal(0, 0.9, 3)
    about = 0.5 * _leg_compliance(experiment) / lever**2 * rng.lognormal(0, 0.9, 3)
    return np.concatenate([along, about])


def _yielding(physics: str, component: str, experiment: Experiment, rng: np.random.Generator) -> Hidden:
    compliance = _bushing(experiment, rng)
    height = rng.uniform(-0.02, 0.05) if physics == "platform_compliance" else 0.0
    at = [0.0, 0.0, round(float(height), 4)]

    def of_size(size: float) -> Sized:
        return Sized((element(physics, stiffness=1.0 / (size * compliance), at_m=at),))

    return Hidden(physics, (component,), 2e-3, 2.0, of_size)


def _coupling(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    """Two neighbouring legs stand on one mount that yields."""
    joints = experiment.machine.robot.base_joints
    apart = np.linalg.norm(joints[:, None] - joints[None], axis=2)
    pairs = [(i, j) for i in range(6) for j in range(i + 1, 6)]
    nearest = sorted(pairs, key=lambda pair: apart[pair])[:3]
    pair = nearest[int(rng.integers(len(nearest)))]
    compliance = _leg_compliance(experiment) * rng.lognormal(0, 0.4, 6)
    compliance[3:] /= max(apart[pair], 0.05) ** 2
    legs = [pair[0] + 1, pair[1] + 1]

    def of_size(size: float) -> Sized:
        return Sized((element("leg_coupling", legs=legs, stiffness=1.0 / (size * compliance)),))

    return Hidden("leg_coupling", tuple(f"leg {leg}" for leg in legs), 2e-3, 2.0, of_size)


def _joint_compliance(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    leg = pick_leg(experiment, rng)
    planar = experiment.machine.robot.planar
    end = "base" if planar else str(rng.choice(["base", "platform"]))
    axes = "frame" if planar else "radial"
    spread = rng.permutation([1.0, rng.uniform(0.05, 0.5), rng.uniform(0.02, 0.2)])
    compliance = spread * 2.0 * _leg_compliance(experiment)

    def of_size(size: float) -> Sized:
        entry = element(
            "passive_joint_compliance",
            component=f"leg {leg + 1}",
            stiffness_N_per_m=1.0 / (size * compliance),
            end=end,
            axes=axes,
        )
        return Sized((entry,))

    return Hidden("passive_joint_compliance", (f"leg {leg + 1}",), 5e-3, 3.0, of_size)


def _joint_stiffness(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    component = leg_or_all(experiment, rng, every=0.8)
    high = 0.04 / _leg_compliance(experiment) * (0.6 * experiment.machine.reach) ** 2

    def of_size(size: float) -> Sized:
        return Sized((element("passive_joint_stiffness", joint_Nm_per_rad=size, component=component),))

    return Hidden("passive_joint_stiffness", (component,), 1e-3 * high, high, of_size)


def _joint_position(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    leg = f"leg {pick_leg(experiment, rng) + 1}"
    planar = experiment.machine.robot.planar
    end = "base" if planar else str(rng.choice(["base", "platform"]))
    direction = np.append(unit(rng, 2), 0.0) if planar else unit(rng, 3)

    def of_size(size: float) -> Sized:
        x, y, z = size * direction
        return Sized((element("joint_position_error", component=leg, end=end, dx_m=x, dy_m=y, dz_m=z),))

    return Hidden("joint_position_error", (leg,), 1e-4, 0.04 * experiment.machine.reach, of_size)


def _geometric(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    """Always there; it shows where legs are soft for their loads."""
    limit = 6e-3 / float(np.abs(experiment.forces).max() * _leg_compliance(experiment))
    return Hidden(
        "geometric_stiffness",
        ("geometry",),
        1.0,
        limit,
        lambda size: Sized((element("geometric_stiffness"),), softness=size, remark=f"legs {size:.3g} x softer"),
    )


RECIPES = (
    Recipe(
        "platform_compliance",
        lambda rng: Wishes(),
        lambda experiment, rng: _yielding("platform_compliance", "platform", experiment, rng),
        planar=False,
    ),
    Recipe(
        "base_compliance",
        lambda rng: Wishes(),
        lambda experiment, rng: _yielding("base_compliance", "base", experiment, rng),
        planar=False,
    ),
    Recipe("passive_joint_compliance", lambda rng: Wishes(large=True, wide=True), _joint_compliance),
    Recipe("passive_joint_stiffness", lambda rng: Wishes(large=True), _joint_stiffness, planar=False),
    Recipe("leg_coupling", lambda rng: Wishes(), _coupling, planar=False),
    Recipe("geometric_stiffness", lambda rng: Wishes(large=rng.random() < 0.5), _geometric, pairs=False),
    Recipe("joint_position_error", lambda rng: Wishes(large=True), _joint_position),
)

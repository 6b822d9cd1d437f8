"""What an arm may hide, and where it may rightly be found."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from virtual_laboratory.elements.forms import DahlFriction
from virtual_laboratory.legs import Leg, LegConditions, LegLaw

from ..linear_model import Array
from .mechanics import Hidden


@dataclass(frozen=True)
class Concealed:
    """Physics whose size is to be chosen between `low` and `high`; accepted `parts`, names that are no wrong ones."""

    physics: str
    parts: tuple[str, ...]
    names: tuple[str, ...]
    low: float
    high: float
    of_size: Callable[[float], Hidden]


@dataclass(frozen=True)
class Angle(LegLaw):
    """An angle beyond the linear spring from the torque and the joint's angle."""

    law: Callable[[float, float], float]

    def elongation(self, force: float, conditions: LegConditions) -> float:
        return self.law(force, conditions.length)


def _joint(torques: Array, rng: np.random.Generator) -> tuple[int, float]:
    """A joint that carries load, and its largest torque."""
    typical = np.abs(torques).mean(axis=0)
    joint = int(rng.choice(np.flatnonzero(typical > 0.15 * typical.max())))
    return joint, float(np.abs(torques[:, joint]).max())


def gear_by_angle(compliance: Array, torques: Array, rng: np.random.Generator) -> Concealed:
    """A gear whose teeth or wave generator sit off centre is softer over part of its turn. Accepted: the joint."""
    (joint, _), phase, c = _joint(torques, rng), rng.uniform(0, 2 * np.pi), compliance

    def of_size(size: float) -> Hidden:
        return Hidden(laws={joint: lambda: Angle(lambda t, q: size * c[joint] * t * np.cos(q + phase))})

    return Concealed("gear_by_angle", (f"joint {joint + 1}",), (), 0.02, 0.95, of_size)


def gear_hysteresis(compliance: Array, torques: Array, rng: np.random.Generator) -> Concealed:
    """Harmonic drives wind up along a loop (Taghirad, Belanger, J. Dyn. Syst. 120 (1998) 466). Accepted: the joint."""
    joint, most = _joint(torques, rng)
    stiffness, bristle = 1.0 / compliance[joint], rng.uniform(3.0, 15.0)

    def of_size(size: float) -> Hidden:
        law = DahlFriction("leg 1", size * most, bristle * stiffness)
        return Hidden(laws={joint: lambda: law.law(Leg(joint, float(stiffness)))})

    return Concealed("gear_hysteresis", (f"joint {joint + 1}",), ("friction_hysteresis",), 1e-3, 0.3, of_size)


def gear_stiffening(compliance: Array, torques: Array, rng: np.random.Generator) -> Concealed:
    """Harmonic drives are softer at small torque (catalogues: K1 < K2 < K3). Accepted: the joint."""
    joint, most = _joint(torques, rng)
    knee = most * rng.uniform(0.1, 0.3)

    def of_size(size: float) -> Hidden:
        return Hidden(laws={joint: lambda: Angle(lambda t, q: size * compliance[joint] * knee * np.tanh(t / knee))})

    names = ("leg_nonlinear_stiffness", "joint_backlash")
    return Concealed("gear_stiffening", (f"joint {joint + 1}",), names, 0.02, 3.0, of_size)


def hose_torque(compliance: Array, torques: Array, rng: np.random.Generator) -> Concealed:
    """A hose package to the tool is wound up by a joint. Accepted: the joint, payload, environment."""
    (joint, most), phase = _joint(torques, rng), rng.uniform(0, 2 * np.pi)

    def of_size(size: float) -> Hidden:
        return Hidden(torques={joint: lambda q: size * most * np.sin(q + phase)})

    return Concealed("hose_torque", (f"joint {joint + 1}", "payload", "environment"), (), 1e-3, 1.0, of_size)


def softening_link(compliance: Array, torques: Array, rng: np.random.Generator) -> Concealed:
    """A thin-walled or composite link bends more than in proportion (ovalisation). Accepted: the link."""
    link, scale = int(rng.choice([1, 2])), float(np.abs(torques).max())

    def of_size(size: float) -> Hidden:
        def bend(moment: Array, _: float) -> Array:
            across = moment * [1.0, 1.0, 0.2]
            return np.asarray(size * compliance[link] * across * (0.3 + np.linalg.norm(across) / scale))

        return Hidden(links={link: bend})

    return Concealed("softening_link", (f"link {link + 1}",), ("link_compliance",), 0.01, 3.0, of_size)


def tilting_bearing(compliance: Array, torques: Array, rng: np.random.Generator) -> Concealed:
    """A joint's crossed-roller bearing tilts more at some angles than at others. Accepted: the joint, and the link it
    carries, which turns with it."""
    joint, phase = int(rng.integers(1, 4)), rng.uniform(0, 2 * np.pi)

    def of_size(size: float) -> Hidden:
        def tilt(moment: Array, angle: float) -> Array:
            return np.asarray(size * compliance[joint] * moment * [1.0, 1.0, 0.0] * (1 + np.cos(angle + phase)))

        return Hidden(links={joint: tilt})

    parts = (f"joint {joint + 1}", f"link {joint + 1}")
    return Concealed("tilting_bearing", parts, ("joint_compliance", "link_compliance"), 0.01, 3.0, of_size)


def tool_changer(compliance: Array, torques: Array, rng: np.random.Generator) -> Concealed:
    """A tool changer has play that its locking balls take up one by one. Accepted: platform, payload, the last link."""
    seat = float(np.abs(torques[:, -3:]).max()) * rng.uniform(0.1, 0.4)

    def of_size(size: float) -> Hidden:
        return Hidden(tool=lambda moment, _: np.asarray(size * np.tanh(moment / seat)))

    names = ("platform_compliance", "joint_backlash")
    return Concealed("tool_changer", ("platform", "payload", "link 6"), names, 1e-6, 2e-3, of_size)


def rubber_pedestal(compliance: Array, torques: Array, rng: np.random.Generator) -> Concealed:
    """The pedestal stands on rubber that stiffens, more to one side than to the other. Accepted: base."""
    scale, ratios = float(np.abs(torques[:, :2]).max()), rng.lognormal(0, 0.6, 3)

    def of_size(size: float) -> Hidden:
        def tilt(moment: Array, _: float) -> Array:
            return np.asarray(size * compliance[1] * ratios * moment / (1 + np.abs(moment) / (0.3 * scale)))

        return Hidden(base=tilt)

    return Concealed("rubber_pedestal", ("base",), ("base_compliance",), 0.01, 5.0, of_size)


RECIPES = {
    recipe.__name__: recipe
    for recipe in (
        gear_by_angle,
        gear_hysteresis,
        gear_stiffening,
        hose_torque,
        softening_link,
        tilting_bearing,
        tool_changer,
        rubber_pedestal,
    )
}

"""Cases of the second source: a campaign on a machine, physics concealed at 2 to 10 standard deviations, its truth."""

from __future__ import annotations

from collections.abc import Callable
from importlib.metadata import version

import numpy as np

from ..arms import Arm, States, arm_bench
from ..campaigns import DEFLECTION, base_matrices, draw_arm_campaign, draw_campaign
from ..case import Case, UnsuitableError, first_suitable
from ..concealment import Bench, Concealed, Origin, concealed_case
from ..hexapods import Array, Hexapod, draw_hexapod
from . import arm_kinds, arms, frames, leg_kinds, structure_kinds
from .arms import Parts, Stand
from .frames import EngineError, Structure

HEXAPOD_KINDS = leg_kinds.KINDS | structure_kinds.KINDS
ARM_KINDS = arm_kinds.KINDS
KINDS = (*HEXAPOD_KINDS, *ARM_KINDS)
_ATTEMPTS = 40
_REFUSED = (UnsuitableError, EngineError, np.linalg.LinAlgError)


def _hexapod_bench(kind: str, rng: np.random.Generator) -> tuple[Bench, Callable[[], Concealed[Structure]]]:
    """A hexapod's campaign that a kind asks for, and how the kind is concealed in it."""
    hexapod: Hexapod = draw_hexapod(rng)
    campaign = draw_campaign(hexapod, HEXAPOD_KINDS[kind].wishes, rng)

    def clean(structure: Structure | None) -> Array:
        return frames.deflections(structure or Structure(hexapod), campaign.rows)

    rigid, matrices = np.zeros((len(campaign.rows), 6)), base_matrices(hexapod, campaign.rows)
    bench = Bench(
        campaign, DEFLECTION, clean, rigid, matrices, hexapod.file(), {}, hexapod.stiffness, f"hexapod {hexapod.label}"
    )
    return bench, lambda: HEXAPOD_KINDS[kind].conceal(hexapod, campaign, rng)


def _arm_bench(kind: str, rng: np.random.Generator) -> tuple[Bench, Callable[[], Concealed[Parts]]]:
    """Likewise of an arm."""
    arm: Arm = arms.draw_arm(rng)
    campaign = draw_arm_campaign(arm_kinds.LOW, arm_kinds.HIGH, ARM_KINDS[kind].wishes, rng)

    def states(parts: Parts | None) -> States:
        return arms.states(Stand(arm, parts), campaign.rows)

    return arm_bench(arm, campaign, Stand(arm), states, rng), lambda: ARM_KINDS[kind].conceal(arm, campaign, rng)


def draw_case(order: tuple[str, bool], rng: np.random.Generator) -> Case:
    """One case of a kind; a healthy one is a campaign made for it in which nothing is hidden."""
    return first_suitable(lambda _: _attempt(*order, rng), _ATTEMPTS, _REFUSED, order[0])


def _attempt(kind: str, healthy: bool, rng: np.random.Generator) -> Case:
    bench, conceal = (_hexapod_bench if kind in HEXAPOD_KINDS else _arm_bench)(kind, rng)
    return concealed_case(bench, kind, None if healthy else conceal, Origin("second_source", engines()), rng)


def engines() -> dict[str, str]:
    """Versions of the engines that make cases."""
    return {name: version(name) for name in ("openseespy", "PyNiteFEA", "mujoco")}

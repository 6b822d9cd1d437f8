"""Cases of the third source: a campaign on a machine, one kind concealed at 2 to 10 standard deviations, its truth."""

from __future__ import annotations

from collections.abc import Callable
from importlib.metadata import version
from typing import Any

import numpy as np

from ..arms import States, arm_bench, torques
from ..campaigns import DEFLECTION, base_matrices, draw_arm_campaign, draw_campaign, leg_forces
from ..case import Case, UnsuitableError, first_suitable
from ..concealment import Bench, Concealed, Origin, chosen_leg, concealed_case
from ..hexapods import Array
from . import arm_kinds, arms, hexapod_kinds
from .arms import Chain, Concealing
from .hexapods import Machine, draw_hexapod
from .kinds import HEXAPOD, KINDS, Kind
from .setting import Setting

_ATTEMPTS = 40
_REFUSED = (UnsuitableError, np.linalg.LinAlgError)


def _hexapod_bench(name: str, rng: np.random.Generator) -> tuple[Bench, Callable[[], Concealed[Any]]]:
    """A hexapod's campaign that a kind asks for, and how the kind is concealed in it."""
    kind, hexapod = KINDS[name], draw_hexapod(rng)
    campaign = draw_campaign(hexapod, kind.wishes, rng)
    rows = campaign.rows

    def clean(machine: Machine | None) -> Array:
        return (machine or Machine(hexapod)).deflections(rows)

    def conceal() -> Concealed[Any]:
        leg, most = chosen_leg(leg_forces(hexapod, rows), rng, kind.wishes.reversing)
        drawn = {each: float(rng.uniform(*ends)) for each, ends in kind.ranges.items()}
        setting = Setting(hexapod, campaign, leg, most, most / float(hexapod.stiffness[leg]), drawn)
        return _concealed(kind, hexapod_kinds.BUILDS[name](setting), setting)

    rigid, matrices = np.zeros((len(rows), 6)), base_matrices(hexapod, rows)
    label = f"hexapod {hexapod.label}"
    return Bench(campaign, DEFLECTION, clean, rigid, matrices, hexapod.file(), {}, hexapod.stiffness, label), conceal


def _arm_bench(name: str, rng: np.random.Generator) -> tuple[Bench, Callable[[], Concealed[Any]]]:
    """Likewise of an arm."""
    kind, arm = KINDS[name], arms.draw_arm(rng)
    campaign = draw_arm_campaign(arms.LOW, arms.HIGH, kind.wishes, rng)

    def states(conceals: Concealing | None) -> States:
        return Chain(arm, conceals).states(campaign.rows)

    def conceal() -> Concealed[Any]:
        loads = torques(Chain(arm), campaign.rows)
        members = arm_kinds.MEMBERS.get(name)
        if members:
            joint = int(rng.choice(members))
            most = float(np.abs(loads[:, joint]).max())
        else:
            joint, most = chosen_leg(loads, rng, kind.wishes.reversing)
        drawn = {each: float(rng.uniform(*ends)) for each, ends in kind.ranges.items()}
        setting = Setting(arm, campaign, joint, most, most / float(arm.stiffness[joint]), drawn)
        return _concealed(kind, arm_kinds.BUILDS[name](setting), setting)

    return arm_bench(arm, campaign, Chain(arm), states, rng), conceal


def _concealed(kind: Kind, of_size: Callable[[float], Any], setting: Setting[Any]) -> Concealed[Any]:
    number = setting.member + 1
    foot = 2 * (setting.member // 2) + 1
    which = "base" if setting.drawn.get("of_all", 0.0) > 0.5 else f"leg {number}"
    before = f"link {number - 1}" if number > 1 else "base"
    places = tuple(
        each.format(n=foot if "leg {next}" in kind.places else number, next=foot + 1, which=which, before=before)
        for each in kind.places
    )
    _, low, high = kind.size
    remark = ", ".join(f"{name} {value:.4g}" for name, value in setting.drawn.items())
    return Concealed(places, kind.names, low, high, of_size, remark)


def draw_case(order: tuple[str, bool], rng: np.random.Generator) -> Case:
    """One case of a kind; a healthy one is a campaign made for it in which nothing is hidden."""
    return first_suitable(lambda _: _attempt(*order, rng), _ATTEMPTS, _REFUSED, order[0])


def _attempt(name: str, healthy: bool, rng: np.random.Generator) -> Case:
    bench, conceal = (_hexapod_bench if KINDS[name].machine == HEXAPOD else _arm_bench)(name, rng)
    origin = Origin("third_source", {"scikit-fem": version("scikit-fem"), "scipy": version("scipy")})
    return concealed_case(bench, name, None if healthy else conceal, origin, rng)

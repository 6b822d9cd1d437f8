"""Cases of the second source: a campaign on a machine, physics concealed at 2 to 10 standard deviations, its truth."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

import numpy as np

from ..case import Case, Secant, UnsuitableError, first_suitable, in_turn
from . import arm_kinds, arms, frames, leg_kinds, structure_kinds
from .arms import Arm, Parts, Stand
from .campaigns import DEFLECTION, POSITION, Campaign, base_matrices, draw_campaign
from .frames import EngineError, Structure
from .hexapods import Array, Hexapod, draw_hexapod, turn
from .kinds import Concealed

HEXAPOD_KINDS = leg_kinds.KINDS | structure_kinds.KINDS
ARM_KINDS = arm_kinds.KINDS
KINDS = (*HEXAPOD_KINDS, *ARM_KINDS)
LEAST, MOST = 2.0, 10.0  # RMS of what the base fit leaves, in standard deviations of the readings
HEALTHY = 0.15  # at most so much is left of a machine in which nothing is hidden
MOST_CONDITION = 100.0  # of the base fit: the stiffnesses can be told apart
_ATTEMPTS, _SECANT = 40, Secant(near=0.1, steps=8)
_REFUSED = (UnsuitableError, EngineError, np.linalg.LinAlgError)


@dataclass(frozen=True)
class Bench:
    """A campaign on a machine as judge and laboratory see it.

    `clean(None)`: noise-free readings of all rows with nothing hidden; `rigid` and `matrices`: the base model's
    readings without compliance, and per compliance.
    """

    campaign: Campaign
    readings: tuple[str, ...]
    clean: Callable[[Any], Array]
    rigid: Array
    matrices: Array
    robot: dict[str, Any]
    files: dict[str, str]
    stiffness: Array
    label: str

    def fitted(self, readings: Array) -> Array:
        """Readings of all rows by the base model, its compliances fitted to those that are not held out."""
        seen, std = ~self.campaign.held_out, self.campaign.std
        left = (self.matrices[seen] / std[None, :, None]).reshape(-1, 6)
        scale = np.linalg.norm(left, axis=0)
        shown = scale > 1e-9 * scale.max()  # gravity does not load an arm's vertical axis
        if np.linalg.cond(left[:, shown] / scale[shown]) > MOST_CONDITION:
            raise UnsuitableError("the stiffnesses can hardly be told apart")
        right = ((readings - self.rigid)[seen] / std).ravel()
        compliance = np.zeros(6)
        compliance[shown] = np.linalg.lstsq(left[:, shown], right, rcond=None)[0]
        return np.asarray(self.rigid + self.matrices @ compliance)

    def mismatch(self, readings: Array) -> float:
        """RMS of what the base model leaves of readings without noise, in standard deviations."""
        seen = ~self.campaign.held_out
        left = ((readings - self.fitted(readings))[seen] / self.campaign.std).ravel()
        return float(np.sqrt(left @ left / (len(left) - 6)))


def hexapod_bench(kind: str, rng: np.random.Generator) -> tuple[Bench, Callable[[], Concealed[Structure]]]:
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


def arm_bench(kind: str, rng: np.random.Generator) -> tuple[Bench, Callable[[], Concealed[Parts]]]:
    """Likewise of an arm: deflections, or positions of known markers by an instrument at a known place."""
    arm: Arm = arms.draw_arm(rng)
    campaign = arm_kinds.draw_campaign(arm, ARM_KINDS[kind].wishes, rng)
    robot, rows = arm.file(), campaign.rows
    readings: tuple[str, ...] = DEFLECTION
    label = "arm"
    if "marker" in rows:
        low, high = [-0.09, -0.09, -0.03], [0.09, 0.09, 0.15]
        places = {name: rng.uniform(low, high).round(4) for name in ("red", "green", "blue")}
        at, yaw = (rng.uniform([1.4, -1.0, 0.1], [2.4, 1.0, 0.9])).round(4), round(float(rng.uniform(-3, 3)), 4)
        robot |= {"markers": {name: place.tolist() for name, place in places.items()}}
        robot |= {"instrument": [*at.tolist(), 0.0, 0.0, yaw]}
        instrument = (at, turn(2, yaw))
        rigid, matrices = arms.base_positions(arm, rows, places, instrument)
        readings, label = POSITION, "arm, positions"

    def clean(parts: Parts | None) -> Array:
        stand = Stand(arm, parts)
        if "marker" in rows:
            return arms.positions(stand, rows, places, instrument)
        return arms.deflections(stand, rows)

    if "marker" not in rows:
        rigid, matrices = arms.base_deflections(arm, rows)
    files = {"arm.urdf": arm.urdf()}
    bench = Bench(campaign, readings, clean, rigid, matrices, robot, files, arm.stiffness, label)
    return bench, lambda: ARM_KINDS[kind].conceal(arm, campaign, rng)


def draw_case(order: tuple[str, bool], rng: np.random.Generator) -> Case:
    """One case of a kind; a healthy one is a campaign made for it in which nothing is hidden."""
    return first_suitable(lambda _: _attempt(*order, rng), _ATTEMPTS, _REFUSED, order[0])


def _attempt(kind: str, healthy: bool, rng: np.random.Generator) -> Case:
    bench, conceal = (hexapod_bench if kind in HEXAPOD_KINDS else arm_bench)(kind, rng)
    clean = bench.clean(None)
    if bench.mismatch(clean) > HEALTHY:
        raise UnsuitableError("the change of geometry under load shows")
    if healthy:
        return _case(bench, kind, [], clean, rng)
    concealed = conceal()
    target = float(np.exp(rng.uniform(np.log(LEAST), np.log(MOST))))
    size, clean = size_that_shows(bench, concealed, target)
    shown = bench.mismatch(clean)
    if not 0.9 * LEAST <= shown <= 1.1 * MOST:
        raise UnsuitableError(f"{kind} cannot be made to show as much as wanted")
    effect = {
        "physics": kind,
        "listed": bool(concealed.names),
        "parts": list(concealed.parts),
        "names": list(concealed.names),
        "size": size,
        "remark": concealed.remark,
        "mismatch_in_std": shown,
        "curves": [],
    }
    return _case(bench, kind, [effect], clean, rng)


def size_that_shows(bench: Bench, concealed: Concealed[Any], target: float) -> tuple[float, Array]:
    """A size whose mismatch is about `target`, and its readings."""
    kept: dict[float, Array] = {}

    def shown(at: float) -> float:
        kept[at] = bench.clean(concealed.of_size(float(np.exp(at))))
        return float(np.log(max(bench.mismatch(kept[at]), 1e-6)))

    low, high = float(np.log(concealed.low)), float(np.log(concealed.high))
    middle = (low + high) / 2
    at, _ = _SECANT.to(float(np.log(target)), shown, (low, high), middle, shown(middle))
    return float(np.exp(at)), kept[at]


def _case(bench: Bench, kind: str, effects: list[dict[str, Any]], clean: Array, rng: np.random.Generator) -> Case:
    campaign, names = bench.campaign, bench.readings
    recorded = clean + rng.normal(size=clean.shape) * campaign.std
    base, written = bench.fitted(recorded), campaign.rows.copy()
    for axis, name in enumerate(names):
        written[name] = [float(f"{value:.9g}") for value in recorded[:, axis]]
    for axis, name in enumerate(names):
        written[f"s{name}" if name in POSITION else f"s{name[1:]}"] = campaign.std[axis]
    later = written[campaign.held_out].reset_index(drop=True)
    for axis, name in enumerate(names):
        later[f"true_{name}"] = clean[campaign.held_out][:, axis]
        later[f"base_{name}"] = base[campaign.held_out][:, axis]
    written["split"] = np.where(campaign.held_out, "test", "train")
    truth = {
        "family": "second_source" if effects else "none",
        "robot": bench.label,
        "made_for": [kind],
        "without": [],
        "effects": effects,
        "mismatch_in_std": bench.mismatch(clean),
        "true_stiffness": bench.stiffness.tolist(),
        "rows": len(written),
        "held_out_rows": int(campaign.held_out.sum()),
        "series": int(written["series"].nunique()),
        "engines": engines(),
    }
    return Case(bench.robot, written, later, truth, bench.files)


def engines() -> dict[str, str]:
    """Versions of the engines that make cases."""
    return {name: version(name) for name in ("openseespy", "PyNiteFEA", "mujoco")}


def orders(count: int, healthy: int, seed: int, only: tuple[str, ...] = ()) -> list[tuple[str, bool]]:
    """Kinds of the cases and whether nothing is hidden, in random order: every kind once, then again."""
    rng = np.random.default_rng([seed, 0])
    offered = [kind for kind in KINDS if not only or kind in only]
    turns, bare = in_turn(offered, rng), in_turn(offered, rng)
    found = [(next(turns), False) for _ in range(count)] + [(next(bare), True) for _ in range(healthy)]
    return [found[index] for index in rng.permutation(len(found))]

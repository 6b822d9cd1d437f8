"""Physics concealed in a campaign on a machine, whatever engine solves it: its size, its rows, its truth.

The size is chosen so that the base model, fitted to the seen rows, leaves a wanted misfit; the truth keeps the parts,
the size and the held-out rows without noise.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np

from .campaigns import POSITION, Campaign, Wishes
from .case import Case, Secant, UnsuitableError, in_turn
from .hexapods import Array

Machine = TypeVar("Machine")
LEAST, MOST = 2.0, 10.0  # RMS of what the base fit leaves, in standard deviations of the readings
HEALTHY = 0.15  # at most so much is left of a machine in which nothing is hidden
MOST_CONDITION = 100.0  # of the base fit: the stiffnesses can be told apart
_SECANT = Secant(near=0.1, steps=8)


@dataclass(frozen=True)
class Concealed(Generic[Machine]):
    """`of_size` makes the machine with the physics; it shows more the larger the size between `low` and `high`.

    `parts`: components that are right as its place, `names`: identifiers of known physics that are no wrong ones.
    """

    parts: tuple[str, ...]
    names: tuple[str, ...]
    low: float
    high: float
    of_size: Callable[[float], Machine]
    remark: str = ""


@dataclass(frozen=True)
class Kind(Generic[Machine]):
    """A kind of physics: what a campaign must have for it, and how it is concealed in one."""

    wishes: Wishes
    conceal: Callable[..., Concealed[Machine]]


def chosen_leg(forces: Array, rng: np.random.Generator, reversing: bool = False) -> tuple[int, float]:
    """A leg (or joint) that carries load, and its largest force; with `reversing`, one that is pushed and pulled."""
    typical = np.abs(forces).mean(axis=0)
    able = typical > 0.4 * typical.max()
    if reversing:
        able &= np.minimum((forces > 0).mean(axis=0), (forces < 0).mean(axis=0)) > 0.15
    if not able.any():
        raise UnsuitableError("nothing is loaded as this physics needs it")
    leg = int(rng.choice(np.flatnonzero(able)))
    return leg, float(np.abs(forces[:, leg]).max())


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


@dataclass(frozen=True)
class Origin:
    """Family of a source's cases in which something is hidden, and the versions of its engines."""

    family: str
    engines: dict[str, str]


def concealed_case(
    bench: Bench, kind: str, conceal: Callable[[], Concealed[Any]] | None, origin: Origin, rng: np.random.Generator
) -> Case:
    """The case of a campaign: what `conceal` gives is hidden in it, at 2 to 10 standard deviations; or nothing is.

    Raises:
        UnsuitableError: the base model leaves more than nothing of the bare machine, or the physics does not show.
    """
    clean = bench.clean(None)
    if bench.mismatch(clean) > HEALTHY:
        raise UnsuitableError("the change of geometry under load shows")
    if conceal is None:
        return _case(bench, kind, [], clean, origin, rng)
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
    return _case(bench, kind, [effect], clean, origin, rng)


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


def _case(
    bench: Bench, kind: str, effects: list[dict[str, Any]], clean: Array, origin: Origin, rng: np.random.Generator
) -> Case:
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
        "family": origin.family if effects else "none",
        "robot": bench.label,
        "made_for": [kind],
        "without": [],
        "effects": effects,
        "mismatch_in_std": bench.mismatch(clean),
        "true_stiffness": bench.stiffness.tolist(),
        "rows": len(written),
        "held_out_rows": int(campaign.held_out.sum()),
        "series": int(written["series"].nunique()),
        "engines": dict(origin.engines),
    }
    return Case(bench.robot, written, later, truth, bench.files)


def orders(
    kinds: tuple[str, ...], count: int, healthy: int, seed: int, only: tuple[str, ...] = ()
) -> list[tuple[str, bool]]:
    """Kinds of the cases and whether nothing is hidden, in random order: every kind once, then again."""
    rng = np.random.default_rng([seed, 0])
    offered = [kind for kind in kinds if not only or kind in only]
    turns, bare = in_turn(offered, rng), in_turn(offered, rng)
    found = [(next(turns), False) for _ in range(count)] + [(next(bare), True) for _ in range(healthy)]
    return [found[index] for index in rng.permutation(len(found))]

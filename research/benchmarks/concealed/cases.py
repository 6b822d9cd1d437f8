"""Physics of the library and some that is none of it: what is ordered, an experiment, a size that shows, recordings.

A family is none, one, two (physics of the library) or outside.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from . import recipes_legs, recipes_load, recipes_outside, recipes_structure
from .bench import Bench, Order, attempted, case_of, effect_of, ordered, prepared, together
from .case import Case, Secant, UnsuitableError, in_turn
from .experiments import Experiment, draw_experiment
from .hidden import Hidden, Sized
from .linear_model import Array

INSIDE = {
    recipe.physics: recipe for module in (recipes_load, recipes_structure, recipes_legs) for recipe in module.RECIPES
}
OUTSIDE = {recipe.physics: recipe for recipe in recipes_outside.RECIPES}

LEAST, MOST = 1.6, 30.0  # chi2/dof of the base fit to expect; two effects: up to MOST_OF_TWO each
MOST_OF_TWO = 15.0
SHOWS = 1.5  # chi2/dof that the recordings as drawn must have at least
SHARE_NONE, SHARE_TWO, SHARE_OUTSIDE, SHARE_BIPOD = 0.25, 0.15, 0.10, 0.16
_ATTEMPTS, _SECANT = 200, Secant(near=0.1, steps=8, slope=2.0, slopes=(0.7, 6.0))


def orders(count: int, seed: int, only: Sequence[str] = ()) -> list[Order]:
    """What the cases shall be, in random order. `only`: identifiers, or none, one, two, outside."""
    rng = np.random.default_rng([seed, 0])
    kinds = _kinds(count, only)
    single = in_turn([name for name in only if name in INSIDE] or list(INSIDE), rng)
    strange = in_turn([name for name in only if name in OUTSIDE] or list(OUTSIDE), rng)
    made_for = in_turn(list(INSIDE), rng)
    found = []
    for kind in kinds:
        names = {"one": single, "outside": strange, "none": made_for}
        physics: tuple[str, ...] = _pair(rng) if kind == "two" else (next(names[kind]),)
        found.append(ordered(kind, [(INSIDE | OUTSIDE)[name] for name in physics], SHARE_BIPOD, rng))
    return [found[index] for index in rng.permutation(count)]


def _kinds(count: int, only: Sequence[str]) -> list[str]:
    if only:
        asked = [name if name in ("none", "one", "two", "outside") else _kind_of(name) for name in only]
        return [asked[index % len(asked)] for index in range(count)]
    none, two, outside = (round(count * share) for share in (SHARE_NONE, SHARE_TWO, SHARE_OUTSIDE))
    return ["none"] * none + ["two"] * two + ["outside"] * outside + ["one"] * (count - none - two - outside)


def _kind_of(name: str) -> str:
    if name in INSIDE:
        return "one"
    if name in OUTSIDE:
        return "outside"
    raise SystemExit(f"--only {name}: known are none, one, two, outside, {', '.join([*INSIDE, *OUTSIDE])}")


def _pair(rng: np.random.Generator) -> tuple[str, str]:
    names = [name for name, recipe in INSIDE.items() if recipe.pairs]
    while True:
        first, second = (str(name) for name in rng.choice(names, 2, replace=False))
        if INSIDE[first].wishes(rng).compatible(INSIDE[second].wishes(rng)):
            return first, second


class NoisyBench(Bench):
    """A bench with one draw of noise, which is the laboratory's."""

    def __init__(self, experiment: Experiment, seed: int) -> None:
        super().__init__(experiment)
        self._seed = seed
        self.clean = self.measured(Sized(), experiment.rows)
        self._drawn = self.noisy(Sized()) - self.clean

    def noisy(self, sized: Sized) -> Array:
        return self.measured(sized, self.experiment.rows, noise_std=self.experiment.std, seed=self._seed)

    def seen_clean(self, sized: Sized) -> Array:
        """What is left when the noise is taken away: wrong recordings stay, which are drawn with the noise."""
        return self.noisy(sized) - self._drawn

    def later(self, sized: Sized) -> tuple[Array, Array]:
        """Further series without wrong recordings: as recorded, and their noise."""
        right = Sized(
            tuple(each for each in sized.elements if each["physics"] != "outlier"), sized.true_rows, sized.softness
        )
        rows = self.experiment.later
        recorded = self.measured(right, rows, noise_std=self.experiment.std, seed=self._seed + 1)
        return recorded, recorded - self.measured(right, rows)

    def excess(self, sized: Sized) -> float:
        """Expected chi2/dof of the base fit, less 1."""
        return self.fit.misfit(self.seen_clean(sized)) / self.fit.dof


def draw_case(order: Order, rng: np.random.Generator) -> Case:
    """One case of an order."""
    return attempted(order, rng, partial(_attempt, rng=rng), _ATTEMPTS)


def _attempt(order: Order, rng: np.random.Generator) -> Case:
    bench, hidden = prepared(
        order,
        [(INSIDE | OUTSIDE)[name] for name in order.physics],
        rng,
        lambda machine, wishes: NoisyBench(draw_experiment(machine, wishes, rng), int(rng.integers(2**31))),
        lambda bench: bench.fit.misfit(bench.clean) > 1.0,
    )
    if order.family == "none":
        return _case(order, bench, [], [], [], {}, rng)
    most = MOST_OF_TWO if order.family == "two" else MOST
    found = [_size_that_shows(bench, each, most, rng) for each in hidden]
    sizes, alone = [each[0] for each in found], [1.0 + each[1] for each in found]
    each = [one.of_size(size) for one, size in zip(hidden, sizes, strict=True)]
    remarks: dict[str, Any] = {}
    if order.family == "two":
        remarks["alike"] = bench.alike(each)
        if not 0.4 < bench.excess(together(each)) / (sum(alone) - 2.0) < 2.5:
            raise UnsuitableError("the two effects act on each other")
    if order.family == "outside":
        remarks["chi2_dof_beside_known_physics"] = 1.0 + bench.beside_known(each[0]) / bench.fit.dof
    return _case(order, bench, hidden, sizes, alone, remarks, rng)


def _size_that_shows(bench: NoisyBench, hidden: Hidden, most: float, rng: np.random.Generator) -> tuple[float, float]:
    """A size, and the excess of the base fit's expected chi2/dof over 1 that it makes.

    That chi2/dof is drawn between LEAST and `most` (log-uniform), or what the largest sensible size makes.
    """
    low, high = float(np.log(hidden.low)), float(np.log(hidden.high))

    def shown(at: float) -> float:
        return float(np.log(max(bench.excess(hidden.of_size(float(np.exp(at)))), 1e-12)))

    largest = shown(high)
    if largest < np.log(LEAST - 1.0):
        raise UnsuitableError(f"{hidden.physics} cannot be made to show within sensible limits")
    most = min(most, 1.0 + float(np.exp(largest)))
    target = float(np.log(np.exp(rng.uniform(np.log(LEAST), np.log(most))) - 1.0))
    at, value = _SECANT.to(target, shown, (low, high), high, largest)
    excess = float(np.exp(value))
    if not LEAST - 1.1 <= excess <= 1.3 * MOST:
        raise UnsuitableError(f"{hidden.physics} cannot be made to show as much as wanted")
    return float(np.exp(at)), excess


def _case(
    order: Order,
    bench: NoisyBench,
    hidden: Sequence[Hidden],
    sizes: Sequence[float],
    alone: Sequence[float],
    remarks: dict[str, Any],
    rng: np.random.Generator,
) -> Case:
    each = [one.of_size(size) for one, size in zip(hidden, sizes, strict=True)]
    whole, experiment = together(each), bench.experiment
    deflections = bench.noisy(whole)
    chi2 = bench.fit.misfit(deflections) / bench.fit.dof
    if order.family != "none" and chi2 < SHOWS:
        raise UnsuitableError("hidden in the noise")
    recorded, noise = bench.later(whole)
    effects = [
        effect_of(
            one, size, sized, one.physics in INSIDE, [one.physics] if one.physics in INSIDE else [],
            chi2_dof_alone=float(own), mismatch_in_std=float(np.sqrt(own - 1.0)),
        )
        for one, size, own, sized in zip(hidden, sizes, alone, each, strict=True)
    ]  # fmt: skip
    return case_of(
        order, bench, effects, whole, deflections, (recorded, recorded - noise), rng, shuffled=0.05,
        chi2_dof=float(chi2),
        dof=bench.fit.dof,
        largest_misfit_in_std=float(np.abs(bench.fit.residual(bench.seen_clean(whole))).max()),
        later_noise_rms=float(np.sqrt(np.mean((noise / experiment.std)[:, experiment.measured] ** 2))),
        softness=whole.softness,
        **remarks,
    )  # fmt: skip

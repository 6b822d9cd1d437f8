"""Physics of the library and some that is none of it: what is ordered, an experiment, a size that shows, recordings.

A family is none, one, two (physics of the library) or outside.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from virtual_laboratory import Laboratory, LaboratoryError, Robot
from virtual_laboratory.recordings import deflection_columns

from . import recipes_legs, recipes_load, recipes_outside, recipes_structure
from .case import Case, in_turn
from .experiments import Experiment, Wishes, add_bystanders, draw_experiment
from .hidden import Hidden, Recipe, Sized, UnsuitableError, plain
from .linear_model import Array, BaseFit
from .mimicry import remaining_misfit
from .robots import HEXAPODS, bipod

INSIDE = {
    recipe.physics: recipe for module in (recipes_load, recipes_structure, recipes_legs) for recipe in module.RECIPES
}
OUTSIDE = {recipe.physics: recipe for recipe in recipes_outside.RECIPES}

LEAST, MOST = 1.6, 30.0  # chi2/dof of the base fit to expect; two effects: up to MOST_OF_TWO each
MOST_OF_TWO = 15.0
SHOWS = 1.5  # chi2/dof that the recordings as drawn must have at least
_ATTEMPTS, _PATIENCE = 200, 12  # with the robot that was ordered: _PATIENCE


@dataclass(frozen=True)
class Order:
    """What a case shall be.

    For none, `physics` is what the experiment was made for, so that the design of an experiment tells nothing.
    """

    family: str
    physics: tuple[str, ...]
    robot: str

    @property
    def recipes(self) -> list[Recipe]:
        return [(INSIDE | OUTSIDE)[name] for name in self.physics]


SHARE_NONE, SHARE_TWO, SHARE_OUTSIDE, SHARE_BIPOD = 0.25, 0.15, 0.10, 0.16


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
        able = all((INSIDE | OUTSIDE)[name].planar for name in physics)
        robot = "bipod" if able and rng.random() < SHARE_BIPOD else str(rng.choice(list(HEXAPODS)))
        found.append(Order(kind, physics, robot))
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


def drawn(job: tuple[int, int, Order]) -> Case:
    """The case of a seed, a number and an order."""
    seed, number, order = job
    return draw_case(order, np.random.default_rng([seed, number])).numbered(seed, number)


class Bench:
    """The laboratory for one experiment, with one draw of noise."""

    def __init__(self, experiment: Experiment, seed: int) -> None:
        self.experiment, self._seed = experiment, seed
        robot = experiment.machine.robot
        self.fit = BaseFit(
            robot, experiment.rows, experiment.std[experiment.measured], experiment.measured, experiment.fitted
        )
        self.clean = self._measure(Sized(), experiment.rows, noisy=False)
        self._noise = self._measure(Sized(), experiment.rows) - self.clean

    def noisy(self, sized: Sized) -> Array:
        return self._measure(sized, self.experiment.rows)

    def noise_free(self, sized: Sized) -> Array:
        """What is left when the noise is taken away: wrong recordings stay, which are drawn with the noise."""
        return self.noisy(sized) - self._noise

    def later(self, sized: Sized) -> tuple[Array, Array]:
        """Further series without wrong recordings: as recorded, and their noise."""
        right = Sized(
            tuple(each for each in sized.elements if each["physics"] != "outlier"), sized.true_rows, sized.softness
        )
        rows = self.experiment.later
        recorded = self._measure(right, rows, further=1)
        return recorded, recorded - self._measure(right, rows, noisy=False)

    def excess(self, sized: Sized) -> float:
        """Expected chi2/dof of the base fit, less 1."""
        return self.fit.misfit(self.noise_free(sized)) / self.fit.dof

    def _measure(self, sized: Sized, rows: pd.DataFrame, noisy: bool = True, further: int = 0) -> Array:
        machine = self.experiment.machine
        robot = Robot.from_mapping(machine.file(sized.softness))
        laboratory = Laboratory(
            robot,
            true_stiffness=machine.true_stiffness / sized.softness,
            elements=sized.build(),
            noise_std=self.experiment.std if noisy else None,
            seed=self._seed + further,
        )
        measured = laboratory.measure(sized.true_rows(rows))
        return measured[deflection_columns(robot)].to_numpy(dtype=float)


def draw_case(order: Order, rng: np.random.Generator) -> Case:
    """Experiments are drawn until the physics that was ordered shows in one of them; at last on any hexapod."""
    reasons: list[str] = []
    for attempt in range(_ATTEMPTS):
        robot = order.robot if attempt < _PATIENCE else str(rng.choice(list(HEXAPODS)))
        try:
            return _attempt(replace(order, robot=robot), rng)
        except (UnsuitableError, LaboratoryError) as error:
            reasons.append(str(error))
    raise RuntimeError(f"{order}: no suitable experiment in {_ATTEMPTS}: {sorted(set(reasons))}")


def _attempt(order: Order, rng: np.random.Generator) -> Case:
    machine = bipod(rng) if order.robot == "bipod" else HEXAPODS[order.robot](rng)
    wishes = Wishes()
    for recipe in order.recipes:
        wishes = wishes | recipe.wishes(rng)
    experiment = draw_experiment(machine, wishes, rng)
    bench = Bench(experiment, int(rng.integers(2**31)))
    if bench.fit.condition > 60:
        raise UnsuitableError("the legs' stiffnesses can hardly be told apart")
    hidden = [recipe.hide(experiment, rng) for recipe in order.recipes]
    if "geometric_stiffness" not in order.physics and bench.fit.misfit(bench.clean) > 1.0:
        raise UnsuitableError("the change of geometry under load shows")
    if order.family == "none":
        return _case(order, bench, [], [], [], {}, rng)
    most = MOST_OF_TWO if order.family == "two" else MOST
    found = [_size_that_shows(bench, each, most, rng) for each in hidden]
    sizes, alone = [each[0] for each in found], [1.0 + each[1] for each in found]
    remarks: dict[str, Any] = {}
    if order.family == "two":
        remarks["alike"] = _alike(bench, hidden, sizes)
        both = bench.excess(hidden[0].of_size(sizes[0]) | hidden[1].of_size(sizes[1]))
        if not 0.4 < both / (sum(alone) - 2.0) < 2.5:
            raise UnsuitableError("the two effects act on each other")
    if order.family == "outside":
        sized = hidden[0].of_size(sizes[0])
        remaining = remaining_misfit(experiment, bench.fit, bench.noise_free, sized)
        if remaining < 5.0 * np.sqrt(2.0 * bench.fit.dof):
            raise UnsuitableError("known physics explains it to within the noise")
        remarks["chi2_dof_beside_known_physics"] = 1.0 + remaining / bench.fit.dof
    return _case(order, bench, hidden, sizes, alone, remarks, rng)


def _size_that_shows(bench: Bench, hidden: Hidden, most: float, rng: np.random.Generator) -> tuple[float, float]:
    """A size, and the excess of the base fit's expected chi2/dof over 1 that it makes.

    That chi2/dof is drawn between LEAST and `most` (log-uniform), or what the largest sensible size makes; the size
    follows by secant steps between logarithms.
    """
    low, high = float(np.log(hidden.low)), float(np.log(hidden.high))

    def shown(at: float) -> float:
        return float(np.log(max(bench.excess(hidden.of_size(float(np.exp(at)))), 1e-12)))

    at, value = high, shown(high)
    if value < np.log(LEAST - 1.0):
        raise UnsuitableError(f"{hidden.physics} cannot be made to show within sensible limits")
    most = min(most, 1.0 + float(np.exp(value)))
    target = float(np.log(np.exp(rng.uniform(np.log(LEAST), np.log(most))) - 1.0))
    slope = 2.0
    for _ in range(8):
        if abs(value - target) < 0.1:
            break
        following = float(np.clip(at + (target - value) / slope, low, high))
        if following == at:
            break
        reached = shown(following)
        slope = float(np.clip((reached - value) / (following - at), 0.7, 6.0))
        at, value = following, reached
    excess = float(np.exp(value))
    if not LEAST - 1.1 <= excess <= 1.3 * MOST:
        raise UnsuitableError(f"{hidden.physics} cannot be made to show as much as wanted")
    return float(np.exp(at)), excess


def _alike(bench: Bench, hidden: Sequence[Hidden], sizes: Sequence[float]) -> float:
    """Cosine between what two effects leave in the base fit."""
    each = [bench.fit.residual(bench.noise_free(one.of_size(size))) for one, size in zip(hidden, sizes, strict=True)]
    cosine = float(abs(each[0] @ each[1]) / np.linalg.norm(each[0]) / np.linalg.norm(each[1]))
    if cosine > 0.8:
        raise UnsuitableError("the two effects look alike")
    return cosine


def _case(
    order: Order,
    bench: Bench,
    hidden: Sequence[Hidden],
    sizes: Sequence[float],
    alone: Sequence[float],
    remarks: dict[str, Any],
    rng: np.random.Generator,
) -> Case:
    experiment, machine = bench.experiment, bench.experiment.machine
    each = [one.of_size(size) for one, size in zip(hidden, sizes, strict=True)]
    together = Sized()
    for one in each:
        together = together | one
    deflections = bench.noisy(together)
    chi2 = bench.fit.misfit(deflections) / bench.fit.dof
    if order.family != "none" and chi2 < SHOWS:
        raise UnsuitableError("hidden in the noise")
    peak = np.abs(bench.fit.residual(bench.noise_free(together))).max()
    truth = {
        "family": order.family,
        "robot": order.robot,
        "made_for": list(order.physics),
        "without": [],
        "effects": [
            {
                "physics": one.physics,
                "listed": one.physics in INSIDE,
                "parts": list(one.components),
                "names": [one.physics] if one.physics in INSIDE else [],
                "size": size,
                "chi2_dof_alone": float(own),
                "mismatch_in_std": float(np.sqrt(own - 1.0)),
                "elements": [dict(entry) for entry in sized.elements],
                "curves": [],
                "remark": sized.remark,
            }
            for one, size, own, sized in zip(hidden, sizes, alone, each, strict=True)
        ],
        "chi2_dof": float(chi2),
        "dof": bench.fit.dof,
        "mismatch_in_std": float(np.sqrt(bench.excess(together))),
        "largest_misfit_in_std": float(peak),
        "softness": together.softness,
        "true_stiffness": (machine.true_stiffness / together.softness).tolist(),
        "rows": len(experiment.rows),
        "series": int(experiment.rows["series"].nunique()),
        **remarks,
    }
    rows = experiment.rows.copy()
    add_bystanders(rows, rng)
    recordings = experiment.written(rows, deflections)
    if rng.random() < 0.05:
        recordings = recordings.iloc[rng.permutation(len(recordings))]
    recorded, noise = bench.later(together)
    later = experiment.written(experiment.later, recorded, recorded - noise)
    truth["later_noise_rms"] = float(np.sqrt(np.mean((noise / experiment.std)[:, experiment.measured] ** 2)))
    return Case(machine.file(together.softness), recordings, later, plain(truth))

"""One case of physics outside the library: concealed at 2 to 10 standard deviations, its held-out rows inside."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from virtual_laboratory import Laboratory, LaboratoryError, Robot
from virtual_laboratory.elements.unlisted.law import Unlisted
from virtual_laboratory.legs import Leg
from virtual_laboratory.recordings import deflection_columns

from ..case import Case, in_turn
from ..cases import INSIDE
from ..experiments import USUAL, Experiment, Extent, Wishes, add_bystanders, draw_interleaved
from ..hidden import Hidden, Sized, UnsuitableError, numbers_of, plain
from ..linear_model import Array, BaseFit
from ..mimicry import remaining_misfit
from ..robots import HEXAPODS, bipod
from .legs import FORMS, LEGS
from .place import CATALOGUE, lengths
from .structure import STRUCTURE

UNLISTED = {recipe.physics: recipe for recipe in (*LEGS, *STRUCTURE)}
OTHER_FORMS = {recipe.physics: recipe for recipe in FORMS}
LISTED = {name: recipe for name, recipe in INSIDE.items() if name != "outlier"}  # outliers are nobody's physics
RECIPES = UNLISTED | OTHER_FORMS | LISTED

FAMILIES = ("alone", "pair", "beside", "form", "left_out", "none")
LEAST, MOST = 2.0, 10.0  # RMS of what the base fit leaves, in standard deviations of the readings
SHARES = {"alone": 0.50, "pair": 0.15, "beside": 0.15, "form": 0.20}
"""Of the cases that are neither `left_out` nor `none`."""
SHARE_BIPOD = 0.14
_MOST_OF_TWO = 7.0
_ATTEMPTS, _PATIENCE = 150, 12


@dataclass(frozen=True)
class Order:
    """What a case shall be: its family (see `FAMILIES`), the recipes' names, the robot, the experiment's extent."""

    family: str
    physics: tuple[str, ...]
    robot: str
    extent: Extent = USUAL


def orders(counts: dict[str, int], seed: int, only: Sequence[str] = ()) -> list[Order]:
    """What the cases shall be, in random order. `counts`: cases of each family; `only`: names of recipes."""
    rng = np.random.default_rng([seed, 0])
    strange, forms = (
        in_turn([n for n in names if not only or n in only] or list(names), rng) for names in (UNLISTED, OTHER_FORMS)
    )
    listed, made_for = (
        in_turn([n for n in LISTED if not only or n in only] or list(LISTED), rng),
        in_turn(list(RECIPES), rng),
    )
    found = []
    for family, count in counts.items():
        for _ in range(count):
            physics = _physics(family, strange, forms, listed, made_for, rng)
            able = all(RECIPES[name].planar for name in physics)
            robot = "bipod" if able and rng.random() < SHARE_BIPOD else str(rng.choice(list(HEXAPODS)))
            found.append(Order(family, physics, robot))
    return [found[index] for index in rng.permutation(len(found))]


def _physics(
    family: str,
    strange: Iterator[str],
    forms: Iterator[str],
    listed: Iterator[str],
    made_for: Iterator[str],
    rng: np.random.Generator,
) -> tuple[str, ...]:
    single = {"alone": strange, "form": forms, "left_out": listed, "none": made_for}
    if family in single:
        return (next(single[family]),)
    while True:
        first, second = next(strange), next(strange if family == "pair" else listed)
        fits = RECIPES[first].wishes(rng).compatible(RECIPES[second].wishes(rng))
        if first != second and fits and RECIPES[second].pairs and second != "geometric_stiffness":
            return first, second


def counts_of(count: int, left_out: int, none: int) -> dict[str, int]:
    """Cases of each family: `count` outside the library in the shares of `SHARES`, beside the other two."""
    found = {family: round(count * share) for family, share in SHARES.items()}
    found["alone"] += count - sum(found.values())
    return found | {"left_out": left_out, "none": none}


def drawn(job: tuple[int, int, Order]) -> Case:
    """The case of a seed, a number and an order."""
    seed, number, order = job
    return draw_case(order, np.random.default_rng([seed, number])).numbered(seed, number)


class Bench:
    """The laboratory for one experiment; seen and held-out rows are measured in one go, in the order of time."""

    def __init__(self, experiment: Experiment, rng: np.random.Generator) -> None:
        self.experiment = experiment
        self.whole = pd.concat([experiment.rows.drop(columns="split", errors="ignore"), experiment.later])
        self.whole = self.whole.sort_values("sequence", ignore_index=True)
        self.seen = self.whole["sequence"].isin(experiment.rows["sequence"]).to_numpy()
        robot = experiment.machine.robot
        std = experiment.std[experiment.measured]
        self.fit = BaseFit(robot, experiment.rows, std, experiment.measured, experiment.fitted)
        self.noise = rng.normal(size=(len(self.whole), len(experiment.std))) * experiment.std

    def clean(self, sized: Sized) -> Array:
        """Deflections of all rows without noise."""
        machine = self.experiment.machine
        laboratory = Laboratory(
            Robot.from_mapping(machine.file(sized.softness)),
            true_stiffness=machine.true_stiffness / sized.softness,
            elements=sized.build(),
        )
        measured = laboratory.measure(sized.true_rows(self.whole))
        return measured[deflection_columns(laboratory.robot)].to_numpy(dtype=float)

    def seen_clean(self, sized: Sized) -> Array:
        """Deflections of the seen rows without noise."""
        return self.clean(sized)[self.seen]

    def mismatch(self, sized: Sized) -> float:
        """RMS of what the base fit leaves of the noise-free deflections, in standard deviations."""
        return float(np.sqrt(self.fit.misfit(self.seen_clean(sized)) / self.fit.dof))


def draw_case(
    order: Order, rng: np.random.Generator, arranged: Callable[[Experiment], Experiment] = lambda drawn: drawn
) -> Case:
    """Experiments are drawn until the physics that was ordered shows as it shall; at last on any hexapod.

    `arranged` says which of their series are seen and which are the judge's, where it is not as they were drawn.
    """
    reasons: list[str] = []
    for attempt in range(_ATTEMPTS):
        robot = order.robot if attempt < _PATIENCE else str(rng.choice(list(HEXAPODS)))
        try:
            return _attempt(replace(order, robot=robot), rng, arranged)
        except (UnsuitableError, LaboratoryError) as error:
            reasons.append(str(error))
    raise RuntimeError(f"{order}: no suitable experiment in {_ATTEMPTS}: {sorted(set(reasons))}")


def _attempt(order: Order, rng: np.random.Generator, arranged: Callable[[Experiment], Experiment]) -> Case:
    machine = bipod(rng) if order.robot == "bipod" else HEXAPODS[order.robot](rng)
    recipes, wishes = [RECIPES[name] for name in order.physics], Wishes()
    for recipe in recipes:
        wishes = wishes | recipe.wishes(rng)
    bench = Bench(arranged(draw_interleaved(machine, wishes, rng, order.extent)), rng)
    if bench.fit.condition > 60:
        raise UnsuitableError("the legs' stiffnesses can hardly be told apart")
    hidden = [recipe.hide(bench.experiment, rng) for recipe in recipes]
    if "geometric_stiffness" not in order.physics and bench.mismatch(Sized()) > 0.1:
        raise UnsuitableError("the change of geometry under load shows")
    if order.family == "none":
        return _case(order, bench, [], [], rng)
    most = MOST if len(hidden) == 1 else _MOST_OF_TWO
    sizes = [size_that_shows(bench, each, most, rng) for each in hidden]
    sized = [one.of_size(size) for one, size in zip(hidden, sizes, strict=True)]
    if len(hidden) == 2:
        _told_apart(bench, sized)
    if order.family == "alone" and not _also(order.physics[0]):
        remaining = remaining_misfit(bench.experiment, bench.fit, bench.seen_clean, sized[0])
        if remaining < 5.0 * np.sqrt(2.0 * bench.fit.dof):
            raise UnsuitableError("known physics explains it to within the noise")
    return _case(order, bench, hidden, sizes, rng)


def size_that_shows(bench: Bench, hidden: Hidden, most: float, rng: np.random.Generator) -> float:
    """A size whose mismatch is log-uniform between LEAST and `most`, by secant steps between logarithms."""
    low, high = float(np.log(hidden.low)), float(np.log(hidden.high))

    def shown(at: float) -> float:
        return float(np.log(max(bench.mismatch(hidden.of_size(float(np.exp(at)))), 1e-9)))

    at = (low + high) / 2
    value, slope = shown(at), 1.0
    target = float(rng.uniform(np.log(LEAST), np.log(most)))
    for _ in range(10):
        if abs(value - target) < 0.08:
            break
        following = float(np.clip(at + (target - value) / slope, low, high))
        if following == at:
            break
        reached = shown(following)
        slope = float(np.clip((reached - value) / (following - at), 0.4, 4.0))
        at, value = following, reached
    if not np.log(LEAST) - 0.1 <= value <= np.log(most) + 0.1:
        raise UnsuitableError(f"{hidden.physics} cannot be made to show as much as wanted")
    return float(np.exp(at))


def _told_apart(bench: Bench, sized: Sequence[Sized]) -> None:
    one, other = (bench.fit.residual(bench.seen_clean(each)) for each in sized)
    if abs(float(one @ other)) > 0.8 * float(np.linalg.norm(one) * np.linalg.norm(other)):
        raise UnsuitableError("the two effects look alike")


def _also(physics: str) -> tuple[str, ...]:
    return CATALOGUE[physics].also if physics in CATALOGUE else (physics,)


def _case(
    order: Order, bench: Bench, hidden: Sequence[Hidden], sizes: Sequence[float], rng: np.random.Generator
) -> Case:
    experiment, machine = bench.experiment, bench.experiment.machine
    sized, together = [one.of_size(size) for one, size in zip(hidden, sizes, strict=True)], Sized()
    for each in sized:
        together = together | each
    clean = bench.clean(together)
    recorded: Array = clean + bench.noise
    for element in together.build():
        recorded = element.spoil(recorded, experiment.std, rng)
    listed = [name for name in order.physics if name in LISTED]
    truth = {
        "family": order.family,
        "robot": order.robot,
        "made_for": list(order.physics),
        "without": listed if order.family == "left_out" else [],
        "effects": [
            {
                "physics": one.physics,
                "listed": one.physics in LISTED,
                "parts": list(one.components),
                "names": list(_also(one.physics)),
                "size": size,
                "mismatch_in_std": bench.mismatch(each),
                "elements": [dict(entry) for entry in each.elements],
                "curves": curves(each, experiment),
                "remark": each.remark,
            }
            for one, size, each in zip(hidden, sizes, sized, strict=True)
        ],
        "mismatch_in_std": bench.mismatch(together),
        "true_stiffness": (machine.true_stiffness / together.softness).tolist(),
        "rows": len(experiment.rows),
        "series": int(experiment.rows["series"].nunique()),
    }
    rows = experiment.rows.copy()
    add_bystanders(rows, rng)
    later = experiment.written(experiment.later, recorded[~bench.seen], clean[~bench.seen])
    return Case(machine.file(together.softness), experiment.written(rows, recorded[bench.seen]), later, plain(truth))


def curves(sized: Sized, experiment: Experiment) -> list[dict[str, Any]]:
    """True laws over one scalar, on the range that the seen rows cover: leg, input, inputs and values (SI units)."""
    found = []
    for each in sized.build():
        if not isinstance(each, Unlisted) or each.abscissa not in ("length", "force", "temperature"):
            continue
        stiffness = experiment.machine.true_stiffness / sized.softness
        for index in numbers_of(each.parts[0], len(stiffness)):
            own = {
                "length": lengths(experiment)[:, index],
                "force": experiment.forces[:, index],
                "temperature": experiment.rows.get("temperature_degC", pd.Series([0.0])).to_numpy(dtype=float),
            }[each.abscissa]
            at = np.linspace(float(own.min()), float(own.max()), 41)
            values = [each.curve(float(x), Leg(index, float(stiffness[index]))) for x in at]
            quantity = "elongation_m" if each.abscissa == "force" else "compliance_m_per_N"
            found.append(
                {
                    "component": f"leg {index + 1}",
                    "input": each.abscissa,
                    "quantity": quantity,
                    "inputs": at.tolist(),
                    "values": values,
                }
            )
    return found

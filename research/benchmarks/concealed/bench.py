"""What both sources of cases from the virtual laboratory share: orders, attempts, sizes that show, and truths."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np
import pandas as pd

from research.laboratory import Laboratory, LaboratoryError, Robot
from research.laboratory.recordings import deflection_columns

from .case import Case, UnsuitableError, first_suitable
from .experiments import Experiment, Wishes, add_bystanders
from .hidden import Hidden, Recipe, Sized, plain
from .linear_model import Array, BaseFit
from .mimicry import remaining_misfit
from .robots import HEXAPODS, Machine, bipod

MOST_CONDITION = 60  # of the base fit: the legs' stiffnesses can be told apart
MOST_ALIKE = 0.8  # cosine between what two effects leave in the base fit
_PATIENCE = 12  # attempts with the robot that was ordered


@dataclass(frozen=True)
class Order:
    """What a case shall be: its family, the recipes' names, the robot.

    Where nothing is hidden, `physics` is what the experiment was made for, so that the design of an experiment tells
    nothing.
    """

    family: str
    physics: tuple[str, ...]
    robot: str


def ordered(family: str, recipes: Sequence[Recipe], share_bipod: float, rng: np.random.Generator) -> Order:
    """Recipes on a random robot, a bipod in a share of the cases that are possible with one."""
    able = all(recipe.planar for recipe in recipes)
    robot = "bipod" if able and rng.random() < share_bipod else str(rng.choice(list(HEXAPODS)))
    return Order(family, tuple(recipe.physics for recipe in recipes), robot)


def attempted(order: Order, rng: np.random.Generator, attempt: Callable[[Order], Case], attempts: int) -> Case:
    """Experiments are drawn until the physics that was ordered shows as it shall; at last on any hexapod."""

    def on_a_robot(number: int) -> Case:
        robot = order.robot if number < _PATIENCE else str(rng.choice(list(HEXAPODS)))
        return attempt(replace(order, robot=robot))

    return first_suitable(on_a_robot, attempts, (UnsuitableError, LaboratoryError), str(order))


class Bench:
    """The laboratory for one experiment."""

    def __init__(self, experiment: Experiment) -> None:
        self.experiment = experiment
        robot, std = experiment.machine.robot, experiment.std[experiment.measured]
        self.fit = BaseFit(robot, experiment.rows, std, experiment.measured, experiment.fitted)

    def measured(self, sized: Sized, rows: pd.DataFrame, **noise: Any) -> Array:
        """Deflections of rows, with the options of the laboratory's noise."""
        machine = self.experiment.machine
        robot, stiffness = Robot.from_mapping(machine.file(sized.softness)), machine.true_stiffness / sized.softness
        laboratory = Laboratory(robot, true_stiffness=stiffness, elements=sized.build(), **noise)
        return laboratory.measure(sized.true_rows(rows))[deflection_columns(robot)].to_numpy(dtype=float)

    def seen_clean(self, sized: Sized) -> Array:
        """Deflections of the seen rows without noise."""
        raise NotImplementedError

    def mismatch(self, sized: Sized) -> float:
        """RMS of what the base fit leaves of the noise-free deflections, in standard deviations."""
        return float(np.sqrt(self.fit.misfit(self.seen_clean(sized)) / self.fit.dof))

    def alike(self, sized: Sequence[Sized]) -> float:
        """Cosine between what two effects leave in the base fit, which must not be much."""
        one, other = (self.fit.residual(self.seen_clean(each)) for each in sized)
        cosine = float(abs(one @ other) / np.linalg.norm(one) / np.linalg.norm(other))
        if cosine > MOST_ALIKE:
            raise UnsuitableError("the two effects look alike")
        return cosine

    def beside_known(self, sized: Sized) -> float:
        """Squared misfit that known physics leaves, which must be more than noise."""
        remaining = remaining_misfit(self.experiment, self.fit, self.seen_clean, sized)
        if remaining < 5.0 * np.sqrt(2.0 * self.fit.dof):
            raise UnsuitableError("known physics explains it to within the noise")
        return remaining


AnyBench = TypeVar("AnyBench", bound=Bench)


def prepared(
    order: Order,
    recipes: Sequence[Recipe],
    rng: np.random.Generator,
    bench_of: Callable[[Machine, Wishes], AnyBench],
    curved: Callable[[AnyBench], bool],
) -> tuple[AnyBench, list[Hidden]]:
    """The bench of an experiment that recipes wish for, and what they hide in it.

    `curved` says whether the change of geometry under load shows, which it may only where it is what is hidden.
    """
    machine = bipod(rng) if order.robot == "bipod" else HEXAPODS[order.robot](rng)
    wishes = Wishes()
    for recipe in recipes:
        wishes = wishes | recipe.wishes(rng)
    bench = bench_of(machine, wishes)
    if bench.fit.condition > MOST_CONDITION:
        raise UnsuitableError("the legs' stiffnesses can hardly be told apart")
    hidden = [recipe.hide(bench.experiment, rng) for recipe in recipes]
    if "geometric_stiffness" not in order.physics and curved(bench):
        raise UnsuitableError("the change of geometry under load shows")
    return bench, hidden


def together(each: Sequence[Sized]) -> Sized:
    """All of them at once."""
    whole = Sized()
    for one in each:
        whole = whole | one
    return whole


def case_of(
    order: Order,
    bench: Bench,
    effects: Sequence[dict[str, Any]],
    whole: Sized,
    seen: Array,
    later: tuple[Array, Array],
    rng: np.random.Generator,
    shuffled: float = 0.0,
    **more: Any,
) -> Case:
    """What is written down, and the truth.

    Args:
        order: what was asked for.
        bench: of the experiment.
        effects: the truth of each of them.
        whole: all of them at once.
        seen: deflections of the seen rows as recorded.
        later: those of the held-out rows, as recorded and without noise.
        rng: for what has nothing to do with what is hidden.
        shuffled: share of cases whose rows are in random order.
        more: further entries of the truth.
    """
    experiment, machine = bench.experiment, bench.experiment.machine
    truth = {
        "family": order.family,
        "robot": order.robot,
        "made_for": list(order.physics),
        "without": [],
        "effects": list(effects),
        "mismatch_in_std": bench.mismatch(whole),
        "true_stiffness": (machine.true_stiffness / whole.softness).tolist(),
        "rows": len(experiment.rows),
        "series": int(experiment.rows["series"].nunique()),
        **more,
    }
    rows = experiment.rows.copy()
    add_bystanders(rows, rng)
    recordings = experiment.written(rows, seen)
    if shuffled and rng.random() < shuffled:
        recordings = recordings.iloc[rng.permutation(len(recordings))]
    return Case(machine.file(whole.softness), recordings, experiment.written(experiment.later, *later), plain(truth))


def effect_of(
    hidden: Hidden, size: float, sized: Sized, listed: bool, names: Sequence[str], **more: Any
) -> dict[str, Any]:
    """The truth of one effect; `names`: identifiers of known physics that are no wrong ones for it."""
    return {
        "physics": hidden.physics,
        "listed": listed,
        "parts": list(hidden.components),
        "names": list(names),
        "size": size,
        "elements": [dict(entry) for entry in sized.elements],
        "curves": [],
        "remark": sized.remark,
        **more,
    }

"""One case of physics outside the library: concealed at 2 to 10 standard deviations, its held-out rows inside."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
import pandas as pd

from research.laboratory.elements.unlisted.law import Unlisted
from research.laboratory.legs import Leg

from ..bench import Bench, Order, attempted, case_of, effect_of, ordered, prepared, together
from ..case import Case, Secant, UnsuitableError, in_turn
from ..cases import INSIDE
from ..experiments import Experiment, draw_interleaved
from ..hidden import Hidden, Sized, numbers_of
from ..linear_model import Array
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
_ATTEMPTS, _SECANT = 150, Secant(near=0.08, steps=10)


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
            found.append(ordered(family, [RECIPES[name] for name in physics], SHARE_BIPOD, rng))
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


class WholeBench(Bench):
    """A bench on which seen and held-out rows are measured in one go, in the order of time."""

    def __init__(self, experiment: Experiment, rng: np.random.Generator) -> None:
        super().__init__(experiment)
        self.whole = pd.concat([experiment.rows.drop(columns="split", errors="ignore"), experiment.later])
        self.whole = self.whole.sort_values("sequence", ignore_index=True)
        self.seen = self.whole["sequence"].isin(experiment.rows["sequence"]).to_numpy()
        self.noise = rng.normal(size=(len(self.whole), len(experiment.std))) * experiment.std

    def clean(self, sized: Sized) -> Array:
        """Deflections of all rows without noise."""
        return self.measured(sized, self.whole)

    def seen_clean(self, sized: Sized) -> Array:
        return self.clean(sized)[self.seen]


def draw_case(
    order: Order, rng: np.random.Generator, arranged: Callable[[Experiment], Experiment] = lambda drawn: drawn
) -> Case:
    """One case of an order.

    `arranged` says which of its series are seen and which are the judge's, where it is not as they were drawn.
    """
    return attempted(order, rng, lambda order: _attempt(order, rng, arranged), _ATTEMPTS)


def _attempt(order: Order, rng: np.random.Generator, arranged: Callable[[Experiment], Experiment]) -> Case:
    bench, hidden = prepared(
        order,
        [RECIPES[name] for name in order.physics],
        rng,
        lambda machine, wishes: WholeBench(arranged(draw_interleaved(machine, wishes, rng)), rng),
        lambda bench: bench.mismatch(Sized()) > 0.1,
    )
    if order.family == "none":
        return _case(order, bench, [], [], rng)
    most = MOST if len(hidden) == 1 else _MOST_OF_TWO
    sizes = [size_that_shows(bench, each, most, rng) for each in hidden]
    sized = [one.of_size(size) for one, size in zip(hidden, sizes, strict=True)]
    if len(hidden) == 2:
        bench.alike(sized)
    if order.family == "alone" and not _also(order.physics[0]):
        bench.beside_known(sized[0])
    return _case(order, bench, hidden, sizes, rng)


def size_that_shows(bench: Bench, hidden: Hidden, most: float, rng: np.random.Generator) -> float:
    """A size whose mismatch is log-uniform between LEAST and `most`."""
    low, high = float(np.log(hidden.low)), float(np.log(hidden.high))

    def shown(at: float) -> float:
        return float(np.log(max(bench.mismatch(hidden.of_size(float(np.exp(at)))), 1e-9)))

    middle = (low + high) / 2
    value = shown(middle)
    target = float(rng.uniform(np.log(LEAST), np.log(most)))
    at, value = _SECANT.to(target, shown, (low, high), middle, value)
    if not np.log(LEAST) - 0.1 <= value <= np.log(most) + 0.1:
        raise UnsuitableError(f"{hidden.physics} cannot be made to show as much as wanted")
    return float(np.exp(at))


def _also(physics: str) -> tuple[str, ...]:
    return CATALOGUE[physics].also if physics in CATALOGUE else (physics,)


def _case(
    order: Order, bench: WholeBench, hidden: Sequence[Hidden], sizes: Sequence[float], rng: np.random.Generator
) -> Case:
    experiment, each = bench.experiment, [one.of_size(size) for one, size in zip(hidden, sizes, strict=True)]
    whole = together(each)
    clean = bench.clean(whole)
    recorded: Array = clean + bench.noise
    for element in whole.build():
        recorded = element.spoil(recorded, experiment.std, rng)
    effects = [
        effect_of(
            one, size, sized, one.physics in LISTED, _also(one.physics),
            mismatch_in_std=bench.mismatch(sized), curves=curves(sized, experiment),
        )
        for one, size, sized in zip(hidden, sizes, each, strict=True)
    ]  # fmt: skip
    left_out = [name for name in order.physics if name in LISTED] if order.family == "left_out" else []
    later = recorded[~bench.seen], clean[~bench.seen]
    return case_of(order, bench, effects, whole, recorded[bench.seen], later, rng, without=left_out)


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

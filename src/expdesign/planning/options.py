"""Options of the search for plans: every threshold that it has, with where it comes from."""

from dataclasses import dataclass
from typing import Literal

Effort = Literal["quick", "normal", "thorough"]

EXPECTED_GAIN: dict[Effort, float] = {"quick": 5e-3, "normal": 1e-3, "thorough": 1e-4}
"""Share of the hypervolume (or ten times that of `total`) that a further second of work has to bring."""


@dataclass(frozen=True)
class SearchOptions:
    """How the front is searched.

    `population`, `generations`, `seed`, `polish`, `effort` and `bound_seconds` are keys of a configuration
    (`optimiser`). The others were chosen on sixteen of the configurations of `benchmarks/fronts` by
    `benchmarks/fronts/anytime.py`, where no other source stands; results depend on them little.

    Attributes:
        population: designs that survive from generation to generation, and fewest that a front is thinned to.
        generations: of the search at most; None where only the gain that is expected ends it.
        seed: of all random numbers.
        polish: whether designs descend along exact gradients.
        effort: what a further second of work has to bring (`EXPECTED_GAIN`).
        bound_seconds: of halving boxes for bounds (s of a processor, estimated from the work); 0 leaves it out.
        most_generations: where the configuration names no number, so that every search ends.
        floor: generations after which an operator is asked again whatever it brought (adaptive operator selection with
            a floor for each, Thierens, GECCO 2005).
        memory: weight of the last gain in an operator's average.
        aims: directions of one generation in the space of the objectives, the ends among them.
        children: of an aim in a generation of recombination: along the front, at an end that the convex relaxation
            knows, at another end.
        parents: latest designs among which they are sought, parents of an aim (MOEA/D, Zhang & Li 2007), and the
            difference in an aim below which two designs count as one valley.
        library: measurements of good designs that others are exchanged for.
        pairs: measurements drawn for exchanges of two at once, and how many places of a design are tried.
        drawn: random measurements of which plans are repeated.
        chances: that exchanges for a point along the front also begin at a design drawn at random, and that those for
            an end exchange measurements for their own variants too where variables are continuous.
        draws: random measurements, trials of a design, and how often, where exchanges cannot be judged by sums.
        corrected: designs that are predicted in gaps of the front and then descend.
        roundings: rounds of the relaxation, plans drawn from its weights, and how many of them the search begins with.
        brief: steps of a descent of a new design; a new valley shows after a few.
        along: points along the front from which descents set out, and their steps.
        settled: KKT proximity below which a design is not descended from again (Deb & Abouhawwash 2016).
        gap: share of the hypervolume in the gaps between neighbouring designs at which a front counts as drawn.
        most_designs: of a front.
        enumerable: designs of a finite space that are all looked at.
    """

    population: int = 100
    generations: int | None = None
    seed: int = 1
    polish: bool = True
    effort: Effort = "normal"
    bound_seconds: float = 0.0
    most_generations: int = 2000
    floor: int = 16
    memory: float = 0.5
    aims: int = 12
    children: tuple[int, int, int] = (2, 6, 24)
    parents: tuple[int, int, float] = (4000, 12, 1e-4)
    library: int = 100
    pairs: tuple[int, int] = (150, 3)
    drawn: tuple[int, int] = (500, 60)
    chances: tuple[float, float] = (0.3, 0.5)
    draws: tuple[int, int, int] = (24, 60, 6)
    corrected: int = 40
    roundings: tuple[int, int, int] = (2, 400, 8)
    brief: int = 6
    along: tuple[int, int] = (24, 8)
    settled: float = 1e-4
    gap: float = 1e-3
    most_designs: int = 250
    enumerable: int = 40_000

"""Options of the search for plans: every threshold that it has, with where it comes from."""

from dataclasses import dataclass
from typing import Literal

Effort = Literal["quick", "normal", "thorough"]

EXPECTED_GAIN: dict[Effort, float] = {"quick": 5e-3, "normal": 1e-3, "thorough": 1e-4}
"""Share of the hypervolume (or ten times that of `total`) that a further turn of all operators has to bring."""


@dataclass(frozen=True)
class SearchOptions:
    """How the front is searched.

    `population`, `generations`, `seed`, `polish` and `effort` are keys of a configuration
    (`optimiser`). The others were chosen on sixteen of the configurations of `research/benchmarks/fronts` by
    `research/benchmarks/fronts/anytime.py`, where no other source stands; results depend on them little.

    Attributes:
        population: designs that survive from generation to generation, and fewest that a front is thinned to.
        generations: of the search at most; None where only `effort` ends it.
        seed: of all random numbers.
        polish: whether designs descend along exact gradients.
        effort: what a further turn of all operators has to bring (`EXPECTED_GAIN`).
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
    aims: int = 12
    children: tuple[int, int, int] = (2, 6, 24)
    parents: tuple[int, int, float] = (4000, 12, 1e-4)
    library: int = 100
    pairs: tuple[int, int] = (150, 3)
    drawn: tuple[int, int] = (500, 60)
    chances: tuple[float, float] = (0.3, 0.5)
    draws: tuple[int, int, int] = (24, 60, 6)
    roundings: tuple[int, int, int] = (2, 400, 8)
    brief: int = 6
    along: tuple[int, int] = (24, 8)
    settled: float = 1e-4
    gap: float = 1e-3
    most_designs: int = 250
    enumerable: int = 40_000


@dataclass(frozen=True)
class StartOptions:
    """How the first designs of a search are made (`start`, `sampling`).

    Attributes:
        batch: measurements drawn at a time, and poses on which the robot's limits are tested.
        batches: of them at most until none is known that can be reached.
        ladder: factors s of the load errors, for each of which the relaxation is rounded.
        listed: candidates that are rounded, where variables can be refined afterwards and where they cannot.
        repeated: measurements drawn and paired, and plans of each kind, of repeated measurements.
        structured: plans drawn of every structure that a budget allows, and how many of them are improved.
        tested: random designs on which identifiability is tested.
        together: designs of a finite space that are looked at together.
    """

    batch: int = 2000
    batches: int = 25
    ladder: tuple[float, ...] = (0.0, 10.0)
    listed: tuple[int, int] = (100, 2000)
    repeated: tuple[int, int, int] = (1000, 20, 4)
    structured: tuple[int, int] = (40, 3)
    tested: int = 100
    together: int = 5000


@dataclass(frozen=True)
class ExchangeOptions:
    """How measurements are exchanged (`optimality/exchange`, `operators/exchange`).

    Attributes:
        sweeps: over the measurements of a plan at most.
        together: largest number of entries of the sums that are formed at a time.
        judged: pairs that are judged exactly.
        least: part of DUIR² that remains at least: the linear estimate can be negative.
        near: other measurements of a plan near whose loads one is varied.
        helps: relative gain that counts as one.
        levels: of a discrete variable that are all tried; of more, its neighbours and its ends are.
        poses: drawn at random, and of good designs, to which whole settings are moved.
        kept: share of a plan's measurements that remain where others may take the time of the rest.
    """

    sweeps: int = 8
    together: int = 10_000_000
    judged: int = 60
    least: float = 0.05
    near: int = 8
    helps: float = 1e-9
    levels: int = 6
    poses: int = 40
    kept: float = 0.7


@dataclass(frozen=True)
class NextOptions:
    """How the next measurements are found (`sequential`).

    Attributes:
        candidates: drawn.
        few: parameters up to which as many are drawn; with more, each costs more, and fewer are.
        rounds: of exchange and descent.
        worth: relative gain for which there is a further one.
    """

    candidates: int = 4000
    few: int = 8
    rounds: int = 6
    worth: float = 1e-4


@dataclass(frozen=True)
class DescentOptions:
    """Sequential quadratic programming (`optimality/sqp`, `optimality/quadratic`; Nocedal & Wright 2006).

    Attributes:
        margin: by which rows of limits are kept below zero, so that a design at a limit is within it whatever the
            rounding.
        near_singular: part of the largest condition number from which on it has a gradient.
        difference: step of central differences of limits (m or rad).
        penalty: on the excess over limits, beside functions of the order of 1.
        invalid: value of a function where it has none.
        corrections: of a step that goes beyond curved limits (Maratos effect).
        far: decades of the condition number below its limit at which a step is not corrected for it.
        entries: of the Hessians that are treated at once, at most.
        accepted: part of the predicted fall from which on a step is taken.
        grown: part of the predicted fall, and of the trust radius, beyond which the latter grows, and by which factor.
        shrunk: part of the predicted fall below which the radius becomes a part of the step, and which.
        least_radius: at which a descent ends, in parts of a variable's range.
        iterations: of the interior-point method.
        tolerance: relative duality gap at which a program counts as solved.
        back: part of the way to the nearest bound that a step of it goes.
        worthwhile: part of the programs that are unfinished below which the finished ones are taken out.
    """

    margin: float = 1e-8
    near_singular: float = 0.3
    difference: float = 1e-6
    penalty: float = 10.0
    invalid: float = 1e6
    corrections: int = 2
    far: float = -0.7
    entries: int = 20_000_000
    accepted: float = 1e-3
    grown: tuple[float, float, float] = (0.75, 0.8, 2.0)
    shrunk: tuple[float, float] = (0.25, 0.35)
    least_radius: float = 1e-9
    iterations: int = 40
    tolerance: float = 1e-9
    back: float = 0.995
    worthwhile: float = 0.8


@dataclass(frozen=True)
class RelaxationOptions:
    """The convex relaxation and its bound (`optimality/certificate`, `pool`, `series`, `weights`).

    Attributes:
        gap: relative, of the squared criterion, at which the refinement of candidates ends.
        rounds: of it at most.
        shortlist: candidates that are kept.
        finest: tolerance of the relaxation at which it is not made finer where a round did not improve the bound.
        enumerable: candidates that are all looked at, at most.
        added: most sensitive series that become candidates in a round.
        drawn: series of every length that are drawn first.
        entries: of arrays of series that are valued together.
        tangents: of the bound on longer series (Frank & Wolfe 1956).
        regularisation: part of the mean eigenvalue of an information that is added to all of them: where the optimum
            leaves parameters unidentified that no target needs, Q would hang on weights that count for nothing. The
            bound holds for any Q.
        rounded: share of the largest eigenvalue below which one is rounding.
        weightings: rounds in which candidates enter the optimal weights.
        together: candidates whose sensitivities are computed together.
    """

    gap: float = 1e-3
    rounds: int = 25
    shortlist: int = 2000
    finest: float = 1e-9
    enumerable: int = 1_000_000
    added: int = 40
    drawn: int = 400
    entries: int = 4_000_000
    tangents: int = 60
    regularisation: float = 1e-7
    rounded: float = 1e-14
    weightings: int = 60
    together: int = 50_000


@dataclass(frozen=True)
class AscentOptions:
    """How hard the most sensitive measurement is searched for over a continuum (`optimality/pool`).

    Attributes:
        samples: number of random measurements among the first candidates.
        starts: number of gradient ascents of a round.
        steps: largest number of steps of an ascent.
        passes: largest number of ascents one after the other, each from the best load at the end of the one before.
    """

    samples: int = 6000
    starts: int = 64
    steps: int = 60
    passes: int = 3


START, NEXT, DESCENT = StartOptions(), NextOptions(), DescentOptions()
EXCHANGE = ExchangeOptions()
RELAXATION = RelaxationOptions()
THOROUGH, BRIEF = AscentOptions(), AscentOptions(samples=1000, starts=16, steps=15, passes=1)
"""What commands use."""

"""What an operator of the search is, what it knows, and which is asked next.

A search keeps the designs that no other one dominates, and the best of each criterion (`Archive`). What it has done is
counted so that it does not depend on the machine: evaluations of designs, steps of descents and options of exchanges at
fixed rates in seconds of a processor, fitted to searches of the shipped configurations on a server of 2026. Operators
are asked by what they brought per second of that (adaptive operator selection by adaptive pursuit of the best,
Thierens, GECCO 2005), each at least every so many generations.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Protocol

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.planning.front import hypervolume, non_dominated, reference_point
from expdesign.planning.optimality.exchange import Exchange, exchanges_are_sums
from expdesign.planning.optimality.objectives import Objectives, Pace, descended
from expdesign.planning.options import SearchOptions
from expdesign.planning.problem import DesignProblem
from expdesign.planning.pymoo_problem import DesignPopulation
from expdesign.planning.sampling import extreme_measurements
from expdesign.planning.scalarisation import Aims, along, ends

WEIGHTS = {"total": 10.0, "duir": 1.0}
"""What a share of a criterion's least value counts against the same share of the hypervolume, in which the recommended
plan and the least DUIR hardly show: a search ends where a second brings 0.1 % of the one and 0.01 % of `total`."""


class Archive:
    """Non-dominated designs, without a limit to their number.

    Args:
        shape: m and g of a design.
        objectives: number of criteria that span the front.
        weights: what the share by which each criterion falls counts against the same share of the hypervolume, shape
            (k,); criteria behind the objectives are kept at their least alone.

    Attributes:
        designs: shape (d, m, g).
        values: of the criteria, minimised, shape (d, k).
        objectives: see above.
    """

    def __init__(self, shape: tuple[int, int], objectives: int, weights: FloatArray) -> None:
        self.designs: FloatArray = np.zeros((0, *shape))
        self.values: FloatArray = np.zeros((0, len(weights)))
        self.objectives, self._weights = objectives, weights

    def __len__(self) -> int:
        return len(self.designs)

    @property
    def front(self) -> FloatArray:
        """Objectives (d, k) of the designs."""
        return self.values[:, : self.objectives]

    def add(self, designs: FloatArray, values: FloatArray) -> float:
        """Take designs (b, m, g) with criteria (b, k) into account; the gain that they bring.

        The gain is the share of the hypervolume, and the shares by which the least of each criterion falls by their
        weights; 1 for the first designs.
        """
        if len(designs) == 0:
            return 0.0
        before = self.values
        together, both = np.concatenate([self.designs, designs]), np.concatenate([self.values, values])
        kept = np.concatenate([non_dominated(both[:, : self.objectives]), np.argmin(both, axis=0)])
        kept = np.unique(kept)
        self.designs, self.values = together[kept], both[kept]
        return 1.0 if len(before) == 0 else self._gain(before)

    def _gain(self, before: FloatArray) -> float:
        least, now = before.min(axis=0), self.values.min(axis=0)
        falls = np.clip((least - now) / np.maximum(np.abs(least), 1e-300), 0.0, 1.0)
        gain = float(self._weights @ falls)
        if self.objectives == 1:
            return gain
        point = reference_point(self.front[non_dominated(self.front)])
        volume = hypervolume(self.front, point)
        if volume <= 0.0:
            return gain
        return gain + max(0.0, 1.0 - hypervolume(before[:, : self.objectives], point) / volume)


EVALUATION, OPTION = 5.0e-5, 4.0e-7
"""s of evaluating a measurement of a design, and of an option of an exchange."""
ROUND, STEP, VARIABLE, CUBE = 6.0e-3, 3.0e-5, 3.0e-6, 3.4e-10
"""s of a step of descents together, of one of them, for a variable of it, and for the cube of their number (the
factorisations of its programs)."""
CALL = 0.013
"""s of a generation, whatever its operator does."""


@dataclass
class Work:
    """Counted seconds."""

    seconds: float = 0.0

    def called(self) -> None:
        """An operator."""
        self.seconds += CALL

    def evaluated(self, designs: int, measurements: int) -> None:
        """So many designs of m measurements."""
        self.seconds += EVALUATION * designs * measurements

    def descended(self, rounds: int, steps: int, variables: int) -> None:
        """So many steps together, and of single designs with n free variables."""
        self.seconds += rounds * ROUND + steps * (STEP + VARIABLE * variables + CUBE * variables**3)

    def exchanged(self, options: int) -> None:
        """So many options were judged by their sums."""
        self.seconds += OPTION * options


@dataclass
class Credit:
    """What operators have brought per second of work, and which to ask.

    Attributes:
        count: number of operators.
        floor: generations after which each is asked again.
        memory: weight of the last gain in the average.
    """

    count: int
    floor: int
    memory: float
    rates: list[float] = field(default_factory=list)
    waiting: list[int] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.rates, self.waiting = [np.inf] * self.count, [0] * self.count

    def choose(self) -> int:
        """The operator to ask: one that waited too long, else the one that has brought most."""
        longest = int(np.argmax(self.waiting))
        chosen = longest if self.waiting[longest] >= max(self.floor, self.count) else int(np.argmax(self.rates))
        self.waiting = [0 if index == chosen else waited + 1 for index, waited in enumerate(self.waiting)]
        return chosen

    def learn(self, operator: int, gain: float, seconds: float) -> None:
        """What an operator brought for so much work."""
        rate, before = gain / seconds, self.rates[operator]
        mixed = self.memory * rate + (1.0 - self.memory) * before
        self.rates[operator] = rate if np.isinf(before) else mixed


RELAXED = ("duir", "total")
"""Criteria whose ends designs of the convex relaxation are near."""
USUAL = 8
"""Measurements beyond which fewer designs descend at a time."""


class Operator(Protocol):
    """Makes designs.

    Attributes:
        name: what it does, in a word.
    """

    name: str

    def offspring(self, state: "State") -> FloatArray:
        """New designs (b, m, g), as many as it likes; they need not be within limits."""


@dataclass
class State:
    """What a search knows.

    Attributes:
        population: evaluates designs; its problem has the objectives by which the search goes.
        archive: the designs that are kept.
        generator: of all that is drawn.
        work: what was done so far.
        met: the latest designs (b, m, g) that were feasible, and their criteria (b, k): valleys that others dominate
            today may have the better children.
        library: measurements (l, g) of good designs.
    """

    population: DesignPopulation
    archive: Archive
    generator: np.random.Generator
    work: Work = field(default_factory=Work)
    met: tuple[FloatArray, FloatArray] = field(init=False)
    library: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))

    def __post_init__(self) -> None:
        self.met = self.archive.designs, self.archive.values

    @property
    def problem(self) -> DesignProblem:
        """The design problem."""
        return self.population.design_problem

    @property
    def options(self) -> SearchOptions:
        """Of the search."""
        return self.problem.optimiser

    @property
    def objectives(self) -> Objectives:
        """The objectives and `total`."""
        return self.population.wanted

    @property
    def names(self) -> tuple[str, ...]:
        """Of the criteria."""
        return self.objectives.names

    @cached_property
    def sums(self) -> bool:
        """Whether criteria are sums over measurements, so that exchanges cost little."""
        return exchanges_are_sums(self.problem, self.names)

    @cached_property
    def exchange(self) -> Exchange:
        """Of measurements by sums."""
        return Exchange(self.problem, self.names)

    @cached_property
    def smooth(self) -> bool:
        """Whether designs can descend, and shall."""
        return self.objectives.smooth and self.options.polish

    @cached_property
    def gridded(self) -> bool:
        """Whether steps to neighbours do what gradients do elsewhere."""
        space = self.problem.space
        return bool((space.choices & (space.upper > 1.0)).sum() > 1)

    @cached_property
    def stock(self) -> FloatArray:
        """Measurements (l, g) drawn once, half of their continuous variables at ends."""
        return extreme_measurements(self.problem, self.options.pairs[0], 0.5, self.generator)

    def evaluated(self, designs: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Those of designs (b, m, g) that are feasible, as they can be set, and their criteria (b, k)."""
        designs = self.problem.settable(designs)
        self.work.evaluated(*designs.shape[:2])
        values, violations = self.population.criteria(designs)
        feasible = (violations <= 0.0).all(axis=1)
        return designs[feasible], values[feasible]

    def learn(self, designs: FloatArray, values: FloatArray) -> None:
        """Keep designs (d, m, g) with criteria (d, k), and their measurements; of similar ones the latest."""
        space, kept = self.problem.space, self.options.parents[0]
        before = self.met
        self.met = np.concatenate([before[0], designs])[-kept:], np.concatenate([before[1], values])[-kept:]
        drawn = designs[self.generator.permutation(len(designs))]  # so that all aims have their share
        measured = drawn[space.taken(drawn)]
        if space.settings is not None:
            measured = measured.copy()
            measured[:, space.settings.gene] = space.settings.first
        seen = np.concatenate([measured, self.library.reshape(-1, space.decisions)])
        span = np.where(space.upper > space.lower, space.upper - space.lower, 1.0)
        coarse = np.where(space.discrete, seen, np.round(20.0 * (seen - space.lower) / span))
        first = np.unique(coarse, axis=0, return_index=True)[1]
        self.library = seen[np.sort(first)[: self.options.library]]

    def ends(self) -> Aims:
        """Each criterion alone."""
        return ends(self.archive.values)

    def along(self, count: int) -> Aims:
        """Points along the front, other ones every time, so that nothing falls between them for good."""
        return along(self._front, self.archive.objectives, count, float(self.generator.random()))

    def aims(self, count: int) -> Aims:
        """The ends and points along the front; fewer where designs are large."""
        return self.ends().joined(self.along(max(2, self.scaled(count))))

    def scaled(self, count: int) -> int:
        """So many, or fewer where designs are large, so that a generation stays short."""
        return max(1, round(count * min(1.0, USUAL / self.problem.space.measurements)))

    def children(self, aims: Aims) -> IntArray:
        """How many children each aim has: most have the ends that the convex relaxation knows nothing of.

        Within a budget each has one: more of them find plans that take as long, and exchanges free the time for others.
        """
        if self.problem.budget is not None:
            return np.ones(len(aims), dtype=np.int64)
        along, relaxed, other = (self.scaled(count) for count in self.options.children)
        at_end = np.where(np.isin(self.names, RELAXED), relaxed, other)
        return np.where(aims.single, at_end[np.argmax(aims.weights, axis=1)], along)

    @property
    def _front(self) -> FloatArray:
        values = self.archive.values
        order = np.argsort(values[:, 0], kind="stable")
        return values[order]

    def best(self, aims: Aims) -> FloatArray:
        """The design (b, m, g) of the archive that serves each aim best."""
        chosen: FloatArray = self.archive.designs[aims.scores(self.archive.values).argmin(axis=1)]
        return chosen

    def elite(self, aims: Aims) -> list[FloatArray]:
        """The best designs (d, m, g) of each aim that were met, of distinct valleys."""
        designs, values = self.met
        found = []
        _, number, valley = self.options.parents
        for score in aims.scores(values):
            order = np.argsort(score, kind="stable")
            distinct = np.diff(score[order], prepend=-np.inf) > valley
            found.append(designs[order[distinct][:number]])
        return found

    def descended(self, starts: FloatArray, aims: Aims, steps: int) -> FloatArray:
        """Designs (b, m, g) nearer to their aims than the starts (b, m, g), by gradients; the starts where none are."""
        if not self.smooth or len(starts) == 0:
            return starts
        found, taken = descended(self.objectives, starts, aims, Pace(steps))
        space = self.problem.space
        self.work.descended(steps, taken, space.measurements * int((~space.discrete).sum()))
        return found

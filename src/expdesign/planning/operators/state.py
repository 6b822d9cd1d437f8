"""What a search knows, and what an operator of it is.

An operator proposes designs for directions in the space of the objectives: those of the archive's ends, and points
along its front, other ones every time.
"""

from functools import cached_property
from typing import Protocol

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.planning.optimality.exchange import Exchange, exchanges_are_sums
from expdesign.planning.optimality.objectives import Pace, descended
from expdesign.planning.problem import DesignProblem
from expdesign.planning.pymoo_problem import DesignPopulation
from expdesign.planning.sampling import extreme_measurements
from expdesign.planning.scalarisation import Aims, along, ends

AIMS = 12
"""Directions of a turn in the space of the objectives, the ends among them."""
CHILDREN = 2, 6, 24
"""Of an aim: along the front, at an end that the convex relaxation knows, at another end."""
LIBRARY = 100
"""Measurements of good designs that others are exchanged for."""
BRIEF_STEPS, ALONG_STEPS = 6, 8
"""Of a descent of a new design, where a new valley shows after a few, and of one along the front."""
_MET, _PARENTS, _VALLEY = 4000, 12, 1e-4
"""Latest designs among which parents are sought, parents of an aim (MOEA/D, Zhang & Li 2007), and the difference in an
aim below which two designs count as one valley."""

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

    def propose(self, state: "State") -> FloatArray:
        """New designs (b, m, g), as many as it likes; they need not be within limits."""


class State:
    """What a search knows.

    Args:
        population: evaluates designs; its problem has the objectives by which the search goes.
        generator: of all that is drawn.

    Attributes:
        archive: the designs that are kept.
        objectives: the objectives and `total`.
        names: of these criteria.
        met: the latest designs (b, m, g) that were feasible, and their criteria (b, k): valleys that others dominate
            today may have the better children.
        library: measurements (l, g) of good designs.
    """

    def __init__(self, population: DesignPopulation, generator: np.random.Generator) -> None:
        self.population, self.generator = population, generator
        self.problem: DesignProblem = population.design_problem
        self.archive, self.objectives = population.archive, population.wanted
        self.names = self.objectives.names
        self.met = self.archive.designs, self.archive.values
        self.library: FloatArray = np.zeros((0, self.problem.space.decisions))

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
        return self.objectives.smooth and self.problem.optimiser.polish

    @cached_property
    def gridded(self) -> bool:
        """Whether steps to neighbours do what gradients do elsewhere."""
        space = self.problem.space
        return bool((space.choices & (space.upper > 1.0)).sum() > 1)

    @cached_property
    def stock(self) -> FloatArray:
        """Measurements (l, g) drawn once, half of their continuous variables at ends."""
        return extreme_measurements(self.problem, 150, 0.5, self.generator)

    def learn(self, designs: FloatArray, values: FloatArray) -> None:
        """Keep designs (d, m, g) with criteria (d, k), and their measurements; of similar ones the latest."""
        space = self.problem.space
        before = self.met
        self.met = np.concatenate([before[0], designs])[-_MET:], np.concatenate([before[1], values])[-_MET:]
        drawn = designs[self.generator.permutation(len(designs))]  # so that all aims have their share
        measured = drawn[space.taken(drawn)]
        if space.settings is not None:
            measured = measured.copy()
            measured[:, space.settings.gene] = space.settings.first
        seen = np.concatenate([measured, self.library])
        coarse = np.where(space.discrete, seen, np.round(20.0 * (seen - space.lower) / space.span))
        first = np.unique(coarse, axis=0, return_index=True)[1]
        self.library = seen[np.sort(first)[:LIBRARY]]

    def ends(self) -> Aims:
        """Each criterion alone."""
        return ends(self.archive.values)

    def along(self, count: int) -> Aims:
        """Points along the front, other ones every time, so that nothing falls between them for good."""
        return along(self.archive.values, self.archive.objectives, count, float(self.generator.random()))

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
        along, relaxed, other = (self.scaled(count) for count in CHILDREN)
        at_end = np.where(np.isin(self.names, RELAXED), relaxed, other)
        return np.where(aims.single, at_end[np.argmax(aims.weights, axis=1)], along)

    def best(self, aims: Aims) -> FloatArray:
        """The design (b, m, g) of the archive that serves each aim best."""
        chosen: FloatArray = self.archive.designs[aims.scores(self.archive.values).argmin(axis=1)]
        return chosen

    def elite(self, aims: Aims) -> list[FloatArray]:
        """The best designs (d, m, g) of each aim that were met, of distinct valleys."""
        designs, values = self.met
        found = []
        for score in aims.scores(values):
            order = np.argsort(score, kind="stable")
            distinct = np.diff(score[order], prepend=-np.inf) > _VALLEY
            found.append(designs[order[distinct][:_PARENTS]])
        return found

    def descended(self, starts: FloatArray, aims: Aims, steps: int) -> FloatArray:
        """Designs (b, m, g) nearer to their aims than the starts (b, m, g), by gradients; the starts where none are."""
        if not self.smooth or len(starts) == 0:
            return starts
        return descended(self.objectives, starts, aims, Pace(steps))

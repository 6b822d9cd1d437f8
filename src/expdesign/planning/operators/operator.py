"""What an operator of the search is, and what it knows."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Protocol

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.planning.archive import Archive
from expdesign.planning.optimality.descents import Pace, descended
from expdesign.planning.optimality.exchange import Exchange, exchanges_are_sums
from expdesign.planning.optimality.objectives import Objectives
from expdesign.planning.options import SearchOptions
from expdesign.planning.problem import DesignProblem
from expdesign.planning.pymoo_problem import DesignPopulation
from expdesign.planning.scalarisation import Aims, along, ends
from expdesign.planning.start import extreme_measurements
from expdesign.planning.work import Work

USUAL = 8
"""Measurements beyond which fewer aims are pursued at a time."""


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
        survivors: designs of the present generation (b, m, g) and their criteria (b, k).
        library: measurements (l, g) of good designs.
    """

    population: DesignPopulation
    archive: Archive
    generator: np.random.Generator
    work: Work = field(default_factory=Work)
    survivors: tuple[FloatArray, FloatArray] | None = None
    library: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))

    @property
    def problem(self) -> DesignProblem:
        """The design problem."""
        return self.population.design_problem

    @property
    def options(self) -> SearchOptions:
        """Of the search."""
        return self.problem.optimiser

    @cached_property
    def objectives(self) -> Objectives:
        """The objectives and `total`."""
        return Objectives.with_total(self.problem)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Of the criteria."""
        return tuple(criterion.name for criterion in self.objectives.criteria)

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
        """Whether designs can descend: something is continuous, and exact gradients are wanted and known."""
        space = self.problem.space
        free = bool((~space.discrete & (space.upper > space.lower)).any())
        known = all(criterion.differentiable for criterion in self.objectives.criteria)
        return free and known and self.options.polish and not self.problem.loaded.regressor.redundant

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

    def learn(self, designs: FloatArray) -> None:
        """Keep the measurements of good designs (d, m, g); of similar ones the latest."""
        space = self.problem.space
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
        """The ends and points along the front; fewer where designs are large, so that a generation stays short."""
        return self.ends().joined(self.along(max(2, round(count * min(1.0, USUAL / self.problem.space.measurements)))))

    @property
    def _front(self) -> FloatArray:
        values = self.archive.values
        order = np.argsort(values[:, 0], kind="stable")
        return values[order]

    def best(self, aims: Aims, rank: int = 0) -> FloatArray:
        """The design (b, m, g) of the archive that serves each aim best, or the best but so many."""
        order = np.argsort(aims.scores(self.archive.values), axis=1, kind="stable")
        chosen: FloatArray = self.archive.designs[order[:, min(rank, len(self.archive) - 1)]]
        return chosen

    def elite(self, aims: Aims) -> list[FloatArray]:
        """The best designs (d, m, g) of each aim among survivors and archive, of distinct valleys."""
        designs, values = self.archive.designs, self.archive.values
        if self.survivors is not None:
            designs = np.concatenate([designs, self.survivors[0]])
            values = np.concatenate([values, self.survivors[1]])
        found = []
        for score in aims.scores(values):
            order = np.argsort(score, kind="stable")
            distinct = np.diff(score[order], prepend=-np.inf) > self.options.distinct
            found.append(designs[order[distinct][: self.options.elite]])
        return found

    def descended(self, starts: FloatArray, aims: Aims, steps: int) -> FloatArray:
        """Designs (b, m, g) nearer to their aims than the starts (b, m, g), by gradients; the starts where none are."""
        if not self.smooth or len(starts) == 0:
            return starts
        found, taken = descended(self.objectives, starts, aims, Pace(steps))
        space = self.problem.space
        self.work.descended(taken, space.measurements * int((~space.discrete).sum()))
        return found

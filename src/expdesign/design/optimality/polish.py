"""Gradient refinement of a front (theory.md 6): from good designs to designs that satisfy the optimality conditions.

The designs given are joined by roundings of the convex relaxation (`seeds.py`). Points are laid out evenly along the
front, its ends among them. Each point is pursued along a fixed direction in the space of the objectives,
min max_k (f_k − z_k)/span_k (Pascoletti & Serafini 1984), which reaches convex and concave parts alike, from the best
design known for it and from designs at random; then from designs with measurements replaced (`neighbours.py`,
`breeding.py`), round by round, until a round brings next to nothing. The front is then followed from design to design
(`continuation.py`).
"""

from collections.abc import Callable, Iterator

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.design.front import GAPS, drawn_through, gap_shares, non_dominated, reference_point
from expdesign.design.optimality.breeding import Breeding
from expdesign.design.optimality.continuation import predictions
from expdesign.design.optimality.descents import Pace, descended
from expdesign.design.optimality.kktpm import kktpm
from expdesign.design.optimality.neighbours import Neighbours
from expdesign.design.optimality.objectives import Objectives, achieved
from expdesign.design.optimality.seeds import relaxed_designs
from expdesign.design.parts import Executor, by_halves, one_after_another
from expdesign.design.problem import DesignProblem
from expdesign.design.start import starting_designs

Report = Callable[[str], None]
TARGET = 1e-4
"""KKT proximity at which a design counts as finished."""
GAIN = 5e-4
"""Share of the hypervolume below which a round of exchanges has brought next to nothing."""
RELAXED = ("duir", "total")
"""Criteria whose ends designs of the convex relaxation are near."""
_ALONG, _RESTARTS, _DRAWN, _CAPACITY = 14, 4, 1, 400_000_000
_FIRST, _BRIEF, _LONG = 8, 6, 30
_STARTS, _STAGES, _GOALS, _NEAR, _CHILDREN = 48, (6, 8), 8, 4, 32
_PASSES, _MOST, _CORRECTED, _HOLES, _WIDE = 3, 300, 80, 4, 5e-3
_REPEATED = (6, 1)
"""Designs of repeated measurements for each aim, among the starts and in a round."""
_GENERATIONS, _PATIENCE = 13, 100
"""Generations of the settings that allow one round of exchanges, and one more in succession that brings nothing."""
_QUIET = 4
"""Rounds in succession that bring next to nothing, after which no further one is tried."""


def polish(
    problem: DesignProblem, variables: FloatArray, report: Report = lambda text: None, *, points: int | None = None
) -> FloatArray:
    """Designs that improve a front, to be merged with it.

    Args:
        problem: the design problem.
        variables: feasible designs, e.g. a front, shape (d, m, g).
        report: told in words about each round.
        points: how many designs along the front are wanted; as many as the search's population where left out.

    Returns:
        Designs (d', m, g), within bounds and limits, among them the best for each objective alone and for `total`.
        The same arguments give the same designs.
    """
    polishing = Polishing(problem, points)
    polishing.take(np.concatenate([variables, relaxed_designs(problem)]))
    for number, _ in enumerate(polishing.rounds(), start=1):
        report(f"polish, round {number}: {len(polishing.pool)} designs")
    return polishing.pool if len(polishing.pool) else variables


class Polishing:
    """A pool of designs that is improved round by round.

    Attributes:
        problem: the design problem.
        pool: the designs kept, (d, m, g): those that are not dominated, and the best of each criterion.
        gains: share of the hypervolume that each round of exchanges has brought.
        complete: whether the pool is the front of all designs there are.
    """

    def __init__(
        self, problem: DesignProblem, points: int | None = None, executor: Executor = one_after_another
    ) -> None:
        self.problem, self._executor = problem, executor
        space = problem.space
        # The cost of a step grows with the cube of the number of variables: with very many, few points are pursued, and
        # not to the end.
        self._free = space.measurements * int((~space.discrete).sum())
        self._affordable = max(1, _CAPACITY // max(1, self._free) ** 3)
        self._points = min(points or problem.optimiser.population, self._affordable)
        self._restarts = min(_RESTARTS, max(1, self._affordable // 20))
        self._part = min(1.0, 0.25 * _CAPACITY / max(1, self._free) ** 3)
        self._generator = np.random.default_rng([problem.optimiser.seed, 1])
        self.pool: FloatArray = np.zeros((0, space.measurements, space.decisions))
        self._set(problem)
        self.gains: list[float] = []
        self.complete = False

    def _set(self, problem: DesignProblem) -> None:
        self.problem = problem
        self._parts = self._executor(problem)
        self._objectives = Objectives.with_total(problem)
        self._count = self._objectives.count
        self._values: FloatArray = np.zeros((0, len(self._objectives.criteria)))
        self._neighbours = Neighbours(problem, self._objectives, self._generator, self._parts)
        shape = (problem.space.measurements, problem.space.decisions, len(self._objectives.criteria))
        self._breeding = Breeding(self._neighbours, self._generator, shape)
        if len(self.pool):
            self.take(self.pool)

    def review(self) -> None:
        """Go on with objectives that are right at the present designs (`DesignProblem.working`)."""
        if len(self.pool):
            working = self.problem.working(self.pool)
            if working is not self.problem:
                self._set(working)

    @property
    def front(self) -> FloatArray:
        """Objectives (d, k), minimised, of the pool."""
        return self._values[:, : self._count]

    def take(self, designs: FloatArray) -> float:
        """Add designs (d, m, g); the share of the hypervolume that they bring beside filling gaps (`drawn_through`)."""
        if len(designs) == 0:
            return 0.0
        found, values = self._usable(designs)
        # By chance, so that all aims have their share of what is kept.
        self._neighbours.learn(found[self._generator.permutation(len(found))])
        self._breeding.learn(found, values)
        before = self.front
        pool, values = np.concatenate([self.pool, found]), np.concatenate([self._values, values])
        kept = self._kept(values)
        self.pool, self._values = pool[kept], values[kept]
        if len(before) == 0 or len(self.pool) == 0:
            return 1.0
        point = reference_point(self.front[non_dominated(self.front)])
        now = drawn_through(self.front, point)
        return max(0.0, (now - drawn_through(before, point)) / now) if now > 0.0 else 0.0

    def descend(self, designs: FloatArray) -> float:
        """Let designs (d, m, g) of another search descend by themselves before they compete: designs of a better valley
        may still be worse than refined ones of another. The share of the hypervolume that they bring.
        """
        others, values = self._usable(designs)
        gain = self.take(others)
        if len(others) and self._free:
            centres, weights = self._aims(values, min(self._points, _ALONG))
            found = self._minimise(others[self._starts(values, centres, weights)], centres, weights, 2 * _FIRST)
            gain += self.take(found)
        return gain

    def rounds(self) -> Iterator[None]:
        """All rounds: along the front, exchanges until they bring nothing, refinement, continuation."""
        if len(self.pool) == 0:
            return
        yield from self.exchanges()
        yield from self.finish()

    def valleys(self) -> float:
        """Descents from designs drawn at random towards all aims, of which the better half goes on; what they bring."""
        if not self._free:
            return 0.0
        centres, weights, shares = self._goals()
        aims = self._shared(shares, _STARTS)
        space = self.problem.space
        drawn = starting_designs(self.problem, 2 * len(aims), self._generator)
        designs = self._usable(drawn.reshape(-1, space.measurements, space.decisions))[0][: len(aims)]
        aims = self._generator.permutation(aims)[: len(designs)]
        repeated, of = self._repeated(centres, weights, _REPEATED[0])
        designs, aims = np.concatenate([designs, repeated]), np.concatenate([aims, of])
        gain = self.take(self._anywhere())
        for iterations in _STAGES:
            designs = self._minimise(designs, centres[aims], weights[aims], iterations)
            gain += self.take(designs)
            score = self._achieved(designs, centres[aims], weights[aims])
            better = [own[np.argsort(score[own], kind="stable")[: -(-len(own) // 2)]] for own in _each(aims)]
            kept = np.concatenate(better) if better else np.zeros(0, dtype=np.int64)
            designs, aims = designs[kept], aims[kept]
        return gain

    def _repeated(self, centres: FloatArray, weights: FloatArray, most: int) -> tuple[FloatArray, IntArray]:
        """Designs of repeated measurements near the front, and for which aim each is."""
        return self._neighbours.repeated(centres, weights, self._breeding.least(centres, weights), most)

    def _anywhere(self) -> FloatArray:
        """Designs of a grid or list from which no exchange leads on, for the criteria that no relaxation is of."""
        aims = [k for k, criterion in enumerate(self._objectives.criteria) if criterion.name not in RELAXED]
        centres, weights = (part[:: self._restarts][aims] for part in self._aims(self._values, 0))
        return self._neighbours.anywhere(self._breeding.best(centres, weights), centres, weights)

    def _shared(self, shares: FloatArray, number: int) -> IntArray:
        """Aims of about so many designs, at least one for each aim; fewer where a design is costly."""
        counts = np.ceil(min(number, self._affordable) * shares).astype(np.int64)
        return np.repeat(np.arange(len(shares)), counts)

    def _goals(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Aims: each criterion alone, then along the front; and the share of the effort that each is worth."""
        centres, weights = self._aims(self._values, _GOALS, float(self._generator.random()))
        total = self._values.shape[1]
        singles = self._restarts * total
        keep = np.concatenate([np.arange(0, singles, self._restarts), np.arange(singles, len(centres))])
        shares = np.ones(len(keep))
        shares[:total] = [_NEAR if criterion.name in RELAXED else _GOALS for criterion in self._objectives.criteria]
        return centres[keep], weights[keep], shares / shares.sum()

    def along(self, iterations: int = _FIRST, points: int | None = None) -> float:
        """Pursue the ends, then points along the front from the best designs known for them; what it brings."""
        centres, weights = self._aims(self._values, 0)
        starts = self.pool[self._starts(self._values, centres, weights)]
        gain = self.take(self._minimise(starts, centres, weights, _LONG))
        centres, weights = self._aims(self._values, min(self._points, points or _ALONG))
        singles = self._restarts * self._values.shape[1]
        starts = self.pool[self._starts(self._values, centres, weights)][singles:]
        return gain + self.take(self._minimise(starts, centres[singles:], weights[singles:], iterations))

    def exchanges(self) -> Iterator[None]:
        """Rounds of exchanges and descents, until `_QUIET` of them have brought next to nothing.

        There are at most as many as the search's generations allow, counted over all calls.
        """
        quiet, generations = 0, self.problem.optimiser.generations
        while len(self.gains) < max(2, generations // _GENERATIONS):
            self.gains.append(self._exchange())
            yield
            quiet = quiet + 1 if self.gains[-1] < GAIN else 0
            if quiet >= max(_QUIET, generations // _PATIENCE):
                break

    def _exchange(self) -> float:
        # Other points in every round, so that nothing falls between them for good.
        centres, weights, shares = self._goals()
        aims = self._shared(shares, _CHILDREN)
        designs = self._breeding.children(centres, weights, aims)
        # What a criterion alone is least at, exchanges of single measurements miss most.
        alone = np.flatnonzero((weights[aims] > 0.0).sum(axis=1) == 1)
        designs[alone] = self._neighbours.paired(designs[alone], centres[aims[alone]], weights[aims[alone]])
        # Half of them: what exchanges lead to from many is the same.
        some = np.arange(0, len(designs), 2)
        designs[some] = self._neighbours.improved(designs[some], centres[aims[some]], weights[aims[some]])
        parents = self._breeding.best(centres, weights)
        exchanged, of = self._neighbours.exchanged(parents, centres, weights, _DRAWN)
        repeated, own = self._repeated(centres, weights, _REPEATED[1])
        designs, aims = np.concatenate([designs, exchanged, repeated]), np.concatenate([aims, of, own])
        gain = self.take(designs)
        if self._free:
            gain += self.take(self._minimise(designs, centres[aims], weights[aims], _BRIEF))
        return gain

    def finish(self) -> Iterator[None]:
        """Pursue the points along the front to the end, and follow the front from one to the next."""
        if not self._free or len(self.pool) == 0:
            return
        self.along(2 * _FIRST, max(_ALONG, self._points // 4))
        # What became the worst on the way counts before the front is followed from there.
        self.review()
        yield
        if self._count == 2:
            for _ in range(_PASSES):
                if not self._follow():
                    break
                yield
        self.settle()
        yield

    def missing(self) -> float:
        """Estimated share of the hypervolume that the front lacks: in the gaps between its designs, and in valleys that
        further rounds of exchanges would find, whose gains are taken to go on falling as they fell.
        """
        if self.complete:
            return 0.0
        front = self.front[non_dominated(self.front)]
        gaps = 0.0
        if self._count == 2 and self._free:
            gaps = float(gap_shares(front[np.argsort(front[:, 0])]).sum())
        if len(self.gains) < 2:
            return min(1.0, gaps + sum(self.gains))
        before, last = self.gains[-2:]
        # One round that happens to bring nothing does not say that there is nothing.
        last = max(last, 0.1 * before)
        ratio = min(last / max(before, 1e-300), 0.75)
        return min(1.0, gaps + last * ratio / (1.0 - ratio))

    def _follow(self) -> int:
        """Predict and correct designs in the gaps; how many."""
        found = predictions(self.problem.space, self.pool, self.front, GAPS, min(_MOST, 3 * self._points))
        if len(found):
            self.take(found.designs[found.smooth])
            rough = ~found.smooth if len(found) > _CORRECTED else np.ones(len(found), dtype=bool)
            centres = np.zeros((int(rough.sum()), self._values.shape[1]))
            centres[:, : self._count] = found.aims[rough]
            weights = np.zeros_like(centres)
            weights[:, : self._count] = 1.0 / Objectives.spans(self._values)[: self._count]
            self.take(self._minimise(found.designs[rough], centres, weights, _BRIEF))
            # Across a wide gap from one valley to another it is farther.
            far = np.flatnonzero((~found.smooth & (found.shares > _WIDE))[rough])
            self.take(self._minimise(found.designs[rough][far], centres[far], weights[far], _LONG))
            self._bridge()
        return len(found)

    def _bridge(self) -> None:
        """Let the largest gaps that are left have children of the best designs for their middle."""
        front = self.front[non_dominated(self.front)]
        front = front[np.argsort(front[:, 0], kind="stable")]
        shares = gap_shares(front)
        gaps = np.argsort(-shares, kind="stable")[:_HOLES]
        gaps = gaps[shares[gaps] > 0.1 * GAPS]
        centres = np.zeros((len(gaps), self._values.shape[1]))
        centres[:, :2] = 0.5 * (front[gaps] + front[gaps + 1])
        weights = np.zeros_like(centres)
        weights[:, :2] = 1.0 / Objectives.spans(self._values)[:2]
        aims = np.repeat(np.arange(len(gaps)), _HOLES)
        if aims.size:
            children = self._breeding.children(centres, weights, aims)
            self.take(self._minimise(children, centres[aims], weights[aims], _FIRST))

    def settle(self) -> None:
        """Finish what is still rough or, where the front can do without it, leave it out."""
        earlier, measure = self.pool, kktpm(self.problem, self.pool)
        rough = np.flatnonzero(~(measure <= TARGET))
        space = self.problem.space
        # In coarse steps, or held by other constraints, an optimum does not satisfy the conditions of a continuous one.
        coarse = bool((space.grid.steps > TARGET * (space.upper - space.lower)).any())
        if rough.size == 0 or coarse or self.problem.constraints is not None:
            return
        centres = self._values[rough]
        weights = np.zeros_like(centres)
        weights[:, : self._count] = 1.0 / Objectives.spans(self._values)[: self._count]
        settled = self._minimise(self.pool[rough], centres, weights, _LONG)
        self.take(settled)
        known = {design.tobytes(): value for design, value in zip(earlier, measure, strict=True)}
        new = np.array([design.tobytes() not in known for design in self.pool])
        smooth = np.array([known.get(design.tobytes(), np.inf) <= TARGET for design in self.pool])
        spans = Objectives.spans(self._values)[: self._count]
        smooth[new] = kktpm(self.problem, self.pool[new], spans) <= TARGET
        # Where criteria change much within a step, the design before rounding tells.
        before = {design.tobytes(): place for place, design in enumerate(self.problem.settable(settled))}
        still = [place for place in np.flatnonzero(new & ~smooth) if self.pool[place].tobytes() in before]
        unrounded = settled[[before[self.pool[place].tobytes()] for place in still]]
        smooth[still] = kktpm(self.problem, unrounded, spans) <= TARGET
        smooth[np.argmin(self._values, axis=0)] = True
        self.pool, self._values = self.pool[smooth], self._values[smooth]

    def _usable(self, variables: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Designs that are within the limits and identify everything, and their criteria."""
        variables = self.problem.settable(variables)
        values = self._objectives.values(variables)
        poses, loads = self.problem.space.decode(variables)
        usable = self.problem.loaded.robot.usable(poses).all(axis=1) & np.isfinite(values).all(axis=1)
        constraints = self.problem.constraints
        if constraints is not None:
            usable &= (constraints.violations(self.problem.loaded, poses, loads) <= 0.0).all(axis=1)
        return variables[usable], values[usable]

    def _kept(self, values: FloatArray) -> IntArray:
        """The non-dominated designs, with the best of each criterion even where that one is not an objective."""
        if len(values) == 0:
            return np.zeros(0, dtype=np.int64)
        best = np.argmin(values, axis=0)
        return np.unique(np.concatenate([non_dominated(values[:, : self._count]), best]))

    def _aims(self, values: FloatArray, points: int, shift: float = 0.5) -> tuple[FloatArray, FloatArray]:
        """Centres z and weights (b, k) of the achievement functions: the ends and `total`, then along the front.

        What everything else hangs on, the ends and `total`, is aimed at from several starts.
        """
        total = values.shape[1]
        front = values[non_dominated(values[:, : self._count])]
        span = Objectives.spans(values)
        single = np.repeat(np.eye(total) / span, self._restarts, axis=0)
        centres = np.tile(values.min(axis=0), (len(single), 1))
        if points == 0:
            return centres, single
        along = _spread(front[:, : self._count] / span[: self._count], points, shift) * span[: self._count]
        inner = np.zeros((len(along), total))
        inner[:, : self._count] = along
        weights = np.zeros_like(inner)
        weights[:, : self._count] = 1.0 / span[: self._count]
        return np.concatenate([centres, inner]), np.concatenate([single, weights])

    def _starts(self, values: FloatArray, centres: FloatArray, weights: FloatArray) -> IntArray:
        """For each aim the design of the pool that serves it best; for its repetitions the next best ones."""
        order = np.argsort(achieved(values[None], centres[:, None], weights[:, None]), axis=1, kind="stable")
        place = np.zeros(len(order), dtype=np.int64)
        singles = self._restarts * values.shape[1]
        place[:singles] = np.minimum(np.tile(np.arange(self._restarts), values.shape[1]), len(values) - 1)
        best: IntArray = order[np.arange(len(order)), place]
        return best

    def _achieved(self, designs: FloatArray, centres: FloatArray, weights: FloatArray) -> FloatArray:
        """How far designs (b, m, g) are from their aims, shape (b,); large where they have no values."""
        found = achieved(self._objectives.values(designs), centres, weights)
        return np.where(np.isfinite(found), found, 1e30)

    def _minimise(self, starts: FloatArray, centres: FloatArray, weights: FloatArray, iterations: int) -> FloatArray:
        brief = iterations <= 2 * _FIRST
        steps = max(2, round(self._part * iterations))
        pace = Pace(steps, 1e-6, 1e-4) if brief else Pace(steps, 1e-8, 1e-7)
        return by_halves(self._parts, descended, (starts, centres, weights), (pace,))


def _spread(front: FloatArray, count: int, shift: float) -> FloatArray:
    """Points (count, k) evenly spaced along a front (d, k) of two objectives, the first `shift` of a distance from its
    end; of more objectives, its own points.
    """
    if front.shape[1] != 2 or len(front) == 1:
        order = np.argsort(front[:, 0], kind="stable")
        chosen = np.unique(np.linspace(0, len(front) - 1, min(count, len(front))).round().astype(np.int64))
        return front[order][chosen]
    line = front[np.lexsort((-front[:, 1], front[:, 0]))]
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    at = length[-1] * (np.arange(count) + shift) / count
    return np.stack([np.interp(at, length, line[:, k]) for k in (0, 1)], axis=1)


def _each(aims: IntArray) -> list[IntArray]:
    """The indices of every aim's designs."""
    return [np.flatnonzero(aims == aim) for aim in np.unique(aims)]

"""Designs that differ from given ones in whole measurements: how a search leaves a valley, which gradients cannot.

Which pose or mass comes first, where exactly comes from gradients afterwards. Measurements are exchanged for those that
other good designs have, for some at random, or for themselves with one variable at another of its values: an end of its
range, a neighbour on its grid, another choice, the pose of another measurement of the plan. Where DUIR and FEIR are
sums over measurements (`additive.py`), every exchange is judged, one after the other until none helps (Fedorov 1972),
and of exchanges of two at once the most promising (`pair_exchange.py`); else some of them, drawn at random.
"""

from functools import cached_property
from itertools import pairwise

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.design.optimality.objectives import Objectives, achieved
from expdesign.design.optimality.pair_exchange import exchanged_in_pairs
from expdesign.design.optimality.repetitions import Repetitions, repetitions_count
from expdesign.design.optimality.sum_exchange import exchanged_by_sums, exchanges_are_sums
from expdesign.design.optimality.variants import variants
from expdesign.design.parts import Parts, by_halves, one_after_another
from expdesign.design.problem import DesignProblem
from expdesign.design.start import extreme_measurements, reachable_measurements

_LIBRARY, _RANDOM, _DRAWN, _DRAWS = 100, 24, 60, 6
_STOCK, _OFFERED, _JUDGED, _SOME = 100, 6000, 60_000, 20
_PAIRED, _PLACES = 150, 3
_SHARES, _REPEATED, _NEAR = (0.5, 0.8), (500, 60), 0.25
"""Shares of variables at ends, measurements drawn and paired, and how much farther from an aim repeated ones may be
than the best known, in parts of the front.
"""
_ASKED = (0, 4, 12, 28, _DRAWN)
"""How many draws are asked for costly criteria, the most promising first."""


class Neighbours:
    """Exchanges of measurements, and which of them serve an aim.

    Attributes:
        problem: the design problem.

    Args:
        problem: the design problem.
        objectives: by whose values designs are judged.
        generator: of what is drawn.
        parts: does the exchanges of many designs; here, one after another, where left out.
    """

    def __init__(
        self,
        problem: DesignProblem,
        objectives: Objectives,
        generator: np.random.Generator,
        parts: Parts | None = None,
    ) -> None:
        self.problem, self._objectives, self._generator = problem, objectives, generator
        self._space, self._parts = problem.space, parts or one_after_another(problem)
        self._names = tuple(criterion.name for criterion in objectives.criteria)
        self._sums = exchanges_are_sums(problem, self._names)
        self._draws = problem.noise.shared_reference or problem.constraints is not None or not self._sums
        # On a grid, what gradients do elsewhere is done by steps to neighbours.
        self._gridded = bool((self._space.discrete & (self._space.upper > 1.0)).sum() > 1)
        self._library = np.zeros((0, self._space.decisions))

    def learn(self, designs: FloatArray) -> None:
        """Keep the measurements of good designs (d, m, g); of similar ones the latest."""
        space = self._space
        seen = np.concatenate([designs.reshape(-1, space.decisions), self._library])
        span = np.where(space.upper > space.lower, space.upper - space.lower, 1.0)
        coarse = np.where(space.discrete, seen, np.round(20.0 * (seen - space.lower) / span))
        first = np.unique(coarse, axis=0, return_index=True)[1]
        self._library = seen[np.sort(first)[:_LIBRARY]]

    def exchanged(
        self, parents: FloatArray, centres: FloatArray, weights: FloatArray, drawn: int
    ) -> tuple[FloatArray, IntArray]:
        """Designs (c, m, g) in other valleys than the parents (b, m, g), and for which aim (c,) each is.

        The aims have `centres` and `weights` (b, k). For each aim, exchanges start from its parent and from so many
        designs drawn at random (`drawn`).
        """
        found, aims = [], []
        own = np.arange(len(parents))
        if self._sums and len(self._library):
            offered = self._offered(_STOCK)
            # What everything else hangs on is worth most.
            split = self.problem.noise.shared_reference and not self._gridded
            ends = np.full(len(parents), not split) | ((weights > 0.0).sum(axis=1) == 1)
            for some, loaded in ((own[ends], True), (own[~ends], False)):
                if some.size:
                    starts, aim = parents[some], (centres[some], weights[some])
                    found.append(self._by_sums(offered, starts, *aim, drawn, self._gridded, loaded))
                    aims.append(np.tile(some, 1 + drawn))
        if self._draws:
            found.append(self._by_draws(parents, centres, weights))
            aims.append(own)
        designs, of = np.concatenate(found), np.concatenate(aims)
        changed = (designs != parents[of]).any(axis=(1, 2))
        designs, of = designs[changed], of[changed]
        both = np.concatenate([designs.reshape(len(designs), np.prod(designs.shape[1:])), of[:, None]], axis=1)
        first = np.sort(np.unique(both, axis=0, return_index=True)[1])
        return designs[first], of[first]

    def anywhere(self, parents: FloatArray, centres: FloatArray, weights: FloatArray) -> FloatArray:
        """Designs (b', m, g) of a grid or list at which no exchange with any measurement of many helps, from parents
        (b, m, g) and from designs at random, for aims with `centres` and `weights` (b, k); none for other spaces.
        """
        if not self._sums or not self._gridded:
            return parents[:0]
        listed = self._offered(_OFFERED // self._space.measurements)
        starts = max(1, _JUDGED // (len(parents) * self._space.measurements * len(listed)))
        varied = self.problem.noise.shared_reference
        return self._by_sums(listed, parents, centres, weights, starts, varied)

    def improved(self, designs: FloatArray, centres: FloatArray, weights: FloatArray) -> FloatArray:
        """Designs (b, m, g) of a grid or list after exchanges with own variants and some of the library until none
        helps, for aims with `centres` and `weights` (b, k); of other spaces as they are.
        """
        if not self._sums or not self._gridded or self.problem.noise.shared_reference or len(designs) == 0:
            return designs
        some = self._library[self._generator.permutation(len(self._library))[:_SOME]]
        return self._by_sums(some, designs, centres, weights, 0, True)

    def paired(self, designs: FloatArray, centres: FloatArray, weights: FloatArray) -> FloatArray:
        """Designs (b, m, g) after exchanges of some pairs of their measurements at once, as far as these help, for aims
        with `centres` and `weights` (b, k); as they are where criteria are not sums over measurements.
        """
        m = self._space.measurements
        if not self._sums or self.problem.noise.shared_reference or m < 2 or len(designs) == 0:
            return designs
        places = np.argsort(self._generator.random((len(designs), _PLACES, m)), axis=2)[..., :2]
        offered = np.concatenate([self._library, self._stock])
        return by_halves(self._parts, exchanged_in_pairs, (designs, centres, weights, places), (self._names, offered))

    def repeated(
        self, centres: FloatArray, weights: FloatArray, known: FloatArray, most: int
    ) -> tuple[FloatArray, IntArray]:
        """Designs (d, m, g) of one or two measurements, repeated, that are not much farther from their aims than what
        is known for these, (b,): at most so many for each; and for which aim (d,) each is.
        """
        if not self._sums or not repetitions_count(self.problem):
            return np.zeros((0, self._space.measurements, self._space.decisions)), np.zeros(0, dtype=np.int64)
        share = float(self._generator.choice(_SHARES))
        found = Repetitions(self.problem, self._names, *_REPEATED, share, self._generator)
        designs, aims, scores = found.best(centres, weights, most)
        order = np.lexsort((scores, aims))
        place = np.arange(len(order)) - np.searchsorted(aims[order], aims[order])
        kept = order[(place < most) & (scores[order] < known[aims[order]] + _NEAR)]
        return designs[kept], aims[kept]

    @cached_property
    def _stock(self) -> FloatArray:
        """Measurements (l, g) drawn once, half of their continuous variables at ends."""
        return extreme_measurements(self.problem, _PAIRED, 0.5, self._generator)

    @property
    def discrete(self) -> bool:
        """Whether anything has to be chosen that gradients cannot."""
        return bool(self._space.discrete.any()) or self.problem.noise.shared_reference

    def _by_sums(
        self,
        common: FloatArray,
        parents: FloatArray,
        centres: FloatArray,
        weights: FloatArray,
        drawn: int,
        varied: bool,
        loaded: bool = True,
    ) -> FloatArray:
        """Designs (b·(1 + drawn), m, g) at which no exchange with measurements (l, g) helps, from parents (b, m, g) and
        from as many drawn at random, `drawn` times.
        """
        designs = np.concatenate([parents, common[self._drawn(len(common), drawn * len(parents))]])
        aims = [np.tile(part, (1 + drawn, 1)) for part in (centres, weights)]
        return by_halves(self._parts, exchanged_by_sums, (designs, *aims), (self._names, common, varied, loaded))

    def _drawn(self, listed: int, count: int) -> IntArray:
        """Plans (count, m) of a list's measurements at random, each with one of them repeated none to m times."""
        m = self._space.measurements
        plans = self._generator.integers(listed, size=(count, m))
        repeated = np.arange(m) < self._generator.integers(1, m + 1, size=(count, 1))
        found: IntArray = np.where(repeated, plans[:, :1], plans)
        return found

    def _offered(self, number: int) -> FloatArray:
        """Measurements (l, g) for which any other may be exchanged: the library and, of a grid or list, so many drawn,
        which of many grids is everything.
        """
        if not self._gridded:
            return self._library
        drawn = extreme_measurements(self.problem, number, 1.0, self._generator)
        return np.concatenate([self._library, np.unique(drawn, axis=0)])

    def _by_draws(self, parents: FloatArray, centres: FloatArray, weights: FloatArray) -> FloatArray:
        """Designs (b, m, g) after some exchanges of one measurement, half of them of one variable, each the best of
        some drawn at random. The first exchange may also be for the worse.
        """
        random = reachable_measurements(self.problem, _RANDOM, self._generator)
        common = np.concatenate([self._library, random])
        found, score = self._best_drawn(parents, common, centres, weights)
        moving = np.arange(len(parents))
        for _ in range(_DRAWS if self._gridded else 0):
            tried, reached = self._best_drawn(found[moving], common, centres[moving], weights[moving])
            better = reached < score[moving] - 1e-9 * (1.0 + np.abs(score[moving]))
            moving, tried = moving[better], tried[better]
            found[moving], score[moving] = tried, reached[better]
            if moving.size == 0:
                break
        return found

    def _best_drawn(
        self, parents: FloatArray, common: FloatArray, centres: FloatArray, weights: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """The best of exchanges of designs (b, m, g) that are drawn, and how far they are from their aims, (b,)."""
        batch, m, _ = parents.shape
        draw, own = self._generator.integers, variants(self.problem, parents)
        trials = np.repeat(parents[:, None], _DRAWN, axis=1)
        first, second = np.indices((batch, _DRAWN))
        place = draw(m, size=(batch, _DRAWN))
        varied = own[first, place, draw(own.shape[2], size=(batch, _DRAWN))]
        listed = common[draw(len(common), size=(batch, _DRAWN))]
        if self.problem.noise.shared_reference:
            # Another load at the pose of a measurement that the plan has: they share their reference.
            there = parents[first, draw(m, size=(batch, _DRAWN))]
            listed = np.where(self._space.of_pose & (second % 4 == 1)[..., None], there, listed)
        new = np.where((second % 2 == 0)[..., None], varied, listed)
        if self.problem.noise.shared_reference:
            # Half of the new poses are taken by the whole series, which a single measurement would break up.
            whole = second % 4 >= 2
            trials = self.with_series(trials, place, np.where(whole[..., None], new, parents[first, place]))
        trials[first, second, place] = new
        trials = self._space.canonical(trials)
        same = (trials == parents[:, None]).all(axis=(2, 3))
        score = self._scores(trials, centres, weights, same)
        return trials[np.arange(batch), score.argmin(axis=1)], score.min(axis=1)

    def _scores(self, trials: FloatArray, centres: FloatArray, weights: FloatArray, same: BoolArray) -> FloatArray:
        """How far trials (b, t, m, g) are from their aims, shape (b, t); ∞ for those that are not the best of theirs.

        Criteria that cost little bound the score from below; the others are asked for in the order of these bounds, as
        long as there is a chance (branch and bound). The same trials are chosen as if all were asked for everywhere.
        """
        values = self._objectives.values
        costly = self._objectives.costly
        bounds = values(trials.reshape(-1, *trials.shape[2:]), ~costly).reshape(*trials.shape[:2], -1)
        score = achieved(bounds, centres[:, None], weights[:, None])
        # Where nothing else has weight there is no bound; what has no value is not usable.
        unusable = np.isnan(bounds[..., ~costly]).any(axis=-1) | same
        score[unusable] = np.inf
        asked: BoolArray = np.logical_or.reduce(weights[:, costly] > 0.0, axis=1)
        if not asked.any():
            return score
        order = np.argsort(score, axis=1, kind="stable")
        lower = score.copy()
        score[asked] = np.inf
        for start, end in pairwise(_ASKED):
            places = order[:, start:end]
            chance = np.take_along_axis(lower, places, axis=1) < score.min(axis=1, keepdims=True)
            row, column = np.nonzero(chance & asked[:, None])
            column = places[row, column]
            if len(row):
                found = np.maximum(bounds[row, column], values(trials[row, column], costly))
                reached = achieved(found, centres[row], weights[row])
                score[row, column] = np.where(np.isfinite(reached), reached, np.inf)
        return score

    def with_series(self, designs: FloatArray, place: IntArray, new: FloatArray) -> FloatArray:
        """Designs (..., m, g) whose measurements at the pose of one of them (...) take the pose of others (..., g)."""
        space = self._space
        old = np.take_along_axis(designs, place[..., None, None], axis=-2)
        same = (designs == old)[..., space.of_pose].all(axis=-1)
        moved: FloatArray = np.where(same[..., None] & space.of_pose, new[..., None, :], designs)
        return moved

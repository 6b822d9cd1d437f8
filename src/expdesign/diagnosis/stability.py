"""How often the same effects are named when a tenth of the rows is left out (stability selection).

For every tenth the search is done again on the other nine, forwards, by exchange and backwards, with the same prices,
on the problem linearised at the chosen model: candidates are judged by score tests on the reduced normal equations,

    S = N_ZZ − N_ZP·(N_PP + Λ)⁻¹·N_PZ,

N being the products of all columns over the nine tenths, P the columns that are present and Λ what is known beforehand.
N is summed over the tenths once, so that a refit needs no row. Meinshausen and Bühlmann, Journal of the Royal
Statistical Society B 72 (2010) 417, judge names by such shares; they draw halves.
"""

from collections.abc import Hashable, Sequence, Set
from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular

from expdesign.arrays import FloatArray, IntArray, as_matrix
from expdesign.diagnosis.cross_validation import blocks_of
from expdesign.diagnosis.library import Candidate
from expdesign.diagnosis.options import OPTIONS
from expdesign.diagnosis.sample import Sample
from expdesign.diagnosis.score import Score, reduced_score
from expdesign.diagnosis.selection import Model, Search, hierarchical

_MOST_COLUMNS = 1500
"""Directions of candidates that are considered; beyond, those that explain least beside the base model are not."""
_OWN_COLUMNS = 750
"""The same of the model's own candidates, of whose starts no more are."""
_EXCHANGES = 10


@dataclass(frozen=True)
class Stability:
    """Shares of the refits.

    Attributes:
        refits: their number.
        same: share that names the same effects at the same components, no more and no fewer.
        shares: of each effect of the model, in its order: that it is named.
    """

    refits: int
    same: float
    shares: tuple[float, ...]


@dataclass(frozen=True)
class _Option:
    """A candidate with its columns, start after start."""

    candidate: Candidate
    columns: IntArray
    shapes: int

    def of(self, start: int) -> IntArray:
        """Columns of one start."""
        return self.columns[start]


def stability(search: Search, model: Model) -> Stability | None:
    """Shares of the refits that name the effects of a model; None where it has none, or a tenth holds no row."""
    if not model.candidates:
        return None
    sample = search.sample.restricted(~model.outliers)
    blocks = blocks_of(sample, OPTIONS.refits)
    if len(np.unique(blocks[sample.counts])) < OPTIONS.refits:
        return None
    problem = _Problem(search, model, sample, blocks)
    names = [(c.effect.physics, c.effect.component) for c in model.candidates]
    named = [{(c.effect.physics, c.effect.component) for c in problem.named(tenth)} for tenth in range(OPTIONS.refits)]
    return shares_of(names, named)


def shares_of(names: Sequence[Hashable], refits: Sequence[Set[Hashable]]) -> Stability:
    """Shares of refits that name each of some names, and all of them and no other."""
    shares = tuple(float(np.mean([name in refit for refit in refits])) for name in names)
    return Stability(len(refits), float(np.mean([set(names) == refit for refit in refits])), shares)


class _Problem:
    """The linearised problem: columns of the base model, of all options, and the readings."""

    def __init__(self, search: Search, model: Model, sample: Sample, blocks: IntArray) -> None:
        chain = model.fit.chain
        self.search, self.base = search, chain.base
        slopes = as_matrix(model.fit.sensitivities)
        readings = model.fit.residuals.ravel().copy()
        columns = [slopes[:, : chain.base]]
        self.options: list[_Option] = []
        present = {id(c): part for c, part in zip(model.candidates, chain.slices, strict=True)}
        start = chain.base
        kept = np.repeat(sample.counts, len(sample.recordings.axes))
        # The starts that the model came to are added to its own candidates; of thousands of others a few stand for all.
        every = -(-sum(_width(candidate) for candidate in model.candidates) // _OWN_COLUMNS)
        for candidate in _considered(search, model):
            starts = candidate.directions[::every] if id(candidate) in present else candidate.directions
            directions = starts * kept[:, None]
            free = np.array([not p.shape for p in candidate.effect.parameters])
            if id(candidate) in present:
                own = slopes[:, present[id(candidate)]][:, free]
                away = model.fit.values[present[id(candidate)]] - candidate.effect.neutral()
                readings += own @ away[free]
                directions = np.concatenate([directions, own[None]])
            count, _, width = directions.shape
            numbers = start + np.arange(count * width).reshape(count, width)
            self.options.append(_Option(candidate, numbers, int((~free).sum())))
            columns.append(directions.transpose(1, 0, 2).reshape(len(readings), -1))
            start += count * width
        matrix = np.column_stack([*columns, readings])
        owner = np.repeat(blocks, len(sample.recordings.axes))
        self.products = np.stack([matrix[owner == b].T @ matrix[owner == b] for b in range(OPTIONS.refits)])
        axes = len(sample.recordings.axes)
        self.counts = [axes * int((sample.counts & (blocks == b)).sum()) for b in range(OPTIONS.refits)]
        self._known(model)

    def _known(self, model: Model) -> None:
        """Precisions Λ of all columns, and Λ·(mean − linearised) of the base model's."""
        chain = model.fit.chain
        size = self.products.shape[1] - 1
        self.precision, self.pull = np.zeros(size), np.zeros(size)
        knowledge = chain.knowledge()
        if knowledge is not None:
            base = slice(0, chain.base)
            self.precision[base] = 1.0 / knowledge[1][base] ** 2
            self.pull[base] = self.precision[base] * (knowledge[0] - model.fit.values)[base]
        for option in self.options:
            free = [p for p in option.candidate.effect.parameters if not p.shape]
            self.precision[option.columns] = [1.0 / p.spread**2 for p in free]

    def named(self, tenth: int) -> list[Candidate]:
        """The effects that the rows without one tenth name."""
        gram = self.products.sum(axis=0) - self.products[tenth]
        readings = sum(self.counts) - self.counts[tenth]
        present: dict[int, int] = {}
        while len(present) < self.search.most_effects:
            best = self._best(gram, readings, present)
            if best is None or best[0] < OPTIONS.acceptance:
                break
            present[best[1]] = best[2]
            present = self._pruned(gram, readings, self._exchanged(gram, readings, present))
        return [self.options[i].candidate for i in present]

    def _exchanged(self, gram: FloatArray, readings: int, present: dict[int, int]) -> dict[int, int]:
        for _ in range(_EXCHANGES):
            changed = False
            for index in list(present) if len(present) > 1 else []:
                rest = {i: s for i, s in present.items() if i != index}
                best = self._best(gram, readings, rest)
                if best is not None and best[1] != index:
                    present, changed = {**rest, best[1]: best[2]}, True
                    break
            if not changed:
                break
        return present

    def _pruned(self, gram: FloatArray, readings: int, present: dict[int, int]) -> dict[int, int]:
        for index in list(present):
            rest = {i: s for i, s in present.items() if i != index}
            effects = [self.options[i].candidate.effect for i in rest]
            if hierarchical(effects) and self._gains(gram, readings, rest, [index])[0][0] < 0.0:
                return self._pruned(gram, readings, rest)
        return present

    def _best(self, gram: FloatArray, readings: int, present: dict[int, int]) -> tuple[float, int, int] | None:
        """The largest penalised gain beside some options, of which option, at which of its starts."""
        effects = [self.options[i].candidate.effect for i in present]
        slots = {effect.slot for effect in effects}
        free = [
            i
            for i, option in enumerate(self.options)
            if option.candidate.effect.slot not in slots and hierarchical([*effects, option.candidate.effect])
        ]
        gains = self._gains(gram, readings, present, free)
        return max(((gain, i, start) for i, (gain, start) in zip(free, gains, strict=True)), default=None)

    def _gains(
        self, gram: FloatArray, readings: int, present: dict[int, int], asked: list[int]
    ) -> list[tuple[float, int]]:
        """Fall of the penalised misfit by each option beside some others, and the start that gives it."""
        size = len(self.precision)
        columns = [np.arange(self.base), *(self.options[i].of(start) for i, start in present.items())]
        inside = np.concatenate(columns)
        normal = gram[np.ix_(inside, inside)] + np.diag(self.precision[inside])
        scale = np.sqrt(np.maximum(normal.diagonal(), 1e-300))
        lower = np.linalg.cholesky(normal / np.outer(scale, scale) + 1e-11 * np.eye(len(inside)))
        right = gram[inside].copy()
        right[:, size] += self.pull[inside]
        through = solve_triangular(lower, right / scale[:, None], lower=True)
        slope = gram[:size, size] - through[:, :size].T @ through[:, size]
        before = max(float(gram[size, size] - through[:, size] @ through[:, size]), 1e-300)
        found = []
        for index in asked:
            option = self.options[index]
            own = through[:, option.columns]
            blocks = gram[option.columns[:, :, None], option.columns[:, None, :]]
            reduced = blocks - np.einsum("rgd,rge->gde", own, own)
            whole = np.diagonal(blocks, axis1=1, axis2=2)
            reduced += np.einsum("gd,de->gde", self.precision[option.columns], np.eye(option.columns.shape[1]))
            result = reduced_score(reduced, whole, slope[option.columns], option.candidate.one_sided)
            found.append((self._gain(result, option, before, readings), result.start))
        return found

    def _gain(self, result: Score, option: _Option, before: float, readings: int) -> float:
        fall = result.statistic
        if not self.search.known_noise:
            fall = -readings * float(np.log(max(1.0 - result.statistic / before, 1e-12)))
        price = (result.dimension + option.shapes) * float(np.log(max(readings, 2)))
        return fall - price - self.search.prior_of(option.candidate)


def _considered(search: Search, model: Model) -> list[Candidate]:
    """The model's own candidates, and the others that explain most beside the base model."""
    chosen = list(model.candidates)
    effects = {id(c.effect) for c in chosen}
    width = min(sum(_width(candidate) for candidate in chosen), _OWN_COLUMNS)
    for candidate in search.ranked():
        if id(candidate.effect) in effects:
            continue
        width += _width(candidate)
        if width > _MOST_COLUMNS:
            break
        chosen.append(candidate)
    return chosen


def _width(candidate: Candidate) -> int:
    """Directions of a candidate, of all its starts."""
    return candidate.directions.shape[0] * candidate.directions.shape[2]

"""Selection of the physics that explains a mismatch: score tests, full fits, forwards, backwards and by exchange.

Models are compared by a penalised misfit, χ² + k·ln M + Σ over effects of (2·ln(places) + 2·ln(kinds)): the Bayesian
information criterion for M readings and k parameters beyond the compliances that the recordings determine, with the
prior probability of an effect shared evenly among the kinds of physics, and within a kind among the places at which the
library looks for it. The second part is what controls false discoveries over the whole library: the more places are
searched, the more a find must explain.
"""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, as_matrix
from expdesign.chain.chain import Chain
from expdesign.chain.effect import Effect
from expdesign.diagnosis.base_models import base_model
from expdesign.diagnosis.library import Candidate, beside
from expdesign.diagnosis.options import OPTIONS
from expdesign.diagnosis.outliers import outlier_price, returning_distances, row_distances
from expdesign.diagnosis.sample import Sample
from expdesign.diagnosis.score import orthonormal_basis, score
from expdesign.estimation.fit import Fit, fit
from expdesign.mechanics.robots.robot import Robot

_MOST_KEPT = 300_000_000
"""Bytes of derivatives of models that are kept; beyond, those not asked for longest are fitted anew if needed."""


@dataclass(frozen=True)
class Model:
    """A set of effects, rows set aside as outliers, and the fit.

    Attributes:
        candidates: the effects as found in the library.
        outliers: rows set aside, shape (N,).
        fit: of the rest.
        misfit: penalised, see the module.
    """

    candidates: tuple[Candidate, ...]
    outliers: BoolArray
    fit: Fit
    misfit: float

    @property
    def effects(self) -> tuple[Effect, ...]:
        """The effects."""
        return tuple(candidate.effect for candidate in self.candidates)

    @property
    def keys(self) -> tuple[str, ...]:
        """Identifiers of the effects, sorted."""
        return tuple(sorted(effect.key for effect in self.effects))


@dataclass
class Log:
    """Why each model that was fitted was kept or not, in the order of the search."""

    entries: list[dict[str, object]] = field(default_factory=list)

    def add(self, step: str, model: Model, kept: bool, reason: str) -> None:
        """Note one decision."""
        entry = {
            "step": step,
            "effects": list(model.keys),
            "chi2": model.fit.chi2,
            "penalised_misfit": model.misfit,
            "kept": kept,
            "reason": reason,
        }
        self.entries.append(entry)

    def add_text(self, step: str, reason: str) -> None:
        """Note something that concerns no single model of the library."""
        entry: dict[str, object] = {
            "step": step,
            "effects": [],
            "chi2": None,
            "penalised_misfit": None,
            "kept": True,
            "reason": reason,
        }
        self.entries.append(entry)


class Search:
    """The search for the physics behind one set of recordings.

    Args:
        robot: the robot.
        sample: the rows that may be fitted.
        library: the candidates.
        known_noise: whether residuals are in units of a known standard deviation.
        report: called with a sentence on what is being done.

    Attributes:
        few: effects that are looked for at most, where more are better explained otherwise; None for no such limit.
    """

    def __init__(
        self,
        robot: Robot,
        sample: Sample,
        library: list[Candidate],
        *,
        known_noise: bool,
        report: Callable[[str], None] = lambda text: None,
    ) -> None:
        self.robot = robot
        self.sample = sample
        self.library = library
        self.known_noise = known_noise
        self.report = report
        self.few: int | None = None
        self.log = Log()
        self.models: dict[tuple[tuple[str, ...], bytes], Model] = {}
        self.tried: set[tuple[tuple[str, ...], bytes]] = set()
        self._kept = 0
        self._chains: dict[tuple[str, ...], Chain] = {}
        self._beside_models: dict[tuple[str, ...], Candidate] = {}
        self.base = self._fitted((), np.zeros(len(sample.counts), dtype=bool), [np.zeros(0)])

    def run(self, *, outliers: bool = True) -> Model:
        """The best model found; with no effects where none is worth its parameters.

        Args:
            outliers: whether rows may be set aside.
        """
        current = self.base
        most = self.most_effects if self.few is None else min(self.few, self.most_effects)
        while len(current.candidates) < most:
            self.report(f"looking for effect {len(current.candidates) + 1}")
            grown = self._grow(current, outliers=outliers)
            if grown is None or current.misfit - grown.misfit < OPTIONS.acceptance:
                break
            self.log.add("forward", grown, True, f"misfit falls by {current.misfit - grown.misfit:.1f}")
            current = self._exchange(grown)
            current = self._prune(current)
            current = self._readmit(current)
        return current

    @property
    def most_effects(self) -> int:
        """That are sought beside the base model."""
        return base_model(self.robot, self.sample.reading).most_effects

    def alternatives(self, model: Model) -> list[list[Model]]:
        """For each effect of a model, the models in which another place or physics stands in for it."""
        return [self._replacements(model, index) for index in range(len(model.candidates))]

    def _grow(self, current: Model, *, outliers: bool) -> Model | None:
        """The best model with one more effect, or with rows set aside."""
        options = [self._extended(current, candidate) for candidate in self._promising(current)]
        aside = self._without_outliers(current) if outliers else None
        if aside is not None:
            options.append(aside)
        best = min(options, key=lambda model: model.misfit, default=None)
        for model in options:
            if model is not best:
                self.log.add("forward", model, False, "another effect explains more")
        return best

    def _exchange(self, current: Model) -> Model:
        """Replace effects one at a time by better ones until none is found."""
        if len(current.candidates) < 2:
            return current
        improved = True
        while improved:
            improved = False
            for index in range(len(current.candidates)):
                best = min(self._replacements(current, index), key=lambda model: model.misfit, default=current)
                if best.misfit < current.misfit - 1e-6:
                    self.log.add("exchange", best, True, f"misfit falls by {current.misfit - best.misfit:.1f}")
                    current, improved = best, True
                    break
        return current

    def _prune(self, current: Model) -> Model:
        """Leave out effects that are no longer worth their parameters beside the others."""
        for index in range(len(current.candidates)):
            smaller = self.without(current, index)
            if hierarchical(smaller.effects) and smaller.misfit < current.misfit:
                self.log.add("backward", smaller, True, "the effect left out explains too little beside the others")
                return self._prune(smaller)
        return current

    def _readmit(self, current: Model) -> Model:
        """Take back rows that stood out only while an effect was missing."""
        while current.outliers.any():
            distances = returning_distances(current.fit, self.sample, current.outliers)
            back = current.outliers & (distances < self._outlier_penalty() * self._variance(current))
            if not back.any():
                break
            parts = [self._part(current, c) for c in current.candidates]
            larger = self._model(current.candidates, current.outliers & ~back, parts)
            if larger.misfit >= current.misfit:
                break
            self.log.add("readmit", larger, True, f"{int(back.sum())} rows set aside fit after all")
            current = larger
        return current

    def _variance(self, model: Model) -> float:
        """Of the whitened residuals: 1 where the noise is known."""
        return 1.0 if self.known_noise else max(model.fit.chi2 / max(self.sample.readings, 1), 1e-300)

    def without(self, model: Model, index: int) -> Model:
        """A model refitted without one of its effects."""
        rest = model.candidates[:index] + model.candidates[index + 1 :]
        return self._model(rest, model.outliers, [self._part(model, c) for c in rest])

    def restricted(self, model: Model, keys: Collection[str]) -> Model:
        """A model refitted without the effects of these keys, and those that build on them."""
        for index, effect in enumerate(model.effects):
            rest = [e for e in model.effects if e is not effect]
            if effect.key in keys or not hierarchical([*(e for e in rest if e.key not in keys), effect]):
                return self.restricted(self.without(model, index), keys)
        return model

    def including(self, model: Model) -> Model:
        """A model refitted with the rows that it sets aside."""
        parts = [self._part(model, c) for c in model.candidates]
        return self._model(model.candidates, np.zeros_like(model.outliers), parts)

    def _replacements(self, model: Model, index: int) -> list[Model]:
        smaller = self.without(model, index)
        wanted = OPTIONS.promising * (smaller.misfit - model.misfit)
        grown = [self._extended(smaller, candidate) for candidate in self._promising(smaller, wanted)]
        return [other for other in grown if hierarchical(other.effects)]

    def _promising(self, current: Model, wanted: float = -np.inf) -> list[tuple[Candidate, FloatArray]]:
        """Candidates worth a full fit on top of a model, with the parameters from which to start.

        The best ones are always among them, others only where their score promises a gain of `wanted`.
        """
        basis = orthonormal_basis(as_matrix(current.fit.sensitivities))
        residuals = current.fit.residuals.ravel()
        present = {c.effect.slot for c in current.candidates}
        ranked: list[tuple[float, str, Candidate, FloatArray]] = []
        for entry in self.library:
            if entry.effect.slot in present or not hierarchical([*current.effects, entry.effect]):
                continue
            unseen = entry.idle and len(self.robot.stiffness) == 0
            candidate = self._beside(entry, current) if unseen else entry
            result = score(residuals, basis, candidate.directions, candidate.one_sided)
            free = np.array([not p.shape for p in candidate.effect.parameters])
            gain = result.statistic - self._price(result.dimension + int((~free).sum())) - self.prior_of(candidate)
            start = candidate.starts[result.start].copy()
            # A start away from neutral is one already; others are where the linear effect is largest.
            if np.array_equal(start[free], candidate.effect.neutral()[free]):
                start[free] += result.step
            ranked.append((gain, candidate.effect.key, candidate, start))
        ranked.sort(key=lambda item: (-item[0], item[1]))
        best = self._best_of_each(ranked)
        return [item[2:] for index, item in enumerate(best) if index < OPTIONS.always or item[0] >= wanted]

    def forbid(self, keys: Collection[str]) -> None:
        """Offer these effects no longer."""
        self.library = [candidate for candidate in self.library if candidate.effect.key not in keys]

    def _beside(self, entry: Candidate, current: Model) -> Candidate:
        """An entry that is idle beside the base model, as it acts beside the effects of a model."""
        key = (entry.effect.key, *current.keys)
        if key not in self._beside_models:
            self._beside_models[key] = beside(entry, current.fit, self.sample, self.robot)
        return self._beside_models[key]

    def _best_of_each(
        self, ranked: list[tuple[float, str, Candidate, FloatArray]]
    ) -> list[tuple[float, str, Candidate, FloatArray]]:
        """The best candidates, no more than three per physics so that rival explanations get their fit as well."""
        kept: list[tuple[float, str, Candidate, FloatArray]] = []
        taken: dict[str, int] = {}
        for item in ranked:
            physics = item[2].effect.physics
            if taken.get(physics, 0) < 3:
                kept.append(item)
                taken[physics] = taken.get(physics, 0) + 1
            if len(kept) == OPTIONS.fits_per_step:
                break
        return kept

    def _extended(self, current: Model, item: tuple[Candidate, FloatArray]) -> Model:
        candidate, start = item
        parts = [self._part(current, c) for c in current.candidates]
        return self._model((*current.candidates, candidate), current.outliers, [*parts, start], current)

    def _part(self, model: Model, candidate: Candidate) -> FloatArray:
        """Parameters of one effect of a fitted model."""
        for own, part in zip(model.candidates, model.fit.chain.slices, strict=True):
            if own.effect is candidate.effect:
                return model.fit.values[part]
        raise KeyError(candidate.effect.key)

    def _model(
        self,
        chosen: tuple[Candidate, ...],
        outliers: BoolArray,
        parts: list[FloatArray],
        smaller: Model | None = None,
    ) -> Model:
        key = (tuple(sorted(c.effect.key for c in chosen)), outliers.tobytes())
        if key in self.models:
            self.models[key] = self.models.pop(key)  # asked for last
        else:
            order = sorted(range(len(chosen)), key=lambda i: chosen[i].effect.key)
            sorted_parts = [parts[i] for i in order]
            found = self._fitted(tuple(chosen[i] for i in order), outliers, sorted_parts, smaller)
            self.models[key] = found
            self.tried.add(key)
            self._kept += found.fit.sensitivities.nbytes
            while self._kept > _MOST_KEPT and len(self.models) > 1:
                self._kept -= self.models.pop(next(iter(self.models))).fit.sensitivities.nbytes
        return self.models[key]

    def _fitted(
        self,
        chosen: tuple[Candidate, ...],
        outliers: BoolArray,
        parts: list[FloatArray],
        smaller: Model | None = None,
    ) -> Model:
        names = tuple(c.effect.key for c in chosen)
        if names not in self._chains:
            self._chains[names] = Chain(self.robot, tuple(c.effect for c in chosen), reading=self.sample.reading)
        chain = self._chains[names]
        sample = self.sample.restricted(~outliers)
        own = smaller.fit.values[: chain.base] if smaller is not None else chain.start()[: chain.base]
        result = fit(chain, sample, np.concatenate([own, *parts]) if chosen else None, enough=OPTIONS.settled)
        misfit = self.log_misfit(result.chi2, sample.readings)
        if chosen:
            misfit += self._price(result.rank - self.base.fit.rank) + sum(
                self.prior_of(candidate) for candidate in chosen
            )
        misfit += self._outlier_penalty() * int(outliers.sum())
        return Model(chosen, outliers, result, misfit)

    def log_misfit(self, chi2: float, readings: int) -> float:
        """−2·log likelihood up to a constant: χ², or with an unknown noise level M·ln(χ²/M)."""
        if self.known_noise:
            return chi2
        # Rows set aside must not change the scale of comparison, hence the readings of the whole sample.
        del readings
        return self.sample.readings * float(np.log(max(chi2, 1e-300) / self.sample.readings))

    def _price(self, parameters: int) -> float:
        """Of parameters that the recordings determine."""
        return float(parameters * np.log(max(self.sample.readings, 2)))

    def price(self, candidate: Candidate, readings: int) -> float:
        """Of an effect of which the recordings determine all parameters."""
        return float(len(candidate.effect.parameters) * np.log(max(readings, 2))) + self.prior_of(candidate)

    def prior_of(self, candidate: Candidate) -> float:
        """−2·log of the share of the prior probability that one place of one kind of physics has."""
        return float(2.0 * np.log(candidate.places) + 2.0 * np.log(OPTIONS.kinds))

    def _outlier_penalty(self) -> float:
        """Of one row set aside."""
        axes = len(self.sample.recordings.axes)
        return outlier_price(self.sample.readings, axes, int(self.sample.counts.sum()))

    def _without_outliers(self, current: Model) -> Model | None:
        """The model refitted without the rows that stand out, or None where no row does."""
        flagged = current.outliers.copy()
        model = current
        rows = int(self.sample.counts.sum())
        while int(flagged.sum()) < min(max(1, rows // 10), rows - 1):  # a row to fit has to stay
            distances = row_distances(model.fit)
            distances[flagged] = 0.0
            worst = int(np.argmax(distances))
            if distances[worst] < self._outlier_penalty() * self._variance(model):
                break
            flagged[worst] = True
            parts = [self._part(current, c) for c in current.candidates]
            model = self._model(current.candidates, flagged.copy(), parts, current)
        return model if flagged.any() and not np.array_equal(flagged, current.outliers) else None


def hierarchical(effects: Sequence[Effect]) -> bool:
    """Whether every effect has what it builds on (the principle of heredity of model selection)."""
    slots = {effect.slot for effect in effects}
    return all(not effect.builds_on or (effect.builds_on, effect.component) in slots for effect in effects)

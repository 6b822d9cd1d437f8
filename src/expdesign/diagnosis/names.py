"""Named effects, fitted in full: the models that the search compares, and the problem linear about each of them.

The log evidence of a model is that of its linearisation about the fit (Laplace; `evidence/state`), in which every
effect has a size of its own that maximises it, less the logarithm of the prior probability: shared evenly among the
kinds of physics, and within a kind among the places at which the library looks for it. That is what controls false
discoveries over the whole library: the more places are searched, the more a find must explain. A shape (a pitch, a
time constant) has no size and costs ½·ln M.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.chain.chain import Chain
from expdesign.chain.effect import Effect
from expdesign.chain.recordings.recordings import Remark
from expdesign.diagnosis.base_models import base_model
from expdesign.diagnosis.cross_validation import LeftOut, blocks_of, readings_of
from expdesign.diagnosis.evidence.dictionary import Atom, known_form
from expdesign.diagnosis.evidence.state import Present, linearised
from expdesign.diagnosis.library import Candidate, beside
from expdesign.diagnosis.options import OPTIONS
from expdesign.diagnosis.possible import Confounded, at_limit, confounded_with
from expdesign.diagnosis.remarks import ConfoundedTime
from expdesign.diagnosis.stages import Report, unheard
from expdesign.estimation.fit import Data, Fit, fit
from expdesign.estimation.shared_noise import SharedNoise
from expdesign.mechanics.robots.robot import Robot

_MOST_KEPT = 300_000_000
"""Bytes of derivatives of models that are kept; beyond, those not asked for longest are fitted anew if needed."""
_REACH = 0.5
"""m; what stands on a bench may reach so far without anybody having moved it."""
_STATES = 16
"""Linearised problems that are kept."""


@dataclass(frozen=True)
class NamedModel:
    """A set of effects, and the fit.

    Attributes:
        candidates: the effects as found in the library, in the order of their keys.
        fit: of the rows that count.
        misfit: −2·log of the posterior weight, up to a constant: of evidence and prior, see the module.
    """

    candidates: tuple[Candidate, ...]
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


@dataclass(frozen=True)
class Refused:
    """A model that is not possible.

    Attributes:
        model: the model.
        key: of the effect that was added.
        parameter: that is at a limit; empty where something else explains the effect.
    """

    model: NamedModel
    key: str
    parameter: str


@dataclass
class Log:
    """Why each model that was fitted was kept or not, in the order of the search."""

    entries: list[dict[str, object]] = field(default_factory=list)

    def add(self, step: str, reason: str, model: NamedModel | None = None, *, kept: bool = True) -> None:
        """Note one decision, of a model or of none."""
        entry: dict[str, object] = {
            "step": step,
            "effects": [] if model is None else list(model.keys),
            "chi2": model and model.fit.chi2,
            "penalised_misfit": model and model.misfit,
            "kept": kept,
            "reason": reason,
        }
        self.entries.append(entry)


Beside = tuple[int, FloatArray, float]
"""A law beside named effects, of which a fit of these knows the size alone: number, directions (M, f) and σ²."""


class Names:
    """The named effects that one set of recordings may show, and every model of them that was fitted.

    Args:
        robot: the robot.
        sample: the rows that may be fitted.
        library: the candidates.
        known_noise: whether residuals are in units of a known standard deviation.
        report: progress callback.

    Attributes:
        base: the model without effects.
        tried: keys of all models that were fitted.
        refused: models that are not possible (`possible`).
    """

    def __init__(
        self,
        robot: Robot,
        sample: Data,
        library: list[Candidate],
        *,
        known_noise: bool,
        report: Report = unheard,
    ) -> None:
        self.robot, self.sample, self.library = robot, sample, library
        self.known_noise, self.report = known_noise, report
        self.log = Log()
        self._models: dict[tuple[object, ...], NamedModel] = {}
        self.tried: set[tuple[object, ...]] = set()
        self.refused: list[Refused] = []
        self._kept = 0
        self._chains: dict[tuple[str, ...], Chain] = {}
        self._beside_models: dict[tuple[str, ...], Candidate] = {}
        self._states: dict[int, tuple[NamedModel, Present]] = {}
        self.base = self.model((), [])

    def __getstate__(self) -> dict[str, object]:
        """The progress callback is not copied."""
        return self.__dict__ | {"report": unheard}

    @property
    def models(self) -> list[NamedModel]:
        """Those that were fitted without laws beside them, as far as they are kept."""
        return [model for key, model in self._models.items() if len(key) == 1]

    @cached_property
    def atoms(self) -> list[Atom]:
        """Every start of every candidate as a law of known form."""
        return self._as_laws(self.library)

    @cached_property
    def blocks(self) -> IntArray:
        """Block of every reading that is left out together, shape (M,)."""
        return readings_of(blocks_of(self.sample), self.sample)

    def left_out(self, model: NamedModel) -> LeftOut:
        """Errors of left-out readings by the base model and by another one, both linear about their fits."""
        before, after = (self.state(one).left_out(self.blocks) for one in (self.base, model))
        return LeftOut(before, after, self.blocks)

    @cached_property
    def reach(self) -> float:
        """How far the machine reaches in the recordings (m), at least `_REACH`."""
        return max(
            float(np.linalg.norm(self.robot.position(self.sample.recordings.configurations), axis=-1).max()), _REACH
        )

    @property
    def most_effects(self) -> int:
        """That are sought beside the base model."""
        return base_model(self.robot, self.sample.reading).most_effects

    def idle(self, current: NamedModel) -> list[Atom]:
        """What does nothing to a base model without springs, as it acts beside the effects of a model."""
        idle = [] if len(self.robot.stiffness) else [entry for entry in self.library if entry.idle]
        return self._as_laws([self._beside(entry, current) for entry in idle])

    def fits_beside(self, candidate: Candidate, current: Sequence[Candidate]) -> bool:
        """Whether a candidate may stand beside others: of another slot, with what it builds on."""
        effects = [other.effect for other in current]
        free = candidate.effect.slot not in {effect.slot for effect in effects}
        return free and hierarchical([*effects, candidate.effect])

    @cached_property
    def rival(self) -> Confounded | None:
        """What changed with time, so that it may be behind a drift."""
        return confounded_with(self.sample, self.robot)

    def possible(self, model: NamedModel, added: Candidate, rest: Present) -> bool:
        """Whether a model may be there: no effect at its limit, and the one that was added no drift that imitates.

        Args:
            model: the model.
            added: the candidate that it has beyond `rest`.
            rest: linear about what else is there.
        """
        if any(refused.model is model for refused in self.refused):
            return False
        key, limit = added.effect.key, at_limit(model.fit, self.reach)
        price = self.price(added) + OPTIONS.alarm
        if limit:
            self.log.add("limits", f"{limit} is at or beyond the limit of what a machine can be", model, kept=False)
        elif self.rival and self.rival.explains(model.fit, added.effect, self.sample, rest, price):
            self.log.add("drift", f"`{key}` does not show apart from what changed with time", model, kept=False)
        else:
            return True
        self.refused.append(Refused(model, key, limit))
        return False

    def better_refused(self, model: NamedModel) -> list["Refused"]:
        """What would be chosen in the place of a model if it were possible, the likeliest first."""
        better = [one for one in self.refused if one.model.misfit < model.misfit - 2.0 * OPTIONS.alarm]
        return sorted(better, key=lambda one: one.model.misfit)

    def at_limit(self, model: NamedModel) -> str:
        """The parameter at its limit with which the rows are described better than by a model; empty without one."""
        return next((one.parameter for one in self.better_refused(model) if one.parameter), "")

    def confounded_time(self, model: NamedModel) -> tuple[Remark, ...]:
        """What changed with time, where a drift is in a model, or would be but for that."""
        rival = self.rival
        if rival is None:
            return ()
        imitations = dict.fromkeys(one.key for one in self.better_refused(model) if not one.parameter)
        drifts = [e for e in model.effects if rival.columns(model.fit, e, self.sample) is not None]
        return (ConfoundedTime(rival.name, rival.share, tuple(imitations)),) if imitations or drifts else ()

    def model(
        self,
        chosen: Sequence[Candidate],
        parts: Sequence[FloatArray],
        near: NamedModel | None = None,
        laws: Sequence[Beside] = (),
    ) -> NamedModel:
        """The fit of some effects.

        Args:
            chosen: the effects.
            parts: parameters of each to start from.
            near: a model whose other parameters are near.
            laws: beside them.
        """
        order = sorted(range(len(chosen)), key=lambda i: chosen[i].effect.key)
        own = tuple(chosen[i] for i in order)
        key = (tuple(c.effect.key for c in own), *(number for number, _, _ in laws))
        if key in self._models:
            self._models[key] = self._models.pop(key)  # asked for last
        else:
            found = self._fitted(own, [parts[i] for i in order], near, laws)
            self._models[key] = found
            self.tried.add(key[:1])
            self._kept += found.fit.sensitivities.nbytes
            while self._kept > _MOST_KEPT and len(self._models) > 1:
                self._kept -= self._models.pop(next(iter(self._models))).fit.sensitivities.nbytes
        return self._models[key]

    def state(self, model: NamedModel) -> Present:
        """The problem, linear about a fit, with its effects as laws."""
        if id(model) not in self._states:
            while len(self._states) >= _STATES:
                self._states.pop(next(iter(self._states)))
            state = linearised(model.fit, self.sample, known_noise=self.known_noise, sized=True)
            self._states[id(model)] = model, state.refitted()
        return self._states[id(model)][1]

    def price(self, candidate: Candidate) -> float:
        """Log evidence that an effect has to bring: −ln of its prior, and what its shapes cost."""
        shapes = sum(parameter.shape for parameter in candidate.effect.parameters)
        prior = np.log(candidate.places) + np.log(OPTIONS.kinds)
        return float(prior + 0.5 * shapes * np.log(max(self.sample.readings, 2)))

    def price_of(self, chosen: Sequence[Candidate]) -> float:
        """Log evidence that effects have to bring together."""
        return sum(self.price(c) for c in chosen)

    def without(self, model: NamedModel, index: int) -> NamedModel:
        """A model refitted without one of its effects."""
        rest = model.candidates[:index] + model.candidates[index + 1 :]
        return self.model(rest, self.parts(model, rest), model)

    def of_rows(self, sample: Data) -> "Names":
        """The same effects for some of the rows, with one log."""
        if np.array_equal(sample.counts, self.sample.counts):
            return self
        found = Names(self.robot, sample, self.library, known_noise=self.known_noise, report=self.report)
        found.log, found.tried = self.log, self.tried
        return found

    @staticmethod
    def parts(model: NamedModel, chosen: Sequence[Candidate]) -> list[FloatArray]:
        """Parameters of some effects of a fitted model."""
        known = dict(zip(model.effects, model.fit.chain.slices, strict=True))
        return [model.fit.values[known[candidate.effect]] for candidate in chosen]

    def _as_laws(self, library: Sequence[Candidate]) -> list[Atom]:
        kept = self.sample.kept
        some = None if kept.all() else kept
        atoms = (
            known_form(
                one.effect.component, replace(directions, kept=some), one, start, one_sided=bool(one.one_sided.all())
            )
            for one in library
            for start, directions in zip(one.starts, one.directions, strict=True)
        )
        return [atom for atom in atoms if atom is not None]

    def _beside(self, entry: Candidate, current: NamedModel) -> Candidate:
        """An entry that is idle beside the base model, as it acts beside the effects of a model."""
        key = (entry.effect.key, *current.keys)
        if key not in self._beside_models:
            self._beside_models[key] = beside(entry, current.fit, self.sample, self.robot)
        return self._beside_models[key]

    def _fitted(
        self,
        chosen: tuple[Candidate, ...],
        parts: Sequence[FloatArray],
        near: NamedModel | None,
        laws: Sequence[Beside],
    ) -> NamedModel:
        names = tuple(c.effect.key for c in chosen)
        if names not in self._chains:
            self._chains[names] = self.sample.chain(self.robot, [c.effect for c in chosen])
        chain = self._chains[names]
        sample = self.sample
        if laws:
            columns = np.hstack([law * np.sqrt(variance) for _, law, variance in laws])
            sample = replace(sample, shared=SharedNoise.of(columns))
        own = near.fit.values[: chain.base] if near is not None else chain.start()[: chain.base]
        result = fit(
            chain,
            sample,
            np.concatenate([own, *parts]) if chosen else None,
            enough=OPTIONS.settled,
            rough=0.1 * OPTIONS.settled,
        )
        seen = result.residuals, result.sensitivities
        state = linearised(result, self.sample, known_noise=self.known_noise, sized=True, seen=seen).refitted()
        model = NamedModel(chosen, result, -2.0 * (state.log_evidence - self.price_of(chosen)))
        if not laws:
            self._states[id(model)] = model, state
        return model


def hierarchical(effects: Sequence[Effect]) -> bool:
    """Whether every effect has what it builds on (the principle of heredity of model selection)."""
    slots = {effect.slot for effect in effects}
    return all(not effect.builds_on or (effect.builds_on, effect.component) in slots for effect in effects)

"""All small effects of a machine at once, from the library: the chain, the priors and the groups."""

from collections.abc import Callable, Hashable
from dataclasses import dataclass, replace

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.chain.chain import Chain
from expdesign.chain.component import GEOMETRY, Component, Part
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.ports.curve import Curve, curve_of
from expdesign.chain.ports.dictionary import Atom, Dictionary
from expdesign.chain.ports.everything import (
    BETTER,
    Everything,
    Linearised,
    Priors,
    chosen_groups,
    few_suffice,
    group_gains,
)
from expdesign.chain.ports.found import law_of
from expdesign.chain.ports.law import Law
from expdesign.chain.ports.stable_groups import kept_groups
from expdesign.diagnosis.at_once import AtOnce, GroupAtOnce
from expdesign.diagnosis.cross_validation import blocks_of, readings_of
from expdesign.diagnosis.laws import base_alone, measured_of
from expdesign.diagnosis.library import Candidate
from expdesign.diagnosis.options import OPTIONS
from expdesign.diagnosis.outliers import single_mistakes
from expdesign.diagnosis.sample import Sample
from expdesign.diagnosis.settling import Settling, most_evident, settling
from expdesign.diagnosis.stability import Stability, shares_of
from expdesign.estimation.fit import Fit, fit
from expdesign.mechanics.robots.robot import Robot

_TIMES = 3.0
"""Declared sizes that a dimension may be off by: the groups' own factors are estimated."""
_MOST_TYPICAL, _UNLIKE = 1e3, 10.0
"""Deviations are at most as many typical sizes of a parameter, and as many times the median of its group: parts of one
kind are alike, so that one which hardly shows is not as large as it would have to be to show."""
_EXTRAPOLATED = ("thermal_drift", "joint_backlash", "leg_nonlinear_stiffness")
"""Physics that a block of time that was left out would be extrapolated with, or that is not linear enough."""
_APART = 1.96
"""Standard deviations beyond which a member differs significantly from its prior."""


@dataclass(frozen=True, kw_only=True)
class Group(GroupAtOnce):
    """Effects of one kind.

    Attributes:
        name: physics, and what of it.
        physics: its identifier.
        components: at which it may be.
        factor: on deviations of physical size.
        told_apart: members whose 95 % interval does not include what is known beforehand.
    """

    name: str
    physics: str
    components: tuple[str, ...]
    factor: float
    told_apart: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Many(AtOnce):
    """All effects of a machine; `few` says whether one or two groups predict nearly as well alone."""

    groups: tuple[Group, ...]
    stability: Stability
    few: bool


def many_effects(library: list[Candidate]) -> tuple[Effect, ...]:
    """Effects that may all be there together: linear enough, without memory, each place once."""
    chosen: dict[Hashable, Effect] = {}
    physics = {(c.effect.physics, c.effect.component) for c in library}
    for candidate in library:
        effect = candidate.effect
        if effect.states or any(p.shape for p in effect.parameters) or effect.component.several:
            continue
        if effect.physics in _EXTRAPOLATED:
            continue
        part = effect.component.part in (Part.JOINT, Part.LINK)
        if (effect.physics, GEOMETRY) in physics and part:
            continue
        best = chosen.get(effect.slot)
        if best is None or len(effect.parameters) > len(best.parameters):
            chosen[effect.slot] = effect
    return tuple(chosen.values())


def many_laws(robot: Robot, sample: Sample, base: Fit) -> tuple[Law, ...]:
    """Smooth laws of every port of a joint, of low rank.

    Of sliding joints, whose guides overlap more or less: compliances and motions that change with the place as smoothly
    as the dictionary has them, and motions that follow the moments that the guides carry, with kinks where these change
    sides (Wiener processes). Of revolute joints: what repeats with every turn.
    """
    dictionary = Dictionary(robot, measured_of(sample, known_noise=False), base.values, only=("joints",))
    entries = [(atom, atom.entry) for atom in dictionary.atoms if atom.entry is not None]
    entries = [(atom, e) for atom, e in entries if not e.component.several and len(e.inputs) == 1]
    turning = {entry.component for _, entry in entries if entry.kernel == "periodic"}
    widest: dict[Component, float] = {}
    for _, entry in entries:
        if entry.kernel == "squared_exponential" and entry.inputs[0].kind == "length":
            widest[entry.component] = max(widest.get(entry.component, 0.0), entry.scales[0])
    found: list[Law] = []
    for atom in _guides(dictionary, base, sample):
        zero = np.zeros(atom.width)
        found.append(law_of(atom, 1.0, zero, dictionary.sight, robot, len(found) + 1)[0])
    for atom, entry in entries:
        seen = entry.inputs[0].kind
        smooth = entry.kernel == "squared_exponential" and entry.scales[0] == widest.get(entry.component)
        slides = (smooth and seen == "length") or (entry.kernel == "wiener" and seen == "joint_moment")
        if slides if entry.component not in turning else entry.kernel == "periodic":
            zero = np.zeros(atom.width)
            found.append(law_of(atom, 1.0, zero, dictionary.sight, robot, len(found) + 1)[0])
    return tuple(found)


def _guides(dictionary: Dictionary, base: Fit, sample: Sample) -> list[Atom]:
    """For every sliding joint the law of its guide with the end that alone explains most."""
    kept = np.repeat(sample.counts, len(sample.recordings.axes))
    present = base_alone(base, sample, kept)
    best: dict[Component, tuple[float, Atom]] = {}
    for atom in dictionary.atoms:
        if atom.entry is not None and atom.entry.form == "guide":
            gain = present.gain(atom.directions)[0]
            if gain > best.get(atom.component, (-np.inf, atom))[0]:
                best[atom.component] = gain, atom
    return [atom for _, atom in best.values()]


def start_with_everything(
    robot: Robot, sample: Sample, base: Fit, effects: tuple[Effect, ...], report: Callable[[str], None]
) -> Many:
    """All effects at once, groups that are not there left out, with left-out errors; single mistakes are set aside."""
    report("all effects at once")
    problem = _Problem(sample, Chain(robot, effects, reading=sample.reading), base)
    chosen = problem.chosen(problem.neutral)
    axes = len(sample.recordings.axes)
    rows = np.repeat(np.arange(len(sample.counts)), axes)[problem.kept]
    aside = np.zeros(len(sample.counts), dtype=bool)
    aside[single_mistakes(chosen.found, chosen.priors, rows, axes)] = True
    if aside.any():
        sample = sample.restricted(~aside)
        base = fit(base.chain, sample)
        problem = _Problem(sample, problem.chain, base)
        chosen = problem.chosen(chosen.found.values)
    refits = problem.refits(chosen.found)
    there = tuple(
        e for e, part in zip(effects, problem.chain.slices, strict=True) if (chosen.priors.group[part] >= 0).any()
    )
    if there and len(there) < len(effects):
        start = _restricted(chosen.found.values, problem.chain, there)
        problem = _Problem(sample, Chain(robot, there, reading=sample.reading), base)
        chosen = problem.with_settling(chosen.settled, start)
    found, priors, blocks = chosen.found, chosen.priors, problem.blocks
    alone = _alone(base, problem.kept)
    before = float(np.sqrt((alone.left_out(blocks, _without(base)) ** 2).mean()))
    certain = found.known_as(_released(problem.chain, priors))
    groups = _groups(problem.chain, priors, certain, blocks)
    return Many(
        fit=_as_fit(problem.chain, sample, certain),
        groups=groups, before=before, after=chosen.after(blocks), noise=found.noise, aside=aside,
        stability=shares_of([group.name for group in groups], refits), few=few_suffice(found, priors, blocks),
    )  # fmt: skip


@dataclass(frozen=True)
class _Chosen:
    """Groups that are there, and what series share as noise."""

    found: Everything
    priors: Priors
    settled: Settling

    def after(self, blocks: IntArray) -> float:
        """RMS of left-out readings, in standard deviations as stated."""
        errors = self.settled.unwhitened(self.found.left_out(blocks, self.priors))
        return float(np.sqrt((errors**2).mean()))


class _Problem:
    """All effects of a chain beside its base model's fit, and the readings that count.

    Attributes:
        kept: readings that count among all, shape (N·k,).
        blocks: of every reading that counts, shape (M,).
        neutral: parameters without any effect.
        priors: of all effects.
    """

    def __init__(self, sample: Sample, chain: Chain, base: Fit) -> None:
        self.sample, self.chain, self.base = sample, chain, base
        self.kept = np.repeat(sample.counts, len(sample.recordings.axes))
        self.blocks = readings_of(blocks_of(sample), sample)
        self.neutral = np.concatenate([base.values, *(effect.neutral() for effect in chain.effects)])
        self._residuals, self._slopes = self.linearised(Settling())(self.neutral)
        self.priors = _priors(chain, base, self._slopes)

    def linearised(self, settled: Settling) -> Linearised:
        """Residuals and derivatives, with what series share as a part of the noise."""

        def of(values: FloatArray) -> tuple[FloatArray, FloatArray]:
            residuals, slopes = self.sample.residuals_with_sensitivities(self.chain, values)
            own = slopes.reshape(-1, slopes.shape[-1])[self.kept]
            return settled.whitened(residuals.ravel()[self.kept]), settled.whitened(own)

        return of

    def with_settling(self, settled: Settling, start: FloatArray) -> _Chosen:
        """The groups that are there with such noise."""
        found, priors = chosen_groups(self.linearised(settled), self.priors, start, self.blocks)
        return _Chosen(found, priors, settled)

    def chosen(self, start: FloatArray) -> _Chosen:
        """The groups that are there, the machine having moved between series where left-out series say so."""
        still = self.with_settling(Settling(), start)
        settled = settling(self.chain, self.sample, self.kept, self.base.residuals.ravel()[self.kept], self._slopes)
        readings = self._residuals + self._slopes @ (self.neutral - self.priors.mean)
        settled = most_evident(settled, readings, self._slopes, self.priors)
        if not settled.ratio:
            return still
        moved = self.with_settling(settled, start)
        return moved if moved.after(self.blocks) < BETTER * still.after(self.blocks) else still

    def refits(self, found: Everything) -> list[frozenset[str]]:
        """Names of the groups that nine tenths of the rows keep."""
        parts = readings_of(blocks_of(self.sample, OPTIONS.refits), self.sample)
        every = np.unique(self.priors.group[self.priors.group >= 0]).tolist()
        names = {g: _group_name(self.chain, int(np.flatnonzero(self.priors.group == g)[0])) for g in every}
        kept = kept_groups(found, self.priors, self.blocks, parts)
        return [frozenset(names[g] for g in one) for one in kept]


def _released(chain: Chain, priors: Priors) -> Priors:
    """The same, with what is held because it is confounded as unknown as it is."""
    knowledge = chain.knowledge(released=True)
    if knowledge is None:
        return priors
    base = np.arange(len(priors.mean)) < chain.base
    return replace(priors, deviation=np.where(base, knowledge[1], priors.deviation))


def _restricted(values: FloatArray, chain: Chain, effects: tuple[Effect, ...]) -> FloatArray:
    """The parameters of a chain that those of its effects have which stay."""
    own = [values[part] for e, part in zip(chain.effects, chain.slices, strict=True) if e in effects]
    return np.concatenate([values[: chain.base], *own])


def _groups(chain: Chain, priors: Priors, found: Everything, blocks: IntArray) -> tuple[Group, ...]:
    """What is there, largest first; members that the data tell from zero are listed."""
    names = [""] * chain.base
    kinds: list[tuple[str, Component]] = [("", GEOMETRY)] * chain.base
    for effect in chain.effects:
        names += [f"{p.name} of {effect.component}" for p in effect.parameters]
        kinds += [(effect.physics, effect.component)] * len(effect.parameters)
    deviations = np.sqrt(np.maximum(found.covariance.diagonal(), 0.0))
    groups = []
    for index, p_value in group_gains(found, priors, blocks).items():
        own = np.flatnonzero(priors.group == index)
        moved = found.slopes[:, own] @ (found.values - priors.mean)[own]
        inside = (found.values > priors.low)[own] & (found.values < priors.high)[own]
        away = inside & (np.abs(found.values - priors.mean)[own] > _APART * deviations[own])
        physics = kinds[own[0]][0]
        told = () if physics == "law" else tuple(
            f"{names[i]} {found.values[i]:.3g} ± {_APART * deviations[i]:.1g}" for i in own[away]
        )  # fmt: skip
        components = tuple(dict.fromkeys(str(kinds[i][1]) for i in own))
        size = float(np.sqrt((moved**2).mean()))
        groups.append(
            Group(
                name=_group_name(chain, int(own[0])),
                physics=physics,
                components=components,
                factor=float(found.factors[index]),
                determined=float(found.determined[index]),
                p_value=p_value,
                size=size,
                told_apart=told,
                curve=_curve(chain, int(own[0]), found),
            )
        )
    return tuple(sorted(groups, key=lambda group: -group.size))


def _curve(chain: Chain, index: int, found: Everything) -> Curve | None:
    """The curve of the law of a parameter of the chain; None for effects of known form."""
    for effect, part in zip(chain.effects, chain.slices, strict=True):
        if part.start <= index < part.stop and isinstance(effect, Law):
            seen = np.vstack([effect.form.low[0], effect.form.high[0]])
            return curve_of(
                effect, chain.robot, found.values[: part.stop], found.covariance[: part.stop, : part.stop], part, seen
            )
    return None


def _group_name(chain: Chain, index: int) -> str:
    """Name of the group of a parameter of the chain."""
    for effect, part in zip(chain.effects, chain.slices, strict=True):
        if part.start <= index < part.stop:
            if isinstance(effect, Law):
                if effect.form.kind == "guide":
                    return f"{effect.component}, tilt of its guide"
                seen = "place" if effect.form.depends_on[0].kind == "length" else "moments"
                return f"{effect.component}, {effect.form.kind} of its {seen}"
            parameter = effect.parameters[index - part.start]
            kind = "angles" if parameter.name.endswith("_rad") else "lengths"
            return f"{effect.physics.replace('_', ' ')}" + (f", {kind}" if _made(parameter) else "")
    raise IndexError(index)


def _made(parameter: Parameter) -> bool:
    """Whether it is a dimension, of which it is known how well machines are made."""
    return bool(np.isfinite(parameter.spread)) and parameter.name.endswith(("_rad", "_m"))


def _priors(chain: Chain, base: Fit, slopes: FloatArray) -> Priors:
    """Deviations of physical size: what an effect says of itself, else what would show as much as all that shows."""
    knowledge = chain.knowledge()
    count = len(chain.parameters)
    mean = np.concatenate([base.values[: chain.base], np.zeros(count - chain.base)])
    deviation = np.full(count, np.inf)
    if knowledge is not None:
        mean[: chain.base] = np.where(np.isfinite(knowledge[1]), knowledge[0], mean)[: chain.base]
        deviation[: chain.base] = knowledge[1][: chain.base]
    group = np.full(count, -1, dtype=np.int64)
    names: list[str] = []
    misfit = float(np.sqrt((base.residuals**2).mean()))
    shows = np.sqrt((slopes**2).mean(axis=0))
    for effect, part in zip(chain.effects, chain.slices, strict=True):
        for index, parameter in zip(range(part.start, part.stop), effect.parameters, strict=True):
            mean[index] = parameter.neutral
            name = _group_name(chain, index)
            if name not in names:
                names.append(name)
            group[index] = names.index(name)
            if isinstance(effect, Law):
                deviation[index] = misfit
            elif _made(parameter):
                deviation[index] = _TIMES * effect.size(parameter).value
            else:
                # What does not show at all stays where it is.
                shown = misfit / shows[index] if shows[index] > 0.0 else parameter.scale
                deviation[index] = min(shown, parameter.spread, _MOST_TYPICAL * parameter.scale)
    scales = chain.scales()
    for index in range(len(names)):
        own = group == index
        typical = _UNLIKE * np.median(deviation[own] / scales[own])
        deviation[own] = np.minimum(deviation[own], typical * scales[own])
    return Priors(mean, deviation, group, *chain.bounds())


def _alone(base: Fit, kept: BoolArray) -> Everything:
    slopes = base.sensitivities.reshape(-1, base.sensitivities.shape[-1])[kept]
    return Everything(base.values, base.covariance, np.zeros(1), np.zeros(1), 1.0, base.residuals.ravel()[kept], slopes)


def _without(base: Fit) -> Priors:
    """What is known of the base model alone."""
    knowledge = base.chain.knowledge()
    count = len(base.values)
    deviation = np.full(count, np.inf) if knowledge is None else knowledge[1]
    low, high = base.chain.bounds()
    return Priors(base.values, deviation, np.full(count, -1, dtype=np.int64), low, high)


def _as_fit(chain: Chain, sample: Sample, found: Everything) -> Fit:
    residuals, slopes = sample.residuals_with_sensitivities(chain, found.values)
    rank = round(float(found.determined.sum())) + chain.base
    determined = np.isfinite(found.covariance.diagonal())
    chi2 = float((residuals**2).sum())
    dof = max(sample.readings - rank, 1)
    inflation = found.noise**2
    return Fit(
        chain, found.values, found.covariance, determined, residuals, slopes, chi2, dof, rank, inflation=inflation
    )

"""All small effects of a machine at once, from the library: the chain, the priors and the groups."""

from collections.abc import Callable, Hashable
from dataclasses import dataclass

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.chain.chain import Chain
from expdesign.chain.component import GEOMETRY, Part
from expdesign.chain.effect import Effect
from expdesign.diagnosis.held_out import folds_of
from expdesign.diagnosis.laws import measured_of
from expdesign.diagnosis.library import Candidate
from expdesign.diagnosis.sample import Sample
from expdesign.identification.fit import Fit
from expdesign.ports.dictionary import Dictionary
from expdesign.ports.everything import GONE, Everything, Priors, chosen_groups
from expdesign.ports.found import law_of
from expdesign.ports.law import Law
from expdesign.robots.robot import Robot

_ANGLE, _LENGTH = 0.006, 0.0015
"""rad, m; how well joints are zeroed and links are made, where an effect says what is known of it beforehand."""


@dataclass(frozen=True)
class Group:
    """Effects of one kind, which share a factor.

    Attributes:
        name: physics, and what of it.
        factor: on deviations of physical size.
        determined: how many of its parameters the data determine.
        size: RMS of what it does to the readings, in standard deviations.
    """

    name: str
    factor: float
    determined: float
    size: float


@dataclass(frozen=True)
class Many:
    """All effects together.

    Attributes:
        fit: of the chain with all effects that are there.
        groups: those that are there, largest first.
        before, after: RMS of left-out readings without and with them.
        noise: standard deviation of the whitened residuals.
    """

    fit: Fit
    groups: tuple[Group, ...]
    before: float
    after: float
    noise: float


def many_effects(library: list[Candidate]) -> tuple[Effect, ...]:
    """Effects that may all be there together: linear enough, without memory, each place once."""
    chosen: dict[Hashable, Effect] = {}
    physics = {(c.effect.physics, c.effect.component) for c in library}
    for candidate in library:
        effect = candidate.effect
        if effect.states or any(p.shape for p in effect.parameters) or effect.component.several:
            continue
        part = effect.component.part in (Part.JOINT, Part.LINK)
        if (effect.physics, GEOMETRY) in physics and part:
            continue
        best = chosen.get(effect.slot)
        if best is None or len(effect.parameters) > len(best.parameters):
            chosen[effect.slot] = effect
    return tuple(chosen.values())


def many_laws(robot: Robot, sample: Sample, base: Fit) -> tuple[Law, ...]:
    """Smooth laws of every port of a joint: of where it stands, and of the moment that it carries there."""
    dictionary = Dictionary(robot, measured_of(sample, known_noise=False), base.values, only=("joints", "actuators"))
    found: list[Law] = []
    for atom in dictionary.atoms:
        entry = atom.entry
        assert entry is not None
        if entry.component.several or len(entry.inputs) > 1:
            continue
        spread = dictionary.sight.spread(entry.inputs[0])
        wanted = (entry.form in ("twist", "offset", "compliance") and entry.kernel == "squared_exponential"
                  and np.isclose(entry.scales[0], spread) and entry.inputs[0].kind == "length")  # fmt: skip
        if wanted:
            zero = np.zeros(atom.directions.shape[1])
            found.append(law_of(atom, 1.0, zero, dictionary.sight, robot, len(found) + 1)[0])
    return tuple(found)


def start_with_everything(
    robot: Robot, sample: Sample, base: Fit, effects: tuple[Effect, ...], report: Callable[[str], None]
) -> Many:
    """All effects at once, groups that are not there left out, with left-out errors."""
    report("all effects at once")
    chain = Chain(robot, effects, reading=sample.reading)
    start = np.concatenate([base.values, *(effect.neutral() for effect in effects)])
    kept = np.repeat(sample.counts, len(sample.recordings.axes))
    linearised = _linearised(chain, sample, kept)
    priors, names = _priors(chain, base, linearised(start)[1])
    blocks = _blocks(sample, kept)
    found, priors = chosen_groups(linearised, priors, start, blocks)
    after = float(np.sqrt((found.left_out(blocks, priors) ** 2).mean()))
    alone = _alone(base, kept)
    before = float(np.sqrt((alone.left_out(blocks, _without(base, sample)) ** 2).mean()))
    groups = []
    for index, name in enumerate(names):
        own = priors.group == index
        moved = found.slopes[:, own] @ (found.values - priors.mean)[own]
        if own.any() and found.factors[index] > GONE:
            size = float(np.sqrt((moved**2).mean()))
            groups.append(Group(name, float(found.factors[index]), float(found.determined[index]), size))
    groups.sort(key=lambda group: -group.size)
    return Many(_as_fit(chain, sample, found), tuple(groups), before, after, found.noise)


def _linearised(chain: Chain, sample: Sample, kept: BoolArray) -> Callable[[FloatArray], tuple[FloatArray, FloatArray]]:
    def of(values: FloatArray) -> tuple[FloatArray, FloatArray]:
        residuals, slopes = sample.residuals_with_sensitivities(chain, values)
        return residuals.ravel()[kept], slopes.reshape(-1, slopes.shape[-1])[kept]

    return of


def _priors(chain: Chain, base: Fit, slopes: FloatArray) -> tuple[Priors, list[str]]:
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
            if isinstance(effect, Law):
                name = f"{effect.component}, {effect.form.kind} over its own place"
                if name not in names:
                    names.append(name)
                group[index] = names.index(name)
                deviation[index] = misfit
                continue
            kind = "angles" if parameter.name.endswith("_rad") else "lengths"
            name = f"{effect.physics.replace('_', ' ')}" + (f", {kind}" if np.isfinite(parameter.spread) else "")
            if name not in names:
                names.append(name)
            group[index] = names.index(name)
            if np.isfinite(parameter.spread):
                deviation[index] = _ANGLE if kind == "angles" else _LENGTH
            else:
                # What does not show at all stays where it is.
                deviation[index] = misfit / shows[index] if shows[index] > 0.0 else parameter.scale
    low, high = chain.bounds()
    return Priors(mean, deviation, group, low, high), names


def _alone(base: Fit, kept: BoolArray) -> Everything:
    slopes = base.sensitivities.reshape(-1, base.sensitivities.shape[-1])[kept]
    return Everything(base.values, base.covariance, np.zeros(1), np.zeros(1), 1.0, base.residuals.ravel()[kept], slopes)


def _without(base: Fit, sample: Sample) -> Priors:
    """What is known of the base model alone."""
    knowledge = base.chain.knowledge()
    count = len(base.values)
    deviation = np.full(count, np.inf) if knowledge is None else knowledge[1]
    low, high = base.chain.bounds()
    del sample
    return Priors(base.values, deviation, np.full(count, -1, dtype=np.int64), low, high)


def _blocks(sample: Sample, kept: BoolArray) -> IntArray:
    """Stations or blocks of time that are left out together, of every reading that counts."""
    series = sample.rows.series
    several = len(np.unique(series[sample.counts])) >= 5
    blocks = series if several else folds_of(sample)
    return np.repeat(blocks, len(sample.recordings.axes))[kept]


def _as_fit(chain: Chain, sample: Sample, found: Everything) -> Fit:
    residuals, slopes = sample.residuals_with_sensitivities(chain, found.values)
    rank = round(float(found.determined.sum())) + chain.base
    determined = np.ones(len(found.values), dtype=bool)
    chi2 = float((residuals**2).sum())
    return Fit(
        chain, found.values, found.covariance, determined, residuals, slopes, chi2, max(sample.readings - rank, 1), rank
    )

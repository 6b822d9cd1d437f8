"""All small effects of a machine at once, from the library: the chain, the priors and the groups."""

from collections.abc import Callable, Hashable
from dataclasses import dataclass

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.chain.chain import Chain
from expdesign.chain.component import GEOMETRY, Component, Part
from expdesign.chain.effect import Effect
from expdesign.diagnosis.at_once import AtOnce, GroupAtOnce
from expdesign.diagnosis.held_out import folds_of
from expdesign.diagnosis.laws import base_alone, measured_of
from expdesign.diagnosis.library import Candidate
from expdesign.diagnosis.sample import Sample
from expdesign.diagnosis.stability import Stability, shares_of, tenths
from expdesign.identification.fit import Fit
from expdesign.ports.curve import Curve, curve_of
from expdesign.ports.dictionary import Atom, Dictionary
from expdesign.ports.everything import Everything, Priors, chosen_groups, few_suffice
from expdesign.ports.found import law_of
from expdesign.ports.law import Law
from expdesign.ports.stable_groups import kept_groups
from expdesign.robots.robot import Robot

_ANGLE, _LENGTH = 0.006, 0.0015
"""rad, m; how well joints are zeroed and links are made, where an effect says what is known of it beforehand."""
_EXTRAPOLATED = ("thermal_drift", "joint_backlash", "leg_nonlinear_stiffness")
"""Physics that a block of time that was left out would be extrapolated with, or that is not linear enough."""
_SERIES = 5
"""Series from which the machine may have settled between them, and from which they are left out as wholes."""
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
    """All effects at once, groups that are not there left out, with left-out errors."""
    report("all effects at once")
    chain = Chain(robot, effects, reading=sample.reading)
    kept = np.repeat(sample.counts, len(sample.recordings.axes))
    blocks = _blocks(sample, kept)
    start = np.concatenate([base.values, *(effect.neutral() for effect in effects)])
    settling = _settling(chain, sample, kept)
    start = np.concatenate([start, np.zeros(settling.count)])
    linearised = _linearised(chain, sample, kept, settling)
    every = _priors(chain, base, linearised(start)[1])
    found, priors = chosen_groups(linearised, every, start, blocks)
    refits = _refits(chain, every, kept_groups(found, every, blocks, _parts(sample, kept)))
    there = tuple(e for e, part in zip(chain.effects, chain.slices, strict=True) if (priors.group[part] >= 0).any())
    if there and len(there) < len(effects):
        start = np.concatenate([_restricted(found.values, chain, there), found.values[len(chain.parameters) :]])
        chain = Chain(robot, there, reading=sample.reading)
        linearised = _linearised(chain, sample, kept, settling)
        neutral = np.concatenate([base.values, *(effect.neutral() for effect in there), np.zeros(settling.count)])
        priors = _priors(chain, base, linearised(neutral)[1])
        found, priors = chosen_groups(linearised, priors, start, blocks)
    after = float(np.sqrt((found.left_out(blocks, priors) ** 2).mean()))
    alone = _alone(base, kept)
    before = float(np.sqrt((alone.left_out(blocks, _without(base)) ** 2).mean()))
    few = few_suffice(found, priors, blocks)
    groups = _groups(chain, priors, found)
    stable = shares_of([group.name for group in groups], refits)
    return Many(
        fit=_as_fit(chain, sample, found), groups=groups, before=before, after=after, noise=found.noise,
        stability=stable, few=few,
    )  # fmt: skip


def _parts(sample: Sample, kept: BoolArray) -> IntArray:
    """The tenth of every reading that counts."""
    return np.repeat(tenths(sample), len(sample.recordings.axes))[kept]


def _refits(chain: Chain, priors: Priors, groups: list[frozenset[int]]) -> list[frozenset[str]]:
    """Names of the groups that every refit keeps; those of settling have none."""
    first = {int(g): int(np.flatnonzero(priors.group == g)[0]) for g in np.unique(priors.group[priors.group >= 0])}
    names = {g: _group_name(chain, index) for g, index in first.items() if index < len(chain.parameters)}
    return [frozenset(names[g] for g in one if g in names) for one in groups]


def _restricted(values: FloatArray, chain: Chain, effects: tuple[Effect, ...]) -> FloatArray:
    """The parameters of a chain that those of its effects have which stay."""
    own = [values[part] for e, part in zip(chain.effects, chain.slices, strict=True) if e in effects]
    return np.concatenate([values[: chain.base], *own])


def _groups(chain: Chain, priors: Priors, found: Everything) -> tuple[Group, ...]:
    """What is there, largest first; members that the data tell from zero are listed."""
    names = [""] * chain.base
    kinds: list[tuple[str, Component]] = [("", GEOMETRY)] * chain.base
    for effect in chain.effects:
        names += [f"{p.name} of {effect.component}" for p in effect.parameters]
        kinds += [(effect.physics, effect.component)] * len(effect.parameters)
    deviations = np.sqrt(np.maximum(found.covariance.diagonal(), 0.0))
    groups = []
    for index in np.unique(priors.group[priors.group >= 0]):
        own = np.flatnonzero(priors.group == index)
        if own[0] >= len(chain.parameters):
            continue
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
            return f"{effect.physics.replace('_', ' ')}" + (f", {kind}" if np.isfinite(parameter.spread) else "")
    raise IndexError(index)


@dataclass(frozen=True)
class _Settling:
    """Motion of the whole machine against the instrument from one series to the next, besides all effects.

    It predicts nothing, but without it whatever moves whole series would be laid to effects that happen to differ
    between them. Its parameters come after those of the chain, per series as many as the instrument's pose has.

    Attributes:
        pose: indices of the instrument's pose among the parameters of the chain.
        inside: rows of readings of every series, shape (K, M).
    """

    pose: IntArray
    inside: BoolArray

    @property
    def count(self) -> int:
        return len(self.pose) * len(self.inside)

    def directions(self, slopes: FloatArray) -> FloatArray:
        """Shape (M, count)."""
        return np.hstack([slopes[:, self.pose] * own[:, None] for own in self.inside] or [slopes[:, :0]])


def _settling(chain: Chain, sample: Sample, kept: BoolArray) -> _Settling:
    names = [parameter.name for parameter in chain.parameters[: chain.base]]
    pose = np.array([i for i, name in enumerate(names) if name.startswith("instrument ")], dtype=np.int64)
    series = np.repeat(sample.rows.series, len(sample.recordings.axes))[kept]
    numbers = np.unique(series)
    if len(numbers) < _SERIES:
        numbers = numbers[:0]
    return _Settling(pose, series == numbers[:, None])


def _linearised(
    chain: Chain, sample: Sample, kept: BoolArray, settling: _Settling
) -> Callable[[FloatArray], tuple[FloatArray, FloatArray]]:
    count = len(chain.parameters)

    def of(values: FloatArray) -> tuple[FloatArray, FloatArray]:
        residuals, slopes = sample.residuals_with_sensitivities(chain, values[:count])
        own = slopes.reshape(-1, slopes.shape[-1])[kept]
        moved = settling.directions(own)
        return residuals.ravel()[kept] - moved @ values[count:], np.hstack([own, moved])

    return of


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
                continue
            kind = "angles" if parameter.name.endswith("_rad") else "lengths"
            if np.isfinite(parameter.spread):
                deviation[index] = _ANGLE if kind == "angles" else _LENGTH
            else:
                # What does not show at all stays where it is.
                deviation[index] = misfit / shows[index] if shows[index] > 0.0 else parameter.scale
    low, high = chain.bounds()
    more = slopes.shape[1] - count
    free = np.full(more, np.inf)
    settling = misfit / np.maximum(shows[count:], 1e-9 * shows.max())
    return Priors(
        np.concatenate([mean, np.zeros(more)]),
        np.concatenate([deviation, settling]),
        np.concatenate([group, np.full(more, len(names))]),
        np.concatenate([low, -free]),
        np.concatenate([high, free]),
    )


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


def _blocks(sample: Sample, kept: BoolArray) -> IntArray:
    """Stations or blocks of time that are left out together, of every reading that counts."""
    series = sample.rows.series
    several = len(np.unique(series[sample.counts])) >= _SERIES
    blocks = series if several else folds_of(sample)
    return np.repeat(blocks, len(sample.recordings.axes))[kept]


def _as_fit(chain: Chain, sample: Sample, found: Everything) -> Fit:
    count = len(chain.parameters)
    values, covariance = found.values[:count], found.covariance[:count, :count]
    residuals, slopes = sample.residuals_with_sensitivities(chain, values)
    rank = round(float(found.determined.sum())) + chain.base
    determined = np.ones(count, dtype=bool)
    chi2 = float((residuals**2).sum())
    return Fit(chain, values, covariance, determined, residuals, slopes, chi2, max(sample.readings - rank, 1), rank)

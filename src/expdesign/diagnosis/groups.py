"""Many small errors: effects and laws of one kind as one group, weighed by the search that weighs single ones.

Where ten parts of a machine are a little wrong, to name them one at a time ends early, and what is named by then
imitates the rest. Here everything of one kind (angles of all links, compliances of all joints, laws of one form of what
a body stands on) is one law with one size, N(0, f²·δ²) with the size δ that its members have beforehand. Evidence says
which groups there are and sets f and the noise, which is not what the instrument alone would make; left-out blocks
refute what only describes the rows that were seen. The problem is linearised about the base model, fitted in full with
these sizes, and linearised again there.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import stdtrit

from expdesign.arrays import BoolArray, FloatArray, IntArray, as_matrix, rms
from expdesign.chain.chain import Chain
from expdesign.chain.ports.law import Law
from expdesign.chain.ports.sight import Sight
from expdesign.diagnosis.confirmation import Stability, named_without_tenths, shares_of
from expdesign.diagnosis.cross_validation import LeftOut, blocks_of, readings_of
from expdesign.diagnosis.dispersion import Widening
from expdesign.diagnosis.evidence.dictionary import law_of
from expdesign.diagnosis.evidence.problem import Chosen, Problem
from expdesign.diagnosis.evidence.search import Search
from expdesign.diagnosis.evidence.state import Present, linearised, regular
from expdesign.diagnosis.group_library import Group, GroupLibrary, Members
from expdesign.diagnosis.options import OPTIONS
from expdesign.diagnosis.outliers import single_mistakes
from expdesign.diagnosis.relinearised import relinearised
from expdesign.estimation.coverage import NORMAL_95
from expdesign.estimation.fit import Data, Fit, fit
from expdesign.mechanics.robots.robot import Robot

_HELD = 1e-8
"""Factor on the deviations of parameters that no group of the model contains."""


@dataclass(frozen=True)
class FoundGroup:
    """A group that is there.

    Attributes:
        group: what it is; the first of several of one form.
        size: RMS of what it does to the readings, in standard deviations.
        determined: how many of its parameters the readings determine.
        p_value: that left-out blocks are predicted no better with it.
        laws: of the chain, for groups of laws.
        share: in what all groups explain together (`Present.shares`); a negative one compensates another group.
        told_apart: members whose 95 % interval does not include what is known beforehand, with values and intervals.
    """

    group: Group
    size: float
    determined: float
    p_value: float
    laws: tuple[Law, ...]
    share: float
    told_apart: tuple[str, ...]

    @property
    def probability(self) -> float:
        """That it is there: that it predicts what was left out."""
        return OPTIONS.surest * (1.0 - self.p_value)


@dataclass(frozen=True)
class Groups:
    """A model of groups.

    Attributes:
        fit: of the chain with all effects that are there.
        found: by what they do to the readings, most first.
        before, after: RMS of left-out readings without and with them, in standard deviations as stated.
        widening: of predictions, which left-out readings ask for.
        noise: standard deviation of what the groups leave, in the stated ones.
        aside: rows that were set aside as single mistakes, shape (N,).
        stability: how often nine tenths of the rows keep them, in their order.
        few: whether one or two of them alone predict left-out blocks nearly as well.
        sight: what laws see.
    """

    fit: Fit
    found: tuple[FoundGroup, ...]
    before: float
    after: float
    widening: Widening
    noise: float
    aside: BoolArray
    stability: Stability
    few: bool
    sight: Sight


def grouped(robot: Robot, sample: Data, base: Fit, library: GroupLibrary) -> Groups | None:
    """The groups that these rows show; None where none is worth its evidence.

    Args:
        robot: the robot.
        sample: the rows that may be fitted.
        base: fit of the base model.
        library: groups that may be there.
    """
    if not library.groups:
        return None
    chosen = _chosen(sample, base, library)
    aside = single_mistakes(chosen.state, sample, robot).rows
    if aside.any():
        library = library.of_readings(readings_of(~aside, sample))
        sample = sample.restricted(~aside)
        base = fit(base.chain, sample)
        chosen = _chosen(sample, base, library)
    return _Model(robot, sample, base, chosen, library).groups(aside) if chosen.laws else None


def _chosen(sample: Data, base: Fit, library: GroupLibrary) -> Chosen:
    """The groups that are there beside the base model."""
    atoms = [group.atom for group in library.groups]
    options = replace(OPTIONS, most=len(atoms), slight=0.0)
    blocks = readings_of(blocks_of(sample), sample)
    alone = linearised(base, sample, known_noise=False)
    return Search(Problem(alone, atoms, blocks, options=options)).unrefuted()


class _Model:
    """The chain with the chosen groups, and what is known of its parameters beforehand."""

    def __init__(self, robot: Robot, sample: Data, base: Fit, chosen: Chosen, library: GroupLibrary) -> None:
        state = chosen.state
        self.sample, self.blocks, self.alone, self.sight = sample, chosen.blocks, state.alone, library.sight
        self.chosen = [library.groups[i] for i in chosen.laws]
        self.factors = np.sqrt(np.array(state.variances))
        self.noise = float(np.sqrt(state.noise_variance))
        self.members: list[Members] = []
        begun, number = list[FloatArray](), 0
        for k, (group, factor) in enumerate(zip(self.chosen, self.factors, strict=True)):
            weights, own = state.weights_of(k) * group.scales, group.members
            if group.atoms:
                variance = (self.noise * factor * group.scales[0]) ** 2
                parts = np.split(weights, np.cumsum([atom.width for atom in group.atoms])[:-1])
                links = [
                    law_of(atom, variance, part, library.sight, robot, n)
                    for n, (atom, part) in enumerate(zip(group.atoms, parts, strict=True), start=number + 1)
                ]
                number += len(links)
                own = tuple((law, index) for law, _ in links for index in range(len(law.parameters)))
                weights = np.concatenate([values for _, values in links])
            self.members.append(own)
            begun.append(weights)
        effects = dict.fromkeys(effect for own in self.members for effect, _ in own)
        self.chain = sample.chain(robot, sorted(effects, key=lambda effect: isinstance(effect, Law)))
        first = dict(zip(self.chain.effects, (part.start for part in self.chain.slices), strict=True))
        self.columns = [np.array([first[effect] + index for effect, index in own]) for own in self.members]
        start = np.concatenate([base.values, *(effect.neutral() for effect in self.chain.effects)])
        start[: len(base.values)] += state.weights[: len(base.values)]
        for columns, values in zip(self.columns, begun, strict=True):
            start[columns] += values
        self.start = np.clip(start, *self.chain.bounds())

    def prior(self) -> tuple[FloatArray, FloatArray]:
        """Mean and standard deviation of all parameters, (p,) each."""
        known = self.chain.knowledge()
        count = len(self.chain.parameters)
        mean, deviation = (np.zeros(count), np.full(count, np.inf)) if known is None else known
        mean, deviation = mean.copy(), deviation.copy()
        scales = self.chain.scales()
        named = np.zeros(count, dtype=bool)
        for effect, part in zip(self.chain.effects, self.chain.slices, strict=True):
            named[part] = not isinstance(effect, Law)
        deviation[named] = _HELD * scales[named]
        for group, columns, factor in zip(self.chosen, self.columns, self.factors, strict=True):
            if group.members:
                deviation[columns] = self.noise * factor * group.scales
        return mean, deviation

    def fitted(self) -> tuple[Fit, Present]:
        """The model fitted in full, and linearised there with sizes by evidence."""
        mean, deviation = self.prior()
        prior = mean, deviation / self.noise
        begun = fit(self.chain, self.sample, self.start, prior, enough=OPTIONS.settled)
        result = relinearised(begun, self.sample, prior)
        self.chain = result.chain
        kept, count = self.sample.kept, self.chain.base
        slopes = as_matrix(result.sensitivities)[kept]
        readings = result.residuals.ravel()[kept] + slopes @ (result.values - mean)
        base = slopes[:, :count]
        precision = regular(base, (self.noise / deviation[:count]) ** 2)
        laws = tuple(slopes[:, columns] * deviation[columns] / self.noise for columns in self.columns)
        state = Present(base, precision, readings, laws, (1.0,) * len(laws), known_noise=False).refitted()
        self.noise = float(np.sqrt(state.noise_variance))
        known = result.known_as(result.estimable.scaled(state.noise_variance))
        return replace(known, inflation=state.noise_variance), state

    def groups(self, aside: BoolArray) -> Groups:
        """The model with what it says of its groups."""
        result, state = self.fitted()
        blocks, count = self.blocks, len(self.chosen)
        shares = state.shares
        errors = state.left_out(blocks)
        found = []
        for kind in dict.fromkeys(group.kind for group in self.chosen):
            own = [k for k in range(count) if self.chosen[k].kind == kind]
            rest = state
            for k in reversed(own):
                rest = rest.without(k)
            without = rest.left_out(blocks)
            found.append(
                FoundGroup(
                    group=self.chosen[own[0]],
                    size=rms(sum((state.moved(k) for k in own), np.zeros(len(blocks)))),
                    determined=sum(state.determined(k) for k in own),
                    p_value=LeftOut(without, errors, blocks).p_value,
                    laws=tuple(
                        law for law in dict.fromkeys(e for k in own for e, _ in self.members[k]) if isinstance(law, Law)
                    ),
                    share=float(shares[own].sum()),
                    told_apart=_told_apart(self.chain, self.chosen[own[0]], self.columns[own[0]], result),
                )
            )
        found.sort(key=lambda one: -one.size)
        tenths = readings_of(blocks_of(self.sample, OPTIONS.refits), self.sample)
        refits = named_without_tenths(state, tenths, [0.0] * count)
        kept = [{self.chosen[k].kind for k in refit} for refit in refits]
        stability = shares_of([one.group.kind for one in found], kept)
        return Groups(
            fit=result, found=tuple(found), before=rms(self.alone.left_out(blocks)), after=rms(errors),
            widening=self._widening(state), noise=self.noise, aside=aside, stability=stability,
            few=_few_suffice(state, blocks), sight=self.sight,
        )  # fmt: skip

    def _widening(self, state: Present) -> Widening:
        """With which left-out readings are as far from their predictions as stated.

        What a left-out block does not determine is in the variance of its prediction, so that blocks of time, from
        which the groups have to extrapolate, do not widen what they predict between rows that they have seen. What
        is between the groups and the machine is alike within a block, so that B blocks show it B times:
        t_(B−1)·√(1 + 1/B) takes the place of a normal quantile.
        """
        blocks, noise = self.blocks, float(np.sqrt(state.noise_variance))
        errors, variances = state.left_out(blocks) / noise, state.left_out_variances(blocks) / noise**2
        inflation = LeftOut(errors, errors, blocks).widened(variances, np.zeros(len(errors)))[0]
        expected = 1.0 + inflation * np.maximum(variances - 1.0, 0.0)
        further = noise * max(rms(errors / np.sqrt(expected)), 1.0)
        count = max(len(np.unique(blocks)), 2)
        further *= float(stdtrit(count - 1, 0.975)) * float(np.sqrt(1.0 + 1.0 / count)) / NORMAL_95
        return Widening(further, further * float(np.sqrt(inflation)))


def _told_apart(chain: Chain, group: Group, columns: IntArray, result: Fit) -> tuple[str, ...]:
    """Named members that differ significantly from what is known of them beforehand."""
    low, high = chain.bounds()
    found = []
    for (effect, index), column in zip(group.members, columns, strict=False):
        parameter, value = effect.parameters[index], float(result.values[column])
        half = 1.96 * float(np.sqrt(max(result.covariance[column, column], 0.0)))
        if abs(value - parameter.neutral) > half and low[column] < value < high[column]:
            found.append(f"{parameter.name} of {effect.component} {value:.3g} ± {half:.1g}")
    return tuple(found)


def _few_suffice(state: Present, blocks: IntArray) -> bool:
    """Whether one or two groups alone predict left-out blocks nearly as well: then to name what is wrong is better."""
    goal = OPTIONS.clearly * max(rms(state.left_out(blocks)), float(np.sqrt(state.noise_variance)))
    current = state.alone
    for _ in range(min(2, len(state.laws))):
        trials = [current.beside(law, size) for law, size in zip(state.laws, state.variances, strict=True)]
        current = min(trials, key=lambda trial: rms(trial.left_out(blocks)))
    return rms(current.left_out(blocks)) <= goal

"""A body's support with everything at once: all laws of what it stands on, by groups (`ports.everything`).

Deflections of a body are linear in the weights of every law, so that groups are chosen on the directions of the
dictionary, and the chain is made of those that stay. Rows of one station are alike: the noise is learned, and left-out
stations decide which groups there are.
"""

from dataclasses import dataclass, replace

import numpy as np

from expdesign.arrays import BoolArray, FloatArray
from expdesign.chain.chain import Chain
from expdesign.chain.ports.curve import Curve
from expdesign.chain.ports.dictionary import Atom, Dictionary
from expdesign.chain.ports.everything import Everything, Priors, chosen_groups, group_gains, posterior_covariance
from expdesign.chain.ports.evidence import Present
from expdesign.chain.ports.found import law_of
from expdesign.chain.ports.law import Law
from expdesign.chain.ports.port import Entry
from expdesign.chain.ports.sight import Sight
from expdesign.diagnosis.at_once import AtOnce, GroupAtOnce
from expdesign.diagnosis.cross_validation import blocks_of, readings_of
from expdesign.diagnosis.dispersion import dispersion
from expdesign.diagnosis.laws import base_alone, measured_of
from expdesign.diagnosis.options import OPTIONS
from expdesign.diagnosis.sample import Sample
from expdesign.estimation.fit import Fit
from expdesign.mechanics.robots.robot import Robot

PORT = "supports"
_NOISE = 0.03
"""Noise at which ends of guides are compared before anything is fitted, in misfits of the base model."""

_POINTS = 31


@dataclass(frozen=True, kw_only=True)
class SupportGroup(GroupAtOnce):
    """Laws of one form, a key of `words.FORMS`, for each measured axis, or for all of them."""

    form: str
    laws: tuple[Law, ...]


@dataclass(frozen=True, kw_only=True)
class Support(AtOnce):
    """All laws of a support; left-out stations choose among groups, which have no names that refits could repeat."""

    groups: tuple[SupportGroup, ...]

    @property
    def why(self) -> str:
        """Why this way of working."""
        return (
            f"left-out blocks are predicted to {self.after:.3g} standard deviations by {len(self.groups)} groups of "
            f"laws of what the body stands on together, to {self.before:.3g} without them"
        )

    def nameless(self, sample: Sample) -> bool:
        """Whether no few named effects can predict to the noise: what all laws leave is no noise, and not their fault.

        A named law that changes too fast for laws of limited rank leaves remainders that do not depend on the row
        before; where rows are alike, something is missing that no law of the load, its history or time can stand for.
        """
        return self.noise > OPTIONS.noteworthy and dispersion(self.fit.residuals, sample).correlation > OPTIONS.alike

    def beats(self, named: Fit, sample: Sample) -> bool:
        """Whether left-out blocks are predicted better than by named effects (linear about their fit)."""
        kept = np.repeat(sample.counts, len(sample.recordings.axes))
        errors = base_alone(named, sample, kept).left_out(readings_of(blocks_of(sample), sample))
        return self.after < OPTIONS.better * float(np.sqrt((errors**2).mean()))


def support_laws(robot: Robot, sample: Sample, base: Fit) -> Support | None:
    """All laws of the support at once, less those without which left-out stations are predicted better.

    None where the robot has no support that the recordings load, where rows are few or the base model nearly fits, and
    where left-out stations are hardly predicted better.
    """
    excess = float(np.sqrt(base.chi2 / max(sample.readings - base.rank, 1)))
    if not robot.on_support or int(sample.counts.sum()) < OPTIONS.all_rows or excess < OPTIONS.all_excess:
        return None
    dictionary = Dictionary(robot, measured_of(sample, known_noise=False), base.values, only=(PORT,))
    kept = np.repeat(sample.counts, len(sample.recordings.axes))
    present = base_alone(base, sample, kept)
    atoms = _one_guide(dictionary.atoms, present)
    if not atoms:
        return None
    blocks = readings_of(blocks_of(sample), sample)
    slopes = np.hstack([atom.directions for atom in atoms])
    forms = list(dict.fromkeys(_form(atom) for atom in atoms))
    group = np.concatenate([np.full(atom.width, forms.index(_form(atom))) for atom in atoms])
    misfit = float(np.sqrt((present.readings**2).mean()))
    width = slopes.shape[1]
    free = np.full(width, np.inf)
    priors = Priors(np.zeros(width), np.full(width, misfit), group.astype(np.int64), -free, free)
    found, priors = chosen_groups(
        lambda weights: (present.readings - slopes @ weights, slopes), priors, np.zeros(width), blocks
    )
    after = float(np.sqrt((found.left_out(blocks, priors) ** 2).mean()))
    if after > OPTIONS.all_gains * misfit or not (priors.group >= 0).any():
        return None
    gains = group_gains(found, priors, blocks)
    return _in_chain(robot, sample, base, dictionary, atoms, found, priors, gains, (misfit, after))


def _one_guide(atoms: list[Atom], present: Present) -> list[Atom]:
    """One length scale, and of the laws of guides those with the end that explains most beside laws of the load.

    An end is judged by the evidence of laws of a size that the misfit allows, with noise of a share of it: what matters
    is how the tilt grows with what is drawn out, which no other law can make up for.
    """
    laws = [atom for atom in atoms if _entry(atom).form == "force law"]
    guides = [atom for atom in atoms if _entry(atom).form == "guide"]
    drawn = [atom for atom in atoms if _entry(atom).form == "guide friction"]
    rest = [atom for atom in atoms if _entry(atom).form not in ("force law", "guide", "guide friction")]
    scales = {_entry(atom).scales for atom in laws}
    level = _NOISE * float(np.sqrt((present.readings**2).mean())) or 1.0
    quiet = replace(present, base=present.base / level, readings=present.readings / level)
    best: tuple[float, list[Atom]] = (-np.inf, [])
    for scale in scales:
        own = [atom for atom in laws if _entry(atom).scales == scale]
        for end in {_entry(atom).channels[0].amplitude for atom in guides} or {None}:
            beside = [a for a in guides if _entry(a).scales == scale and _entry(a).channels[0].amplitude == end]
            state = quiet
            for atom in (*own, *beside):
                state = state.beside(atom.directions, _NOISE**-2)
            if state.log_evidence > best[0]:
                best = state.log_evidence, [*own, *beside]
    ends = {_entry(atom).channels[0].amplitude for atom in best[1]}
    return [*rest, *(atom for atom in drawn if _entry(atom).channels[0].amplitude in ends), *best[1]]


def _entry(atom: Atom) -> Entry:
    assert atom.entry is not None
    return atom.entry


def _form(atom: Atom) -> str:
    return f"{_entry(atom).form}, {_entry(atom).kernel}"


def _in_chain(
    robot: Robot,
    sample: Sample,
    base: Fit,
    dictionary: Dictionary,
    atoms: list[Atom],
    found: Everything,
    priors: Priors,
    gains: dict[int, float],
    errors: tuple[float, float],
) -> Support:
    """The chain with the laws that are there, fitted with the noise as it was learned."""
    laws: list[Law] = []
    starts, forms, first = [np.asarray(base.values)], [], 0
    for atom in atoms:
        width = atom.width
        own = slice(first, first + width)
        first += width
        group = int(priors.group[own.start])
        if group < 0:
            continue
        deviation = float(found.factors[group] * priors.deviation[own.start])
        law, start = law_of(atom, deviation**2, found.values[own], dictionary.sight, robot, len(laws) + 1)
        laws.append(law)
        starts.append(start)
        forms.append((_form(atom), float(found.determined[group]), gains[group]))
    chain = Chain(robot, tuple(laws), reading=sample.reading)
    fitted = _with_noise(chain, sample, np.concatenate(starts), found.noise)
    groups = []
    for form in dict.fromkeys(name for name, *_ in forms):
        members = [i for i, (name, *_) in enumerate(forms) if name == form]
        columns = np.concatenate([np.arange(chain.slices[i].start, chain.slices[i].stop) for i in members])
        moved = fitted.sensitivities[sample.counts][..., columns] @ fitted.values[columns]
        groups.append(
            SupportGroup(
                form=form.split(",")[0],
                laws=tuple(laws[i] for i in members),
                curve=_curves([(laws[i], chain.slices[i]) for i in members], robot, fitted, dictionary.sight),
                size=float(np.sqrt((moved**2).mean())),
                determined=forms[members[0]][1],
                p_value=forms[members[0]][2],
            )
        )
    groups.sort(key=lambda one: -one.size)
    none = np.zeros(len(sample.counts), dtype=bool)
    return Support(fit=fitted, groups=tuple(groups), before=errors[0], after=errors[1], noise=found.noise, aside=none)


def _curves(laws: list[tuple[Law, slice]], robot: Robot, fitted: Fit, sight: Sight) -> Curve | None:
    """Laws of the load, each input varied with the others at their medians; those of a guide at its median overlap."""
    if laws[0][0].form.channels[-1].gain >= 0.0:
        return None
    inputs = laws[0][0].form.channels[0].inputs
    output: list[str] = []
    varied: list[int] = []
    points, means, deviations = [], [], []
    for law, part in laws:
        form = law.form
        now, before = form.channels
        seen, rest = (np.column_stack([sight.values(q)[sight.counts] for q in c.inputs]) for c in (now, before))
        size = 1.0 if now.amplitude is None else float(np.median(sight.values(now.amplitude)[sight.counts]))
        own = slice(part.start, part.start + form.basis.rank)
        for i in range(len(inputs)):
            line = np.repeat(np.median(seen, axis=0)[None], _POINTS, axis=0)
            line[:, i] = np.linspace(form.low[0, i], form.high[0, i], _POINTS)
            features = now.gain * size * (form.basis.values(line) - form.basis.values(np.median(rest, axis=0)[None]))
            output += [robot.coordinates.deflection[now.output]] * _POINTS
            varied += [i] * _POINTS
            points.append(line)
            means.append(features @ fitted.values[own])
            variance = np.einsum("ij,jk,ik->i", features, fitted.covariance[own, own], features)
            deviations.append(np.sqrt(np.maximum(variance, 0.0)))
    return Curve(
        tuple(output), tuple(varied), np.concatenate(points), np.concatenate(means), np.concatenate(deviations),
        inputs, "law", "",
    )  # fmt: skip


def _with_noise(chain: Chain, sample: Sample, start: FloatArray, noise: float) -> Fit:
    """Posterior of a chain that is linear in its parameters, with noise of this size: ridge regression."""
    residuals, slopes = sample.residuals_with_sensitivities(chain, start)
    knowledge = chain.knowledge()
    count = len(start)
    precision = np.zeros(count) if knowledge is None else (noise / knowledge[1]) ** 2
    mean = np.zeros(count) if knowledge is None else knowledge[0]
    counted: BoolArray = sample.counts
    design = slopes[counted].reshape(-1, count)
    readings = residuals[counted].ravel() + design @ start
    sizes = np.maximum((design**2).sum(axis=0), 1e-300)
    inverse = posterior_covariance(design.T @ design, np.maximum(precision, 1e-12 * sizes))
    values = inverse @ (design.T @ readings + precision * mean)
    after = sample.residuals(chain, values)
    rank = max(round(float((1.0 - inverse.diagonal() * precision).sum())), 0)
    chi2 = float((after**2).sum())
    determined = np.ones(count, dtype=bool)
    dof = max(sample.readings - rank, 1)
    covariance = noise**2 * inverse
    return Fit(chain, values, covariance, determined, after, slopes, chi2, dof, rank, inflation=noise**2)

"""Laws at ports for a mismatch that named physics does not explain: located, fitted into the chain, and judged.

Named effects take part as laws of known form, linear about their starts, so that what is named and what is not are
sought together; where a named form carries as much evidence it wins, having fewer weights.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, as_matrix
from expdesign.chain.chain import Chain
from expdesign.chain.effect import Effect
from expdesign.chain.ports.curve import Curve, curve_of
from expdesign.chain.ports.law import Law
from expdesign.chain.ports.sight import Sight
from expdesign.diagnosis.cross_validation import LeftOut, blocks_of, readings_of
from expdesign.diagnosis.evidence.columns import Dense
from expdesign.diagnosis.evidence.dictionary import Dictionary, Measured, known_form, law_of
from expdesign.diagnosis.evidence.places import Place, places
from expdesign.diagnosis.evidence.search import Chosen, LawSearch
from expdesign.diagnosis.evidence.state import Present, regular
from expdesign.diagnosis.library import Candidate
from expdesign.diagnosis.options import OPTIONS
from expdesign.diagnosis.sample import Sample
from expdesign.diagnosis.selection import Model
from expdesign.estimation.fit import Fit, fit
from expdesign.mechanics.robots.robot import Robot


@dataclass(frozen=True)
class Part:
    """One law, or one named effect beside laws.

    Attributes:
        effect: the link of the chain.
        places: where it may be, most probable first.
        share: of the excess of χ² that it alone takes away.
        named: the candidate of the library, or None for a law.
        curve: of a law.
    """

    effect: Effect
    places: tuple[Place, ...]
    share: float
    named: Candidate | None = None
    curve: Curve | None = None


@dataclass(frozen=True)
class Laws:
    """Laws that were found.

    Attributes:
        parts: by what they take away, most first.
        fit: of the chain with all of them.
        left_out: errors of left-out readings without and with them in standard deviations of the noise, which decide
            whether they are predicted with.
        gain: of log evidence by all together.
        inflation: of the covariance of `fit`, which left-out errors ask for.
        noise: standard deviation of the readings in the stated or first estimated one: 1 where it is known.
        log: what was decided and why.
    """

    parts: tuple[Part, ...]
    fit: Fit
    left_out: LeftOut
    gain: float
    inflation: float = 1.0
    noise: float = 1.0
    log: tuple[str, ...] = ()

    @property
    def before(self) -> float:
        """RMS of left-out readings without laws, in standard deviations."""
        return self.left_out.rms_before

    @property
    def after(self) -> float:
        """RMS of left-out readings with laws, in standard deviations."""
        return self.left_out.rms_after

    @property
    def predicts(self) -> bool:
        """Whether left-out readings are predicted well enough to be predicted with the laws."""
        return not self.left_out.doubt

    def replaces(self, named: Model) -> bool:
        """Whether these may stand in place of names that explain: with a law among them, and fitted in full no worse.

        The search takes effects as linear, and one that may have one sign only can come out with the other.
        """
        return any(part.named is None for part in self.parts) and self.fit.chi2 < named.fit.chi2

    def summary(self, verdict: str) -> str:
        """What was decided, in one sentence."""
        listed = "; ".join(f"{p.effect.key} ({100 * p.share:.0f} %)" for p in self.parts)
        return (
            f"laws at ports: {listed}; left-out error {self.after:.3g} instead of {self.before:.3g}"
            + ("" if self.predicts else f", not predicted with: {self.left_out.doubt}")
            + f"; verdict {verdict}"
        )


def measured_of(sample: Sample) -> Measured:
    """What laws are sought in."""
    recordings = sample.recordings
    blocks = blocks_of(sample)
    return Measured(
        sample.rows, tuple(int(a) for a in recordings.axes), sample.counts, sample.whiten, blocks,
        recordings.time is not None, sample.reading,
    )  # fmt: skip


def left_out_alone(fitted: Fit, base: Fit, sample: Sample, *, known_noise: bool) -> LeftOut:
    """Errors of left-out series by the base model and by one with named effects, linear about their parameters.

    Args:
        fitted: to the rows of the sample.
        base: fit of the base model.
        sample: rows that count.
        known_noise: whether the noise is stated.
    """
    blocks = readings_of(blocks_of(sample), sample)
    start = fit(base.chain, sample)
    before, after = (base_alone(each, sample).left_out(blocks) for each in (start, fitted))
    return LeftOut(before, after, blocks)


def without_mistakes(sample: Sample, outliers: BoolArray) -> BoolArray:
    """The rows set aside beside laws, shape (N,), of those that a model without laws sets aside.

    Where physics is missing such a model sets aside rows that show it: only few are taken for single mistakes.
    """
    few = outliers.sum() <= max(1.0, OPTIONS.single_mistakes * sample.counts.sum())
    return outliers if few else np.zeros_like(outliers)


def sought_laws(
    robot: Robot,
    sample: Sample,
    base: Fit,
    library: list[Candidate],
    *,
    known_noise: bool,
    named: Model | None = None,
    explained: bool = False,
    report: Callable[[str], None] = lambda text: None,
) -> Laws | None:
    """The laws that these rows show; None where they show none, or are too few.

    Args:
        robot: the robot.
        sample: the rows that may be fitted and belong to some physics.
        base: fit of the base model.
        library: named physics.
        known_noise: whether the noise is stated.
        named: the best model with named effects, from which laws are sought as well as from none.
        explained: whether it explains the recordings: the problem is linearised about it then. About what imitates,
            laws would be weighed by readings of which its own curvature is a part.
        report: is told what is being done.
    """
    if int(sample.counts.sum()) < OPTIONS.fewest_rows:
        return None
    report("preparing laws at ports")
    measured = measured_of(sample)
    dictionary = Dictionary(robot, measured, base.values)
    kept = sample.kept
    scales: dict[int, FloatArray] = {}
    some = None if kept.all() else kept
    for candidate in library:
        for start, directions in enumerate(candidate.directions):
            columns = Dense(directions, some)
            known = known_form(candidate.effect.component, columns, (candidate, candidate.starts[start]))
            if known is not None:
                scales[len(dictionary.atoms)] = known[1]
                dictionary.atoms.append(known[0])
    present, seeds = base_alone(base, sample, known_noise=known_noise), []
    if named is not None and named.candidates:
        about, found = _about(named, sample, kept, known_noise=known_noise)
        present = about if explained else present
        for candidate, values, directions in found:
            known = known_form(candidate.effect.component, Dense(directions), (candidate, values))
            if known is not None:
                seeds.append(len(dictionary.atoms))
                scales[seeds[-1]] = known[1]
                dictionary.atoms.append(known[0])
    blocks = readings_of(measured.blocks, sample)
    search = LawSearch(dictionary.atoms, present, blocks, dictionary.made)
    report("weighing laws at ports")
    chosen = search.run(seeds=seeds)
    gain = chosen.evidence - present.log_evidence
    if not chosen.indices or set(chosen.indices) <= set(seeds):
        return None
    noise = np.sqrt(chosen.state.noise_variance)
    left_out = LeftOut(present.left_out(blocks) / noise, chosen.state.left_out(blocks) / noise, blocks)
    return _fitted(robot, sample, base, scales, search, dictionary.sight, chosen, left_out, gain)


def _about(
    named: Model, sample: Sample, kept: BoolArray, *, known_noise: bool
) -> tuple[Present, list[tuple[Candidate, FloatArray, FloatArray]]]:
    """The base model with readings as they are without the effects of a fitted model, to first order about it.

    And each of these with its values when it vanishes, shapes as they were fitted, and its directions (M, d).
    """
    chain, values = named.fit.chain, named.fit.values
    residuals, slopes = sample.residuals_with_sensitivities(chain, values)
    design, readings, found = as_matrix(slopes)[kept], residuals.ravel()[kept], []
    for candidate, part in zip(named.candidates, chain.slices, strict=True):
        free = np.array([not p.shape for p in candidate.effect.parameters])
        vanishing = np.where(free, candidate.effect.neutral(), values[part])
        readings = readings + design[:, part] @ (values[part] - vanishing)
        found.append((candidate, vanishing, design[:, part][:, free]))
    alone = Chain(chain.robot, reading=sample.reading)
    return _present(alone, design[:, : chain.base], readings, known_noise=known_noise), found


def base_alone(base: Fit, sample: Sample, *, known_noise: bool = True) -> Present:
    """The base model, with what is known of its parameters."""
    directions, readings = as_matrix(base.sensitivities)[sample.kept], base.residuals.ravel()[sample.kept]
    return _present(base.chain, directions, readings, known_noise=known_noise)


def _present(chain: Chain, directions: FloatArray, readings: FloatArray, *, known_noise: bool) -> Present:
    knowledge = chain.knowledge()
    precision = np.zeros(directions.shape[1]) if knowledge is None else 1.0 / knowledge[1] ** 2
    return Present(directions, regular(directions, precision), readings, known_noise=known_noise)


def _fitted(
    robot: Robot,
    sample: Sample,
    base: Fit,
    scales: dict[int, FloatArray],
    search: LawSearch,
    sight: Sight,
    chosen: Chosen,
    left_out: LeftOut,
    gain: float,
) -> Laws:
    """The chain with the chosen laws, and what each of them says."""
    state, atoms = chosen.state, search.atoms
    weights, first = state.weights, state.base.shape[1]
    found: list[tuple[Effect, FloatArray, tuple[Place, ...], float, Candidate | None]] = []
    # Sizes of laws are in units of the noise, as the fit takes it; the covariance gets that of the readings.
    variance = state.noise_variance
    excess = max(float(state.readings @ search.base.projected) - variance * len(state.readings), 1e-9)
    where_of = {c: places(search.weighed(chosen, c)) for c in search.components(chosen)}
    for position, index in enumerate(chosen.indices):
        atom = atoms[index]
        own = weights[first : first + atom.width]
        first += atom.width
        rest = state.without(position)
        share = float(np.clip((state.readings @ (rest.projected - state.projected)) / excess, 0.0, 1.0))
        where = where_of[atom.component]
        if atom.entry is None:
            assert atom.named is not None
            candidate, start = atom.named
            values = start.copy()
            free = np.array([not p.shape for p in candidate.effect.parameters])
            values[free] += scales[index] * own
            found.append((candidate.effect, values, where, share, candidate))
        else:
            law, values = law_of(atom, state.variances[position], own, sight, robot, position + 1)
            found.append((law, values, where, share, None))
    chain = Chain(robot, tuple(item[0] for item in found), reading=sample.reading)
    start_values = np.concatenate([base.values, *(item[1] for item in found)])
    result = fit(chain, sample, start_values, enough=1e-2)
    inflation = left_out.inflation(state.left_out_variances(search.blocks) / variance)
    result = replace(result.known_as(result.estimable.scaled(inflation * variance)), inflation=inflation * variance)
    parts = []
    for (effect, _, where, share, named), part in zip(found, chain.slices, strict=True):
        curve = None
        if isinstance(effect, Law):
            seen = np.column_stack([sight.values(q)[sight.counts] for q in effect.form.channels[0].inputs])
            curve = curve_of(effect, robot, result.values, result.covariance, part, seen)
        parts.append(Part(effect, where, share, named, curve))
    parts.sort(key=lambda item: -item.share)
    return Laws(tuple(parts), result, left_out, gain, inflation, float(np.sqrt(variance)), tuple(search.log))

"""Laws at ports for a mismatch that named physics does not explain: located, fitted into the chain, and judged.

Named effects take part, so that what is named and what is not are sought together; where a named form carries as much
evidence it wins, having fewer weights.
"""

from dataclasses import dataclass, replace

import numpy as np

from expdesign.arrays import as_matrix
from expdesign.chain.effect import Effect
from expdesign.chain.ports.curve import Curve, curve_of
from expdesign.chain.ports.law import Law
from expdesign.chain.ports.sight import Sight
from expdesign.diagnosis.cross_validation import LeftOut
from expdesign.diagnosis.evidence.dictionary import Dictionary, law_of
from expdesign.diagnosis.evidence.problem import Chosen, Problem
from expdesign.diagnosis.evidence.search import Search
from expdesign.diagnosis.library import Candidate
from expdesign.diagnosis.names import NamedModel, Names
from expdesign.diagnosis.options import OPTIONS
from expdesign.diagnosis.outliers import single_mistakes
from expdesign.diagnosis.posterior import Place, places
from expdesign.diagnosis.relinearised import relinearised
from expdesign.diagnosis.stages import Stage
from expdesign.diagnosis.statement import deviations_from_none, with_share
from expdesign.estimation.fit import Fit, fit


@dataclass(frozen=True)
class FoundLaw:
    """One law, or one named effect beside laws.

    Attributes:
        effect: the link of the chain.
        places: where it may be, most probable first.
        share: in what all parts explain together (`Present.shares`); a negative one compensates another part.
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
        gain: of log evidence by all together, fitted in full, prior included.
        names: what may be named, in the rows that belong to some physics.
        inflation: of the covariance of `fit`, which left-out errors ask for.
        noise: standard deviation of the readings in the stated or first estimated one: 1 where it is known.
    """

    parts: tuple[FoundLaw, ...]
    fit: Fit
    left_out: LeftOut
    gain: float
    names: Names
    inflation: float = 1.0
    noise: float = 1.0

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

    @property
    def doubted(self) -> "Laws":
        """The same where they leave more than the noise: where they are is less sure."""

        def less(place: Place) -> Place:
            return replace(place, probability=OPTIONS.doubted * place.probability)

        return replace(self, parts=tuple(replace(p, places=tuple(map(less, p.places))) for p in self.parts))

    def replaces(self, base: NamedModel, named: NamedModel) -> bool:
        """Whether these may stand in the place of names that explain: with a law among them, and likelier by far."""
        nameless = any(part.named is None for part in self.parts)
        return nameless and self.gain > 0.5 * (base.misfit - named.misfit) + OPTIONS.margin

    def summary(self, verdict: str) -> str:
        """What was decided, in one sentence."""
        listed = "; ".join(f"{p.effect.key} ({100 * p.share:.0f} %)" for p in self.parts)
        return (
            f"laws at ports: {listed}; left-out error {self.after:.3g} instead of {self.before:.3g}"
            + ("" if self.predicts else f", not predicted with: {self.left_out.doubt}")
            + f"; verdict {verdict}"
        )


def sought_laws(names: Names, named: NamedModel, *, explained: bool, mistaken: bool) -> Laws | None:
    """The laws that rows show beside named effects; None where they show none, or are too few.

    Rows that stand out of all of them together as single mistakes do are set aside, and the others asked again.

    Args:
        names: with the rows that may be fitted.
        named: the best model with named effects, from which the search goes on as well as from none.
        explained: whether it explains the recordings; otherwise it is not what is looked for.
        mistaken: whether rows may be single mistakes.
    """
    robot, sample = names.robot, names.sample
    if int(sample.counts.sum()) < OPTIONS.fewest_rows:
        return None
    names.report(Stage.PORTS, "")
    dictionary = Dictionary(robot, sample, names.base.fit.values)
    problem = Problem(names.state(names.base), dictionary.atoms, names.blocks, names, dictionary.made)
    names.report(Stage.LAWS, "")
    search, seed = Search(problem), problem.of_model(names.as_here(named))
    chosen = search.run([seed] if named.candidates else [], [] if explained else [seed])
    if chosen.key in (seed.key, problem.start.key):
        return None
    aside, _ = single_mistakes(chosen.state, sample, robot) if mistaken else (np.zeros(0, dtype=bool), "")
    if aside.any():
        return sought_laws(names.of_rows(sample.restricted(~aside)), named, explained=explained, mistaken=False)
    return _fitted(names, search, dictionary.sight, chosen)


def _fitted(names: Names, search: Search, sight: Sight, chosen: Chosen) -> Laws:
    """The chain with the chosen laws, and what each of them says."""
    robot, sample, state, start, model = names.robot, names.sample, chosen.state, search.start.state, chosen.named
    assert model is not None
    # Sizes of laws are in units of the noise, as the fit takes it; the covariance gets that of the readings.
    variance, noise = state.noise_variance, float(np.sqrt(state.noise_variance))
    where_of = {c: places(search.weighed(chosen, c)) for c in chosen.components}
    weights, first = state.weights, state.base.shape[1] + sum(law.shape[1] for law in state.laws[: len(model.effects)])
    effects: list[Effect] = [*model.effects]
    values = [model.fit.values]
    for index, size in zip(chosen.laws, state.variances[len(effects) :], strict=True):
        atom = search.problem.atoms[index]
        own = weights[first : first + atom.width]
        first += atom.width
        law, begun = law_of(atom, size, own, sight, robot, len(effects) + 1)
        effects.append(law)
        values.append(begun)
    chain = sample.chain(robot, effects)
    result = relinearised(fit(chain, sample, np.concatenate(values), enough=1e-2), sample)
    left_out = LeftOut(
        start.left_out(search.problem.blocks) / noise,
        state.left_out(search.problem.blocks) / noise,
        search.problem.blocks,
    )
    done = as_matrix(result.sensitivities)[sample.kept] @ deviations_from_none(result)
    inflation, remaining = left_out.widened(
        state.left_out_variances(search.problem.blocks) / variance, (done**2).sum(axis=1)
    )
    result = replace(_widened(result, inflation, remaining, variance), inflation=inflation * variance)
    parts, shares = [], state.shares.tolist()
    for position, (effect, part, share) in enumerate(zip(effects, chain.slices, shares, strict=True)):
        where = where_of[effect.component]
        if isinstance(effect, Law):
            seen = np.column_stack([sight.values(q)[sight.counts] for q in effect.form.channels[0].inputs])
            curve = curve_of(effect, robot, result.values, result.covariance, part, seen)
            parts.append(FoundLaw(effect, where, share, None, curve))
        else:
            parts.append(FoundLaw(effect, where, share, model.candidates[position]))
    parts.sort(key=lambda item: -item.share)
    # A law is linear in its own weights alone: what the chain does not do in full is no evidence.
    lost = max(0.0, result.chi2 - state.scatter) / variance
    gain = chosen.evidence - search.start.evidence - 0.5 * lost
    return Laws(tuple(parts), result, left_out, gain, names, inflation, noise)


def _widened(result: Fit, inflation: float, remaining: float, variance: float) -> Fit:
    """The fit with covariance k·s²·C, and beside it the share q of all that is not exact."""
    return with_share(result.known_as(result.estimable.scaled(inflation * variance)), remaining * variance)

"""Laws at ports that a search has chosen, with the named effects beside them: fitted into the chain, and judged."""

from dataclasses import dataclass, replace

import numpy as np

from expdesign.arrays import as_matrix
from expdesign.chain.effect import Effect
from expdesign.chain.ports.curve import Curve, curve_of
from expdesign.chain.ports.law import Law
from expdesign.chain.ports.sight import Sight
from expdesign.diagnosis.cross_validation import LeftOut
from expdesign.diagnosis.dispersion import deviations_from_none, with_share
from expdesign.diagnosis.evidence.dictionary import law_of
from expdesign.diagnosis.evidence.problem import Chosen
from expdesign.diagnosis.evidence.search import Search
from expdesign.diagnosis.library import Candidate
from expdesign.diagnosis.names import Names
from expdesign.diagnosis.options import OPTIONS
from expdesign.diagnosis.posterior import Place, places
from expdesign.diagnosis.relinearised import relinearised
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
        names: what may be named, in the rows that belong to some physics.
        inflation: of the covariance of `fit`, which left-out errors ask for.
        noise: standard deviation of the readings in the stated or first estimated one: 1 where it is known.
    """

    parts: tuple[FoundLaw, ...]
    fit: Fit
    left_out: LeftOut
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

    def summary(self, verdict: str) -> str:
        """What was decided, in one sentence."""
        listed = "; ".join(f"{p.effect.key} ({100 * p.share:.0f} %)" for p in self.parts)
        return (
            f"laws at ports: {listed}; left-out error {self.after:.3g} instead of {self.before:.3g}"
            + ("" if self.predicts else f", not predicted with: {self.left_out.doubt}")
            + f"; verdict {verdict}"
        )


def fitted(names: Names, search: Search, sight: Sight, chosen: Chosen) -> Laws:
    """The chain with the chosen laws, and what each of them says."""
    robot, sample, state, start, model = names.robot, names.sample, chosen.state, search.start.state, chosen.named
    assert model is not None
    # Sizes of laws are in units of the noise, as the fit takes it; the covariance gets that of the readings.
    variance, noise = state.noise_variance, float(np.sqrt(state.noise_variance))
    where_of = {c: places(search.weighed(chosen, c)) for c in chosen.components}
    links = [
        law_of(search.problem.atoms[index], state.variances[k], state.weights_of(k), sight, robot, k + 1)
        for k, index in enumerate(chosen.laws, start=len(model.effects))
    ]
    effects: list[Effect] = [*model.effects, *(law for law, _ in links)]
    chain = sample.chain(robot, effects)
    begun = np.concatenate([model.fit.values, *(values for _, values in links)])
    result = relinearised(fit(chain, sample, begun, enough=1e-2), sample)
    blocks = search.problem.blocks
    left_out = LeftOut(start.left_out(blocks) / noise, state.left_out(blocks) / noise, blocks)
    done = as_matrix(result.sensitivities)[sample.kept] @ deviations_from_none(result)
    inflation, remaining = left_out.widened(state.left_out_variances(blocks) / variance, (done**2).sum(axis=1))
    # The covariance is k·s²·C, and beside it is the share q of all that is not exact.
    result = with_share(result.known_as(result.estimable.scaled(inflation * variance)), remaining * variance)
    result = replace(result, inflation=inflation * variance)
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
    return Laws(tuple(parts), result, left_out, names, inflation, noise)

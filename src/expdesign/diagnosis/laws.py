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
    """

    parts: tuple[FoundLaw, ...]
    fit: Fit
    left_out: LeftOut

    @property
    def doubted(self) -> "Laws":
        """The same where they leave more than the noise: where they are is less sure."""

        def less(place: Place) -> Place:
            return replace(place, probability=OPTIONS.doubted * place.probability)

        return replace(self, parts=tuple(replace(p, places=tuple(map(less, p.places))) for p in self.parts))

    def summary(self, verdict: str) -> str:
        """What was decided, in one sentence."""
        listed = "; ".join(f"{p.effect.key} ({100 * p.share:.0f} %)" for p in self.parts)
        errors, doubt = self.left_out, self.left_out.doubt and f", not predicted with: {self.left_out.doubt}"
        found = f"left-out error {errors.rms_after:.3g} instead of {errors.rms_before:.3g}"
        return f"laws at ports: {listed}; {found}{doubt}; verdict {verdict}"


def fitted(search: Search, sight: Sight, chosen: Chosen) -> Laws:
    """The chain with the chosen laws, and what each of them says."""
    names, state, start, model = search.known_names, chosen.state, search.start.state, chosen.model
    robot, sample = names.robot, names.sample
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
    return Laws(tuple(parts), result, left_out)

"""What was found, with intervals, probabilities and sentences."""

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from expdesign.arrays import BoolArray, FloatArray
from expdesign.chain.effect import Effect
from expdesign.chain.ports.curve import Curve
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.sentences import ENDLESS
from expdesign.diagnosis.confirmation import Stability, gains
from expdesign.diagnosis.cross_validation import LeftOut
from expdesign.diagnosis.dispersion import Dispersion
from expdesign.diagnosis.evidence.search import Search
from expdesign.diagnosis.names import NamedModel
from expdesign.diagnosis.options import OPTIONS
from expdesign.diagnosis.posterior import standing
from expdesign.estimation.coverage import NORMAL_95
from expdesign.estimation.fit import Fit

_NONE = 7.0
"""Logarithm of odds beyond which another explanation changes no probability by a tenth of a per cent."""


@dataclass(frozen=True)
class Finding:
    """One effect that is present.

    Attributes:
        physics, component, variant: what and where.
        parameters: reported values with 95 % intervals.
        probability: that this physics at this component is really there.
        indistinguishable: other physics that would explain these recordings as well.
        elsewhere: other components at which this physics would.
        sentence: for a technician.
        rows: lines of the file that were set aside (outliers only).
        rival: a model with other physics in its place that explains the recordings as well, or None.
        gain: what the effect by itself does for readings that were left out; None of laws and groups.
        form: name of its parametric form (`Effect.form_name`), or `free` for a law that its declaration covers; empty
            for what has no identifier.
        share: in what all effects explain together (`Present.shares`); a negative one compensates another effect. None
            for rows that were set aside.
        named_by: share of refits on nine tenths of the rows that name it, or None.
        depends_on: identifiers of the inputs of a law (`words.identifier`); empty for all else.
        columns: the same as columns of the curve.
        curve: of a law with its band.
    """

    physics: str
    component: str
    variant: str
    parameters: dict[str, tuple[float, float, float]]
    probability: float
    indistinguishable: tuple[str, ...]
    sentence: str
    rows: tuple[int, ...] = ()
    rival: NamedModel | None = None
    gain: LeftOut | None = None
    form: str = ""
    share: float | None = None
    named_by: float | None = None
    elsewhere: tuple[str, ...] = ()
    depends_on: tuple[str, ...] = ()
    columns: tuple[str, ...] = ()
    curve: Curve | None = None


def findings(
    search: Search,
    model: NamedModel,
    spread: Dispersion | None = None,
    stable: Stability | None = None,
) -> tuple[Finding, ...]:
    """The effects of a model, the most explanatory first."""
    found: list[Finding] = []
    names = search.known_names
    scale = 1.0
    if not names.known_noise:
        scale = model.fit.chi2 / max(names.sample.readings - model.fit.rank, 1)
    inflation = 1.0
    if spread is not None and spread.inflation > OPTIONS.predicts:
        scale = inflation = spread.inflation
    state = names.state(model)
    shares, held = state.shares.tolist(), gains(state, names.blocks)
    for index, (candidate, share) in enumerate(zip(model.candidates, shares, strict=True)):
        others, laws = search.instead(model, index, OPTIONS.temperature * _NONE)
        stands = standing(model, index, [names.without(model, index), *others], laws, inflation)
        values = reported(candidate.effect, model.fit, model.fit.chain.slices[index], scale)
        effect = candidate.effect
        finding = Finding(
            effect.physics,
            str(effect.component),
            str(effect.variant),
            values,
            stands.probability,
            stands.indistinguishable,
            compensating(effect.sentence(values), share) + _other_forms(effect, values, stands.forms, scale),
            rival=stands.rival,
            gain=held[index],
            form=effect.form_name,
            share=share,
            named_by=None if stable is None else stable.shares[index],
            elsewhere=stands.elsewhere,
        )
        found.append(finding)
    found.sort(key=lambda one: -(one.share or 0.0))
    return tuple([one for one in found if abs(one.share or 0.0) >= OPTIONS.listed] or found[:1])


def _other_forms(
    effect: Effect, values: dict[str, tuple[float, float, float]], models: Sequence[NamedModel], scale: float
) -> str:
    """Sentences of other variants that explain as well, where these have another size."""
    said = list[str]()
    for model in models:
        of = next(index for index, one in enumerate(model.effects) if one.slot == effect.slot)
        other = model.effects[of]
        own = reported(other, model.fit, model.fit.chain.slices[of], scale)
        if any(name in own and not low <= own[name][0] <= high for name, (_, low, high) in values.items()):
            said.append(f" These recordings fit as well: {other.sentence(own)}")
    return "".join(said)


def compensating(sentence: str, share: float) -> str:
    """The sentence of an effect, with what its share says where that is negative."""
    said = round(-100.0 * share)
    return f"{sentence} It compensates other effects, by {said} % of what is explained." if said > 0 else sentence


def set_aside(recordings: Recordings, aside: BoolArray) -> tuple[Finding, ...]:
    """The finding of rows that were set aside, shape (N,); none where there are none."""
    lines = tuple(int(line) for line in recordings.lines[aside])
    if not lines:
        return ()
    count = float(len(lines))
    named = ", ".join(map(str, lines))
    sentence = f"Row {named} is an outlier: no model explains it."
    if count > 1:
        sentence = f"Rows {named} are outliers: no model explains them."
    return (Finding("outlier", "instrument", "", {"rows": (count, count, count)}, OPTIONS.surest, (), sentence, lines),)


def reported(effect: Effect, fitted: Fit, part: slice, scale: float) -> dict[str, tuple[float, float, float]]:
    """Reported parameters of an effect with 95 % intervals by the delta method; `scale` multiplies the covariance.

    An interval ends at the parameter's bounds, and is all between them where the data do not determine it.
    """
    theta = ca.SX.sym("theta", len(effect.parameters))
    expressions = effect.reported(theta)
    stacked = ca.vertcat(*expressions.values())
    function = ca.Function("reported", [theta], [stacked, ca.jacobian(stacked, theta)])
    values, jacobian = (np.array(output) for output in function(fitted.values[part]))
    covariance: FloatArray = fitted.covariance[part, part] * scale
    result: dict[str, tuple[float, float, float]] = {}
    known = np.isfinite(covariance.diagonal())
    bounds = {parameter.name: (parameter.low, parameter.high) for parameter in effect.parameters}
    for row, name in enumerate(expressions):
        lowest, highest = bounds.get(name, ENDLESS)
        slope = jacobian[row]
        estimate = float(values[row, 0])
        if np.any(slope[~known] != 0.0):
            result[name] = (estimate, max(lowest, ENDLESS[0]), min(highest, ENDLESS[1]))
            continue
        used = np.where(known, slope, 0.0)
        variance = float(used[known] @ covariance[np.ix_(known, known)] @ used[known])
        half = NORMAL_95 * float(np.sqrt(max(variance, 0.0)))
        result[name] = (estimate, max(estimate - half, lowest), min(estimate + half, highest))
    return result

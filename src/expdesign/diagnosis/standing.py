"""How probable a named effect is, and which other physics these recordings could not tell from it.

Every model that was fitted in full during the search, or in its place afterwards, has a posterior weight
exp(−½·penalised misfit) (the penalty carries the prior, see `names`). The weights are spread by a temperature above
one, because models of real mechanisms are never exact: what separates them is partly what all of them lack. And however
large the evidence, what stands in no library may be behind it: no probability exceeds `surest`.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from expdesign.chain.effect import Effect
from expdesign.diagnosis.names import NamedModel
from expdesign.diagnosis.options import OPTIONS


@dataclass(frozen=True)
class Standing:
    """How one effect of a model stands against what could be in its place.

    Attributes:
        probability: of this physics at this component.
        indistinguishable: other physics that would explain the recordings as well.
        rival: the best model with such other physics in its place, or None.
    """

    probability: float
    indistinguishable: tuple[str, ...]
    rival: NamedModel | None


def standing(
    model: NamedModel, index: int, without: NamedModel, alternatives: list[NamedModel], inflation: float = 1.0
) -> Standing:
    """Standing of effect `index` of a model.

    Args:
        model: the chosen model.
        index: of the effect.
        without: the model without the effect.
        alternatives: models with something else in its place.
        inflation: by which residuals say less than as many independent rows would (`dispersion`).
    """
    chosen = model.candidates[index].effect
    others = {m.keys: m for m in (without, *alternatives) if m.keys != model.keys}
    misfits = np.array([model.misfit, *(m.misfit for m in others.values())])
    # What held-out rows passed over, however small its misfit, is at most as likely as what they chose.
    weights = np.exp(-0.5 * np.maximum(misfits - model.misfit, 0.0) / (OPTIONS.temperature * inflation))
    same = [True]
    rivals: dict[str, float] = {}
    nearest: NamedModel | None = None
    for other in others.values():
        extra = [e for e in other.effects if e.key not in {m.key for m in model.effects}]
        agrees = any(e.physics == chosen.physics and e.component == chosen.component for e in extra)
        agrees = agrees or _idle_elsewhere(model, chosen, other, extra)
        same.append(agrees)
        for effect in extra:
            if effect.physics != chosen.physics:
                gap = (other.misfit - model.misfit) / inflation
                rivals[effect.physics] = min(gap, rivals.get(effect.physics, np.inf))
                if gap < OPTIONS.indistinguishable and (nearest is None or other.misfit < nearest.misfit):
                    nearest = other
    probability = OPTIONS.surest * float(weights[np.array(same)].sum() / weights.sum())
    close = sorted((gap, physics) for physics, gap in rivals.items() if gap < OPTIONS.indistinguishable)
    return Standing(probability, tuple(physics for _, physics in close), nearest)


def _idle_elsewhere(model: NamedModel, chosen: Effect, other: NamedModel, extra: Sequence[Effect]) -> bool:
    """Whether another model has this physics with a size of its own at every part, and nothing to show at other parts.

    It includes the chosen effect, and what it adds takes no more from χ² than a parameter that is not there may.
    """
    return (
        model.fit.chi2 - other.fit.chi2 < OPTIONS.noticeable**2
        and len(extra) == 1
        and extra[0].physics == chosen.physics
        and extra[0].component.several
        and not chosen.component.several
        and sum(not p.shape for p in extra[0].parameters) >= len(model.fit.chain.robot.stiffness)
    )

"""How probable a named effect is, and which other physics these recordings could not tell from it.

Every model that was fitted in full during the search, or in its place afterwards, has a posterior weight
exp(−½·penalised misfit) (the penalty carries the prior, see `selection`). The weights are spread by a temperature above
one, because models of real mechanisms are never exact: what separates them is partly what all of them lack. And however
large the evidence, what stands in no library may be behind it: no probability exceeds `most`.

`temperature`, `most`, `fitting` and `tentative` were set on development sets of `benchmarks/concealed`, none of which
belongs to the proof that is kept under `results/concealed`.
"""

from dataclasses import dataclass

import numpy as np

from expdesign.diagnosis.names import Model
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
    rival: Model | None


def standing(model: Model, index: int, without: Model, alternatives: list[Model], inflation: float = 1.0) -> Standing:
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
    nearest: Model | None = None
    for other in others.values():
        extra = [e for e in other.effects if e.key not in {m.key for m in model.effects}]
        agrees = any(e.physics == chosen.physics and e.component == chosen.component for e in extra)
        same.append(agrees)
        for effect in extra:
            if effect.physics != chosen.physics:
                gap = (other.misfit - model.misfit) / inflation
                rivals[effect.physics] = min(gap, rivals.get(effect.physics, np.inf))
                if gap < OPTIONS.indistinguishable and (nearest is None or other.misfit < nearest.misfit):
                    nearest = other
    probability = OPTIONS.most * float(weights[np.array(same)].sum() / weights.sum())
    close = sorted((gap, physics) for physics, gap in rivals.items() if gap < OPTIONS.indistinguishable)
    return Standing(probability, tuple(physics for _, physics in close), nearest)

"""When a model counts as an explanation, and when it only imitates something that the library lacks.

Whatever is in no library is imitated by what is, the better the more effects may stand together. Four things betray an
imitation: it leaves a misfit over; it predicts badly what was not fitted; it needs values that no machine has; it needs
many effects. On development sets of 30 mechanisms outside the library (`research/benchmarks/concealed`), imitations
left between 7 and 100 % of the excess of χ² over, but for one that touched a single row. So an excess of which
`residual_share` would show above the noise is needed before as many effects are believed as the search allows, since a
single unknown cause is more likely beforehand than that number of known ones at once.
"""

import numpy as np

from expdesign.diagnosis.held_out import HeldOut
from expdesign.diagnosis.names import NamedModel, Names
from expdesign.diagnosis.options import OPTIONS
from expdesign.diagnosis.possible import at_limit
from expdesign.estimation.goodness import StatementOfFit, allows


def verdict_without(statement: StatementOfFit) -> str:
    """Verdict where nothing was found."""
    return "unexplained" if statement.refuted else "consistent"


def verdict_with_laws(errors: HeldOut) -> str:
    """Verdict where laws at ports are predicted with: whether they bring rows that were not fitted to the noise."""
    return "unexplained" if errors.test_surprise > OPTIONS.predicts else "modelled"


def doubt(names: Names, model: NamedModel, before: tuple[float, int], after: tuple[float, int], errors: HeldOut) -> str:
    """Why a model with effects is no explanation; empty where it is one.

    Args:
        names: among which it was found.
        model: the model.
        before: χ² and degrees of freedom of the base model.
        after: the same of this model.
        errors: on rows that were not fitted.
    """
    if beyond := at_limit(model.fit, names.reach) or names.at_limit(model):
        return f"{beyond} at or beyond the limit of what a machine can be describes the recordings better"
    if errors.test_surprise > OPTIONS.predicts:
        return "recordings that were not fitted are not predicted"
    if open_size := undetermined(model):
        return f"how large {open_size} is cannot be told"
    many = len(model.candidates) >= names.most_effects
    if not names.known_noise:
        return "so many effects at once imitate something else" if many else ""
    if not fits(before, after):
        return "a mismatch remains"
    remains = OPTIONS.remainder * (before[0] / before[1] - 1.0) * after[1]
    visible = remains > OPTIONS.shows * np.sqrt(2.0 * after[1])
    if many and not (visible and within_noise(after)):
        return "so many effects at once may imitate something else"
    return ""


def within_noise(after: tuple[float, int]) -> bool:
    """Whether χ² (with its degrees of freedom) is that of noise."""
    return allows(*after)


def fits(before: tuple[float, int], after: tuple[float, int]) -> bool:
    """Whether what remains of a mismatch is within the noise, or a small share of it."""
    remaining, excess = after[0] / after[1] - 1.0, before[0] / before[1] - 1.0
    return within_noise(after) or remaining <= OPTIONS.remainder * excess


def undetermined(model: NamedModel) -> str:
    """The key of an effect whose parameters together differ from none by less than they are known; empty without one.

    An effect takes away what it does by its size. One that may have any size, none included, while others beside it
    make up for that, is a direction in which something else was bent. What several axes have in common may be any
    spring's: the differences count then.
    """
    for candidate, part in zip(model.candidates, model.fit.chain.slices, strict=True):
        effect = candidate.effect
        free = np.array([not parameter.shape for parameter in effect.parameters])
        chosen = np.arange(part.start, part.stop)[free]
        away = (model.fit.values[part] - effect.neutral())[free]
        if model.fit.estimable.distance(chosen, away) < OPTIONS.noticeable:
            return effect.key
    return ""

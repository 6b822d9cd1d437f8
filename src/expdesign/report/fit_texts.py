"""What is said of a fit wherever it is said: the statement of fit, the worst row, and how well left-out rows lie."""

import math

from expdesign.diagnosis.result import Diagnosis
from expdesign.estimation.identify import Identification
from expdesign.report import words


def fit_sentences(result: Identification) -> list[str]:
    """What the statement of fit says, in words."""
    goodness = result.goodness
    model = "the base model" if result.geometry is None else "the model with its geometry"
    texts = [words.sentence(goodness.sentence(model))]
    if goodness.refuted and not goodness.only_outliers:
        texts.append("Physics is left out, or the noise is larger than stated: run `expdesign diagnose`.")
    if goodness.widened:
        texts.append(goodness.widened)
    if goodness.chi2 is None:
        texts.append("The noise was estimated from the recordings, and the intervals allow for that.")
    if goodness.worst is not None:
        texts.append(goodness.worst.sentence)
    return texts


def diagnosed_fit_sentences(result: Diagnosis) -> list[str]:
    """What the statements of fit say of the base model and of the model that was found, in words."""
    texts = [words.sentence(result.before.sentence())]
    if result.after is not result.before:
        texts.append(words.sentence(result.after.sentence("the model that was found")))
    if result.before.worst is not None:
        texts.append(result.before.worst.sentence)
    factor = result.widening.parameters
    if factor > 1.0:
        texts.append(f"Predicted standard deviations are {factor:.3g} times wider than the stated noise makes them.")
    return texts


def coverage_sentence(share: float) -> str:
    """How many readings that were not fitted lie where they were predicted; empty where none has an interval."""
    if not math.isfinite(share):
        return ""
    return (
        f"{100.0 * share:.1f} % of the readings that were not fitted lie within their 95 % intervals, that of the "
        "prediction and the noise of a reading together (`expdesign predict --readings`)."
    )

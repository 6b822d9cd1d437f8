"""Sentences about a fit: what `identify` says, and what a page says of the statement of fit."""

from typing import TYPE_CHECKING

import numpy as np

from expdesign.arrays import BoolArray, FloatArray
from expdesign.estimation.goodness import StatementOfFit
from expdesign.estimation.identify import Identification
from expdesign.estimation.remarks import IdleActuators
from expdesign.estimation.weighed import WeighedLoads
from expdesign.probabilities import p_text
from expdesign.report import words
from expdesign.report.arm_section import arm_sentences
from expdesign.report.identification_tables import rms

if TYPE_CHECKING:  # an identification needs neither diagnosis nor planning
    from expdesign.diagnosis.result import Diagnosis


def fit_sentences(result: Identification) -> list[str]:
    """What the statement of fit says, in words."""
    goodness = result.goodness
    model = "the base model" if result.geometry is None else "the model with its geometry"
    texts = [words.sentence(goodness.sentence(model))]
    if goodness.left is not None and goodness.left.beyond:
        texts.append("The robot file is of another machine, or the columns mean something else.")
    elif goodness.refuted and not goodness.only_outliers:
        stated = goodness.chi2 is not None or goodness.exceeded is not None
        noise = ", or the noise is larger than stated" if stated else ""
        texts.append(f"Physics is missing{noise}: run `expdesign diagnose`.")
    if goodness.widened:
        texts.append(goodness.widened)
    if goodness.chi2 is None:
        texts.append("The noise was estimated from the recordings; the intervals allow for this.")
    if result.loads is not None:
        texts.append(loads_sentence(result.loads))
    if goodness.worst is not None:
        texts.append(goodness.worst.sentence)
    lack = goodness.lack_of_fit
    if lack is not None and goodness.chi2 is not None:
        freedom = f"{lack.dof} and {lack.pure_dof} degrees of freedom"
        texts.append(
            f"Lack of fit against replicates: F = {words.number(lack.ratio)} with {freedom}, {p_text(lack.p_value)}."
        )
    return texts


def _diagnosed(statement: StatementOfFit, model: str, *, against: bool) -> str:
    """A statement of fit; where there is no test, what the diagnosis says against the model takes its place."""
    if against and statement.verdict == "noise estimated":
        return words.sentence(f"{statement.tested}; what the diagnosis found speaks against {model}.")
    return words.sentence(statement.sentence(model))


def diagnosed_fit_sentences(result: "Diagnosis") -> list[str]:
    """What the statements of fit say of the base model and of the model that was found, in words."""
    texts = [_diagnosed(result.before, "the base model", against=result.verdict != "consistent")]
    if result.before.worst is not None:
        texts.append(result.before.worst.sentence)
    if result.after is not result.before:
        texts.append(_diagnosed(result.after, "the diagnosed model", against=result.verdict == "unexplained"))
    if result.loads is not None:
        texts.append(loads_sentence(result.loads))
    factor = result.widening.parameters
    if factor > 1.0 and f"{factor:.3g}" != "1":
        noise = "estimated" if result.before.verdict == "noise estimated" else "stated"
        texts.append(f"Predicted standard deviations are {factor:.3g} times wider than the {noise} noise makes them.")
    return texts


def loads_sentence(loads: WeighedLoads) -> str:
    """How declared load errors count in a fit."""
    names = [" ".join(map(words.source, effect.name.split(" ", 1))) for effect in loads.effects]
    if loads.estimator == "weighted":
        return f"Declared load errors ({', '.join(names)}) widen the intervals; the estimate does not weigh them."
    scales = zip(names, loads.weights, loads.sizes, strict=True)
    taken = [f"{name} {weight:.2g} ({size:.2g} in the intervals)" for name, weight, size in scales]
    return (
        "The fit weighs the declared load errors. The recordings multiply their standard deviations by these factors: "
        f"{', '.join(taken)}."
    )


def coverage_sentence(share: float, *, loads: bool) -> str:
    """How many readings that were not fitted lie where they were predicted; whether errors of `loads` are declared."""
    beside = " These intervals do not include the declared errors of the loads." if loads else ""
    return (
        f"{100.0 * share:.1f} % of the held-out readings lie within their 95 % intervals, which include the "
        f"uncertainty of the prediction and the noise of a reading (`expdesign predict --readings`).{beside}"
    )


def identified_sentences(result: Identification) -> list[str]:
    """What recordings identify, how well, and how well the model fits them."""
    texts = [*_stiffness(result), *arm_sentences(result), *_geometry(result), *fit_sentences(result)]
    if result.prior is not None:
        size = words.number(100.0 * result.prior)
        texts.append(f"The prior is the robot file's compliances, with a standard deviation of {size} %.")
    for one in result.noise.groups:
        size = words.size(one.deviation, "rad" if one.name == "rotations" else "m")
        origin = f"{result.noise.origin} with {words.number(one.dof)} degrees of freedom"
        texts.append(f"Noise of the {one.name}, estimated from {origin}: {size}.")
    held_out = rms(result.test_residuals)
    if held_out is not None:
        predicted = f"are predicted to {words.number(held_out)} standard deviations (RMS)"
        texts += [
            f"The rows held out for testing {predicted}.",
            coverage_sentence(result.coverage, loads=result.loads is not None),
        ]
    return texts


def stiffness_known(result: Identification) -> tuple[FloatArray, BoolArray]:
    """Relative standard deviation of every actuator's stiffness, and whether more than a lower limit is known.

    Shapes (n_p,).
    """
    relative = np.sqrt(np.diag(result.covariance)) / np.abs(result.compliance.estimate)
    return relative, ~np.isin(result.robot.actuators, _idle(result)) & np.isfinite(result.stiffness.high)


def _idle(result: Identification) -> list[str]:
    return [name for each in result.suspicions if isinstance(each, IdleActuators) for name in each.actuators]


def _stiffness(result: Identification) -> list[str]:
    if not result.robot.actuators:
        return [
            f"A {result.robot.kind} has no actuators whose stiffness could be identified: its base model does not "
            "deflect at all. `expdesign diagnose` finds what yields."
        ]
    if result.calibration == "geometric":
        return ["The geometry was identified from rows without load; stiffness is what the robot file says."]
    (relative, known), idle = stiffness_known(result), _idle(result)
    limited = ~known & ~np.isin(result.robot.actuators, idle)  # the compliance may be 0
    worst = int(np.argmax(np.where(known, relative, -1.0)))
    count = f"all {len(relative)}" if known.all() else f"{known.sum()} of {len(relative)}"
    names = np.array(result.robot.actuators)
    size = f"{100.0 * relative[worst]:.2f} % (one standard deviation)"
    last = f", the worst ({names[worst]}) to {size}" if known.any() else ""
    last += f"; of {words.listed(list(names[limited]))} only a lower limit" if limited.any() else ""
    last += f"; no load acts on {words.listed(idle)}" if idle else ""
    return [f"The recordings identify {count} stiffnesses{last}."]


def _geometry(result: Identification) -> list[str]:
    if result.geometry is None or result.arm is not None:
        return []
    deviation = (result.geometry.high - result.geometry.low) / 4.0
    size = float(np.sqrt((result.geometry.estimate**2).mean()))
    known = f"standard deviation {words.size(float(np.median(deviation)), 'm')} (median)"
    return [f"{len(deviation)} errors of joints and lengths: {words.size(size, 'm')} RMS, {known}."]

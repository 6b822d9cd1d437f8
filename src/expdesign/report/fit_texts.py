"""Sentences on pages and terminals: of a configuration, of a fit, and of an identification."""

import math
from typing import TYPE_CHECKING

import numpy as np

from expdesign.counted import counted
from expdesign.estimation.goodness import StatementOfFit
from expdesign.estimation.identify import Identification
from expdesign.estimation.remarks import BeyondManufacture, IdleActuators, Implausible
from expdesign.report import words
from expdesign.report.arm_section import accuracy_lines, further_lines, geometry_line
from expdesign.report.identification_tables import rms
from expdesign.report.options import SHOWN
from expdesign.report.remark_texts import sentences
from expdesign.report.stiffness import identified_stiffness, stiffness_lines

if TYPE_CHECKING:  # an identification needs neither diagnosis nor planning
    from expdesign.diagnosis.result import Diagnosis
    from expdesign.planning.problem import DesignProblem
    from expdesign.planning.sampling import Feasibility


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
        texts.append(result.loads.sentence)
    if goodness.worst is not None:
        texts.append(goodness.worst.sentence)
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
        texts.append(_diagnosed(result.after, "the model that was found", against=result.verdict == "unexplained"))
    factor = result.widening.parameters
    if factor > 1.0 and f"{factor:.3g}" != "1":
        noise = "estimated" if result.before.verdict == "noise estimated" else "stated"
        texts.append(f"Predicted standard deviations are {factor:.3g} times wider than the {noise} noise makes them.")
    return texts


def coverage_sentence(share: float) -> str:
    """How many readings that were not fitted lie where they were predicted; empty where none has an interval."""
    if not math.isfinite(share):
        return ""
    return (
        f"{100.0 * share:.1f} % of the held-out readings lie within their 95 % intervals, which include the "
        "uncertainty of the prediction and the noise of a reading (`expdesign predict --readings`)."
    )


def problem_summary(problem: "DesignProblem", found: "Feasibility") -> str:
    """What a configuration asks for, and how much of its design space serves."""
    space = problem.space
    continuous = int((~space.discrete).sum())
    discrete = int(space.choices.sum())
    measurements = counted(space.measurements, "measurement")
    if problem.budget is not None:  # what fits into it
        number = counted(problem.budget.largest, "measurement")
        measurements = f"at most {number}, as many as {problem.budget.minutes:g} minutes allow,"
    share = f"{found.identifying:.0%} of the random plans that were tried determine"
    identifying = "every random plan that was tried determines" if found.identifying == 1.0 else share
    return (
        f"{problem.loaded.robot.kind} `{problem.loaded.robot.name}`, {measurements} with "
        f"{continuous} continuous and {discrete} discrete variables each, "
        f"{counted(len(problem.targets.weights), 'target')}; {found.reachable:.0%} of the poses can be reached, "
        f"{identifying} what the targets need."
    )


def problem_remarks(problem: "DesignProblem", found: "Feasibility") -> tuple[str, ...]:
    """What is to be known about a configuration before it is run."""
    remarks = problem_doubts(problem, found)
    return remarks if problem.found is None else (*remarks, f"{problem.source}: {problem.found.note}")


def problem_doubts(problem: "DesignProblem", found: "Feasibility") -> tuple[str, ...]:
    """What should be looked at before anything is planned."""
    remarks = []
    if found.reachable < SHOWN.few_poses:
        remarks.append("hardly any pose in `experiment.poses` can be reached; check their units (m, rad)")
    return tuple(f"{problem.source}: {remark}" for remark in remarks)


def identified_sentences(result: Identification) -> list[str]:
    """What recordings identify, and how well: the stiffness of every actuator, the geometry, or both."""
    texts = []
    if result.calibration != "geometric":
        relative = np.sqrt(np.diag(result.covariance)) / np.abs(result.compliance.estimate)
        idle = [name for each in result.suspicions if isinstance(each, IdleActuators) for name in each.actuators]
        shown = np.array([name not in idle for name in result.robot.actuators])
        limited = shown & ~np.isfinite(result.stiffness.high)  # the compliance may be 0
        known = shown & ~limited
        worst = int(np.argmax(np.where(known, relative, -1.0)))
        count = f"all {len(relative)}" if known.all() else f"{known.sum()} of {len(relative)}"
        names = np.array(result.robot.actuators)
        last = f", the worst ({names[worst]}) to {relative[worst]:.2%} (one standard deviation)" if known.any() else ""
        last += f"; of {words.listed(list(names[limited]))} only a lower limit" if limited.any() else ""
        last += f"; no load acts on {words.listed(idle)}" if idle else ""
        texts.append(f"They identify {count} stiffnesses{last}.")
    if result.arm is not None:
        line = geometry_line(result)
        texts += [
            f"{words.sentence(text)}." for text in [*([] if line is None else [line]), *accuracy_lines(result.arm)]
        ]
    elif result.geometry is not None:
        half = (result.geometry.high - result.geometry.low) / 2.0
        texts.append(
            f"They identify {counted(half.size, 'parameter')} of the geometry, with 95 % intervals of "
            f"±{words.size(float(half.min()), 'm')} to ±{words.size(float(half.max()), 'm')}."
        )
    return texts + fit_sentences(result)


def identification_lines(result: Identification) -> list[str]:
    """What was identified, with 95 % intervals, and how well it fits."""
    first = sentences(each for each in result.suspicions if isinstance(each, BeyondManufacture))
    lines = [*first, *_geometry(result), *_stiffness(result), *fit_sentences(result)]
    noise = result.noise
    lines += [
        f"noise of the {one.name}, estimated from {noise.origin}: {words.size(one.deviation, _noise_unit(one.name))}"
        for one in noise.groups
    ]
    held_out = rms(result.test_residuals)
    if held_out is not None:
        lines += [f"RMS of the test rows: {held_out:.3g} standard deviations", coverage_sentence(result.coverage)]
    return lines


def _noise_unit(group: str) -> str:
    return "rad" if group == "rotations" else "m"


def identification_warnings(result: Identification) -> list[str]:
    """What is doubtful, beside what is said of the recordings where they are read, and before anything else."""
    doubts = [each for each in result.suspicions if not isinstance(each, Implausible | BeyondManufacture)]
    return [f"warning: {text}" for text in sentences(doubts)]


def _geometry(result: Identification) -> list[str]:
    if result.arm is not None:
        line = geometry_line(result)
        return [*([line] if line else []), *further_lines(result.arm), *accuracy_lines(result.arm)]
    if result.geometry is None:
        return []
    deviation = (result.geometry.high - result.geometry.low) / 4.0
    size = float(np.sqrt((result.geometry.estimate**2).mean()))
    known = f"known to {words.size(float(np.median(deviation)), 'm')} (median)"
    return [f"{len(deviation)} errors of joints and lengths: {words.size(size, 'm')} RMS, {known}"]


def _stiffness(result: Identification) -> list[str]:
    if not result.robot.actuators:
        return [f"a {result.robot.kind} has no actuators whose stiffness could be identified: does it deflect at all?"]
    if result.calibration == "geometric":
        return []
    return stiffness_lines(identified_stiffness(result), result.robot)

"""What `expdesign check` says of a file, in words.

What is said of a fit wherever it is said: the statement of fit, the worst row, and how well left-out rows lie.
"""

import math
from typing import TYPE_CHECKING

import numpy as np

from expdesign.counted import counted
from expdesign.estimation.identify import Identification
from expdesign.estimation.remarks import IdleActuators
from expdesign.planning.feasibility import Feasibility
from expdesign.planning.problem import DesignProblem
from expdesign.report import words
from expdesign.report.arm_section import accuracy_lines, geometry_line

if TYPE_CHECKING:
    from expdesign.diagnosis.result import Diagnosis


def fit_sentences(result: Identification) -> list[str]:
    """What the statement of fit says, in words."""
    goodness = result.goodness
    model = "the base model" if result.geometry is None else "the model with its geometry"
    texts = [words.sentence(goodness.sentence(model))]
    if goodness.refuted and not goodness.only_outliers:
        texts.append("Physics is missing, or the noise is larger than stated: run `expdesign diagnose`.")
    if goodness.widened:
        texts.append(goodness.widened)
    if goodness.chi2 is None:
        texts.append("The noise was estimated from the recordings; the intervals allow for this.")
    if goodness.worst is not None:
        texts.append(goodness.worst.sentence)
    return texts


def diagnosed_fit_sentences(result: "Diagnosis") -> list[str]:
    """What the statements of fit say of the base model and of the model that was found, in words."""
    texts = [words.sentence(result.before.sentence())]
    if result.before.worst is not None:
        texts.append(result.before.worst.sentence)
    if result.after is not result.before:
        texts.append(words.sentence(result.after.sentence("the model that was found")))
    factor = result.widening.parameters
    if factor > 1.0:
        texts.append(f"Predicted standard deviations are {factor:.3g} times wider than the stated noise makes them.")
    return texts


def coverage_sentence(share: float) -> str:
    """How many readings that were not fitted lie where they were predicted; empty where none has an interval."""
    if not math.isfinite(share):
        return ""
    return (
        f"{100.0 * share:.1f} % of the held-out readings lie within their 95 % intervals, which include the "
        "uncertainty of the prediction and the noise of a reading (`expdesign predict --readings`)."
    )


_FEW = 0.01
"""Share of reachable poses below which the units of `experiment.poses` are probably wrong."""


def problem_summary(problem: DesignProblem, found: Feasibility) -> str:
    """What a configuration asks for, and how much of its design space serves."""
    space = problem.space
    continuous = int((~space.discrete).sum())
    discrete = int(space.choices.sum())
    return (
        f"{problem.loaded.robot.kind} `{problem.loaded.robot.name}`, {_measurements(problem)} with "
        f"{continuous} continuous and {discrete} discrete variables each, "
        f"{counted(len(problem.targets.weights), 'target')}; {found.reachable:.0%} of the poses can be reached, "
        f"{_identifying(found.identifying)}"
    )


def _measurements(problem: DesignProblem) -> str:
    """How many measurements a plan has; under a budget, what fits into it."""
    if problem.budget is None:
        return counted(problem.space.measurements, "measurement")
    number = counted(problem.budget.largest, "measurement")
    return f"at most {number}, as many as {problem.budget.minutes:g} minutes allow,"


def _identifying(share: float) -> str:
    if share == 1.0:
        return "every random plan that was tried determines what the targets need."
    return f"{share:.0%} of the random plans that were tried determine what the targets need."


def problem_remarks(problem: DesignProblem, found: Feasibility) -> tuple[str, ...]:
    """What is doubtful about a configuration."""
    remarks = []
    if found.reachable < _FEW:
        remarks.append("hardly any pose in `experiment.poses` can be reached; check their units (m, rad)")
    if problem.found is not None:
        remarks.append(problem.found.note)
    return tuple(f"{problem.source}: {remark}" for remark in remarks)


def identified_sentences(result: Identification) -> list[str]:
    """What recordings identify, and how well: the stiffness of every actuator, the geometry, or both."""
    texts = []
    if result.calibration != "geometric":
        relative = np.sqrt(np.diag(result.covariance)) / np.abs(result.compliance.estimate)
        idle = [name for each in result.suspicions if isinstance(each, IdleActuators) for name in each.actuators]
        shown = np.array([name not in idle for name in result.robot.actuators])
        worst = int(np.argmax(np.where(shown, relative, -1.0)))
        count = f"all {len(relative)}" if shown.all() else f"{shown.sum()} of {len(relative)}"
        without = f"; no load acts on {' and '.join(idle)}" if idle else ""
        texts.append(
            f"They identify {count} stiffnesses, the worst "
            f"({result.robot.actuators[worst]}) to {relative[worst]:.2%} (one standard deviation){without}."
        )
    if result.arm is not None:
        line = geometry_line(result)
        texts += [
            f"{words.sentence(text)}." for text in [*([] if line is None else [line]), *accuracy_lines(result.arm)]
        ]
    elif result.geometry is not None:
        half = (result.geometry.high - result.geometry.low) / 2.0
        texts.append(
            f"They identify {counted(half.size, 'parameter')} of the geometry, with 95 % intervals of "
            f"±{1e6 * half.min():.3g} to ±{1e6 * half.max():.3g} µm."
        )
    return texts + fit_sentences(result)

"""Sections of the page of `expdesign run` that are words only: what to do next, and what the words mean."""

import shlex

from expdesign.design.front import Front
from expdesign.design.problem import DesignProblem
from expdesign.elastostatics.regressors.elastostatic import Elastostatic
from expdesign.report import words
from expdesign.report.blocks import Definitions, Paragraph, Section, Steps


def next_steps(problem: DesignProblem, front: Front) -> Section:
    """The way from the plan to a compensated robot, with the commands."""
    config, robot = shlex.quote(problem.source), shlex.quote(problem.robot_file or "ROBOT.yaml")
    which = "" if problem.robot_file else " (ROBOT.yaml is the robot's file)"
    columns = ", ".join(problem.loaded.robot.coordinates.deflection)
    steps: tuple[tuple[str, str], ...] = (
        (
            f"Judge the plan once more, or one that you have changed. plan.csv beside this page holds the recommended "
            f"design {front.recommended + 1}; the plan of any other design is downloaded above.",
            f"expdesign evaluate {config} plan.csv --json",
        ),
        (
            "Rehearse: make recordings from the model with noise, and try the steps below on them.",
            f"expdesign simulate {config} plan.csv --out rehearsal.csv",
        ),
        (
            f"Measure. Take the rows in order, and add what was measured to plan.csv in the columns {columns} "
            "(those that the instrument gives), saved as recordings.csv. Check the file before leaving the laboratory.",
            "expdesign check recordings.csv",
        ),
        (
            f"Identify the stiffness of the actuators, with confidence intervals{which}, and see whether the targets "
            "are within their tolerances.",
            f"expdesign identify {robot} recordings.csv --targets {config} --out identified",
        ),
        (
            "Find out whether the recordings hold anything that the model leaves out.",
            f"expdesign diagnose {robot} recordings.csv --out diagnosed",
        ),
        (
            "Compute the commands that bring the loaded platform where it shall be.",
            "expdesign compensate identified/model.yaml targets.csv --out commands.csv",
        ),
    )
    if not isinstance(problem.loaded.regressor, Elastostatic):
        further = (
            "Measure the poses of plan.csv against the commanded ones, and identify the "
            f"{problem.loaded.regressor.noun} "
            "with your own calibration program: expdesign identifies stiffness only, and says here what to expect."
        )
        return Section("next", "What to do next", (Steps(steps[:1]), Paragraph(further)))
    return Section("next", "What to do next", (Steps(steps),))


def vocabulary(front: Front) -> Section:
    """The words of the page, for a reader who has not met them."""
    items = [
        ("Deflection", "How far the platform moves when the load is put on, at the same command of the actuators."),
        (
            "Tolerance",
            "The error that the configuration accepts on an axis of a target. 1 tolerance = just acceptable.",
        ),
        ("RMS, σ", "Root mean square error, one standard deviation: about two of three outcomes lie within it."),
        ("DUIR", "RMS error at the targets after calibration that comes from the noise of the measured deflections."),
        ("FEIR", "RMS error at the targets that comes from loads in the experiment that are not exactly as assumed."),
        ("total", "Both together: the RMS error to expect at the targets after calibration and compensation."),
        ("Front", "The designs of which none is better than another in every objective."),
        ("Recommended", "The design on the front with the least total error."),
        ("Knee", "The design nearest to the best of every objective at once when each is scaled over the front."),
        ("Hypervolume", "How much of the space of objectives the front dominates; it grows as the search improves."),
    ]
    observability = [name for name in front.criteria if name in ("o1", "o2", "o3", "o4", "o5")]
    if observability:
        text = "Observability indices: how well all stiffnesses are determined, wherever the targets are."
        items.insert(6, (" ".join(words.criterion(name) for name in observability), f"{text} Larger is better."))
    tests = [name for name in front.criteria if name.startswith(("o_tp", "o_mv"))]
    if tests:
        text = "Variance of the attained position due to noise: at the first target, and over the targets (m²)."
        items.insert(7, (" ".join(words.criterion(name) for name in tests), text))
    if "meir" in front.criteria:
        text = "The largest error at the targets that physics beyond the model could cause before the plan shows it."
        items.insert(6, ("MEIR", text))
    return Section("words", "What the words mean", (Definitions(items),))

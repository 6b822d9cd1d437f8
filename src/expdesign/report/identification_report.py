"""The page of `expdesign identify`: stiffness, how well it is known, and how well the model fits the recordings."""

import shlex
from collections.abc import Sequence

import numpy as np

from expdesign.estimation.identify import Identification
from expdesign.probabilities import p_text
from expdesign.report import words
from expdesign.report.arm_section import accuracy_lines, arm_sections
from expdesign.report.blocks import (
    Block,
    Definitions,
    KeyFigure,
    KeyFigures,
    NextSteps,
    PageSection,
    Sentences,
    model_steps,
)
from expdesign.report.fit_texts import coverage_sentence, fit_sentences
from expdesign.report.identification_tables import (
    SCRIPT,
    geometry_section,
    measurement_table,
    residual_blocks,
    residual_data,
    rms,
)
from expdesign.report.page import Page
from expdesign.report.remark_texts import sentences
from expdesign.report.robot_section import SCRIPTS, picture
from expdesign.report.robot_view import at_rest
from expdesign.report.stiffness import identified_stiffness, stiffness_figure, stiffness_table, stiffness_unit

_TITLES = {"elastostatic": "Stiffness", "geometric": "Geometry", "both": "Geometry and stiffness"}
_CONTRIBUTED = "What each measurement contributed"
_PICTURE = "The robot at the middle of the recorded poses."


def identification_report(
    result: Identification, robot_file: str = "", configuration: str = "", further: Sequence[PageSection] = ()
) -> Page:
    """The report of an identification.

    Args:
        result: what was found.
        robot_file: path of the robot's file, for the commands; empty where it is not known.
        configuration: path of the run configuration whose targets count; empty where it is not known.
        further: sections on what the identification means for the targets; they stand behind the fit.
    """
    train = result.recordings.rows(result.fitted)
    robot = result.robot
    drawn, view = picture(robot, at_rest(robot, np.median(train.configurations, axis=0)), note=_PICTURE)
    sections = (
        PageSection("result", "Result", [Sentences(_conclusions(result)), _key_figures(result)]),
        PageSection("stiffness", "Stiffness", _stiffness(result)),
        *(arm_sections(result) if result.arm is not None else []),
        *([geometry_section(result)] if result.geometry is not None and result.arm is None else []),
        PageSection("fit", "How well the model fits", [Definitions(_tests(result)), *residual_blocks(result, train)]),
        *further,
        PageSection("measurements", _CONTRIBUTED, [measurement_table(result)] if robot.actuators else []),
        PageSection("machine", "The robot", drawn),
        PageSection("next", "Next steps", [_next_steps(result, robot_file, configuration)]),
        PageSection("words", "Words", [Definitions(_WORDS)]),
    )
    return Page(
        title=f"{_TITLES[result.calibration]} of {robot.name}",
        subtitle=(
            f"{robot.kind}, {words.count(len(train), 'fitted measurement')} of "
            f"{words.count(len(result.recordings), 'row')}; recordings {result.recordings.source}"
        ),
        sections=sections,
        data=residual_data(result, train) | view,
        scripts=(*(SCRIPTS if view else ()), SCRIPT),
    )


def _stiffness(result: Identification) -> list[Block]:
    if not result.robot.actuators or result.calibration == "geometric":
        return []
    about = "with 95 % intervals; compliance is its inverse."
    return [stiffness_figure(result), stiffness_table(identified_stiffness(result), result.robot, about)]


def _least_certain(result: Identification) -> str:
    """What is known worst; of a robot without actuators, that there is nothing to identify."""
    interval, names = result.stiffness, result.robot.actuators
    unit, _, factor = words.stiffness(stiffness_unit(result.robot))
    if not names:
        return (
            f"A {result.robot.kind} has no actuators whose stiffness could be identified: its base model does not "
            "deflect at all, and what follows says whether the recordings show that it does. `expdesign diagnose` "
            "finds what yields."
        )
    if result.calibration == "geometric":
        return "The geometry was identified from rows without load; stiffness is what the robot file says."
    relative = np.sqrt(np.diag(result.covariance)) / np.abs(result.compliance.estimate)
    worst = int(np.argmax(relative))
    return (
        f"The least certain stiffness is that of {names[worst]}: {words.number(factor * interval.estimate[worst])} "
        f"{unit}, known to {words.number(100.0 * relative[worst], 2)} % (one standard deviation)."
    )


def _conclusions(result: Identification) -> list[str]:
    texts = [_least_certain(result)]
    texts += fit_sentences(result)
    held_out = rms(result.test_residuals)
    if held_out is not None:
        texts.append(f"The rows held out for testing are predicted to {words.number(held_out)} standard deviations.")
        texts.append(coverage_sentence(result.coverage))
    if result.arm is not None:
        texts += [f"{words.sentence(line)}." for line in accuracy_lines(result.arm)]
    return texts + sentences(result.suspicions)


def _key_figures(result: Identification) -> KeyFigures:
    train, held_out = rms(result.fit.residuals), rms(result.test_residuals)
    identified = result.calibration != "geometric"
    relative = np.sqrt(np.diag(result.covariance)) / np.abs(result.compliance.estimate) if identified else np.zeros(0)
    items = [KeyFigure("Residuals", words.number(train or 0.0), "standard deviations", "RMS; 1 is the noise")]
    if relative.size:
        items += [
            KeyFigure("Worst stiffness", words.number(100.0 * float(relative.max()), 2), "%", "one standard deviation"),
            KeyFigure("Rank", f"{result.fit.rank} of {len(result.fit.values)}", "", "stiffnesses determined"),
        ]
    if held_out is not None:
        items.append(KeyFigure("Held-out rows", words.number(held_out), "standard deviations", "RMS"))
    return KeyFigures(items)


def _tests(result: Identification) -> list[tuple[str, str]]:
    goodness, noise, lack = result.goodness, result.noise, result.goodness.lack_of_fit
    chi2 = "none: the noise level was estimated from these recordings"
    if goodness.chi2 is not None and goodness.p_value is not None:
        chi2 = (
            f"{words.number(goodness.chi2, 4)} for {goodness.dof} degrees of freedom, "
            f"{p_text(goodness.p_value)} (refuted below {goodness.options.refuted:g})"
        )
    replicates = "none: there are no replicates"
    if lack is not None:
        freedom = f"{lack.dof} and {lack.pure_dof} degrees of freedom"
        replicates = f"F = {words.number(lack.ratio)} with {freedom}, {p_text(lack.p_value)}"
    items = [("χ² test", chi2), ("Lack of fit", replicates)]
    for group in noise.groups:
        unit = "µm" if group.name == "translations" else "µrad"
        origin = "replicates" if noise.origin == "replicates" else "residuals"
        source = f"from the {origin} with {words.number(group.dof)} degrees of freedom"
        items.append((f"Noise of the {group.name}", f"{words.number(1e6 * group.deviation)} {unit}, {source}"))
    if result.prior is not None:
        items.append(("Prior", f"the robot file's compliances, known to {words.number(100.0 * result.prior)} %"))
    return items


def _next_steps(result: Identification, robot_file: str, configuration: str) -> NextSteps:
    recordings = shlex.quote(result.recordings.source)
    robot, config = shlex.quote(robot_file or "ROBOT.yaml"), shlex.quote(configuration or "CONFIG.yaml")
    targets = f" --targets {config}" if configuration else ""
    return NextSteps(
        [
            *model_steps(result.recordings.source, configuration),
            (
                "If the model does not fit, find out why.",
                f"expdesign diagnose {robot} {recordings}{targets} --out diagnosed",
            ),
            (
                "If the accuracy is not enough, measure on.",
                f"expdesign next {config} {recordings} --out plan-next.csv",
            ),
        ]
    )


_WORDS = [
    ("Stiffness", "Force in an actuator per change of its length; the base model is one spring per actuator."),
    (
        "95 % interval",
        "Covers the true value in 95 of 100 repetitions of the experiment, if the model holds. A stiffness' interval "
        "is the inverse of its compliance's, and so is not symmetric.",
    ),
    ("Standard deviation (σ)", "Size of the noise: two thirds of the errors are smaller."),
    ("Replicates", "Rows with the same command under the same load; their scatter is noise and nothing else."),
]

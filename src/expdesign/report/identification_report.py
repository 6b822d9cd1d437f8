"""The page of `expdesign identify`: stiffness, how well it is known, and how well the model fits the recordings."""

from collections.abc import Sequence

import numpy as np

from expdesign.estimation.identify import Identification
from expdesign.estimation.remarks import BeyondManufacture
from expdesign.report import words
from expdesign.report.arm_section import arm_sections
from expdesign.report.blocks import KeyFigure, KeyFigures, PageSection, Sentences
from expdesign.report.fit_texts import stiffness_known
from expdesign.report.glossary import words_section
from expdesign.report.identification_tables import (
    SCRIPT,
    geometry_section,
    measurement_table,
    residuals,
    rms,
)
from expdesign.report.next_steps import next_steps
from expdesign.report.page import Page
from expdesign.report.remark_texts import sentences
from expdesign.report.robot_section import SCRIPTS, picture
from expdesign.report.robot_view import at_rest
from expdesign.report.said import Said
from expdesign.report.stiffness import stiffness_figure

_TITLES = {"elastostatic": "Stiffness", "geometric": "Geometry", "both": "Geometry and stiffness"}
_CONTRIBUTED = "What each measurement contributed"
_PICTURE = "The robot at the middle of the recorded poses."


def identification_report(
    result: Identification,
    said: Said,
    robot_file: str = "",
    configuration: str = "",
    further: Sequence[PageSection] = (),
    acceptance: KeyFigure | None = None,
) -> Page:
    """The report of an identification.

    Args:
        result: what was found.
        said: what is said of it (`identified`).
        robot_file: path of the robot's file, for the commands; empty where it is not known.
        configuration: path of the run configuration whose targets count; empty where it is not known.
        further: sections on what the identification means for the targets; they stand behind the fit.
        acceptance: the verdict at the targets of the configuration.
    """
    train = result.recordings.rows(result.fitted)
    robot = result.robot
    drawn, view = picture(robot, at_rest(robot, np.median(train.configurations, axis=0)), note=_PICTURE)
    fit, data = residuals(result, train)
    files = {"robot": robot_file, "config": configuration, "recordings": result.recordings.source}
    stiffness = [table for table in said.tables if table.id == "stiffness-table"]
    doubts = sentences(each for each in result.suspicions if not isinstance(each, BeyondManufacture))
    sections = (
        said.section("Result", *([Sentences(doubts)] if doubts else []), _key_figures(result, acceptance)),
        PageSection("stiffness", "Stiffness", [stiffness_figure(result), *stiffness] if stiffness else []),
        *(arm_sections(result) if result.arm is not None else []),
        *([geometry_section(result)] if result.geometry is not None and result.arm is None else []),
        PageSection("fit", "How well the model fits", fit),
        *further,
        PageSection("measurements", _CONTRIBUTED, [measurement_table(result)] if robot.actuators else []),
        PageSection("machine", "The robot", drawn),
        next_steps("predict", "compensate", "verify", "diagnose", "next", **files),
        words_section("Stiffness", "95 % interval", "Standard deviation", "Replicates"),
    )
    return Page(
        title=f"{_TITLES[result.calibration]} of {robot.name}",
        subtitle=(
            f"{robot.kind}, {words.count(len(train), 'fitted measurement')} of "
            f"{words.count(len(result.recordings), 'row')}; recordings {result.recordings.source}"
        ),
        sections=sections,
        data=data | view,
        scripts=(*(SCRIPTS if view else ()), SCRIPT),
    )


def _key_figures(result: Identification, acceptance: KeyFigure | None) -> KeyFigures:
    train, held_out = rms(result.fit.residuals), rms(result.test_residuals)
    items = [] if acceptance is None else [acceptance]
    items += [KeyFigure("Residuals", words.number(train or 0.0), "standard deviations", "RMS; 1 is the noise")]
    if result.calibration != "geometric" and result.robot.actuators:
        relative, known = stiffness_known(result)
        if known.any():
            worst = f"{100.0 * float(relative[known].max()):.2f}"
            items.append(KeyFigure("Least certain stiffness", worst, "%", "one standard deviation"))
        items.append(KeyFigure("Stiffnesses", f"{known.sum()} of {len(known)}", "", "determined"))
    if held_out is not None:
        items.append(KeyFigure("Held-out rows", words.number(held_out), "standard deviations", "RMS"))
    return KeyFigures(items)

"""What `identify` returns and its page: stiffness, how well it is known, and how well the model fits the recordings."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray
from expdesign.chain.recordings.recordings import Remark
from expdesign.counted import counted
from expdesign.estimation.arm_outcome import calibrated_urdf
from expdesign.estimation.identify import Identification
from expdesign.estimation.intervals import Intervals
from expdesign.estimation.remarks import BeyondManufacture, Implausible
from expdesign.report import words
from expdesign.report.arm_section import accuracy_table, arm_sections
from expdesign.report.blocks import KeyFigure, KeyFigures, PageSection, Sentences
from expdesign.report.fit_texts import identified_sentences, stiffness_known
from expdesign.report.glossary import words_section
from expdesign.report.identification_tables import (
    SCRIPT,
    geometry_section,
    identification_record,
    measurement_table,
    residuals,
    rms,
)
from expdesign.report.next_steps import next_steps
from expdesign.report.page import Page
from expdesign.report.remark_texts import sentences
from expdesign.report.result import PAGE, RecordedResult
from expdesign.report.robot_section import SCRIPTS, picture
from expdesign.report.robot_view import at_rest
from expdesign.report.said import Said
from expdesign.report.stiffness import identified_stiffness, stiffness_figure, stiffness_table, stiffness_unit

_TITLES = {"elastostatic": "Stiffness", "geometric": "Geometry", "both": "Geometry and stiffness"}
_CONTRIBUTED = "What each measurement contributed"
_PICTURE = "The robot at the middle of the recorded poses."


@dataclass(frozen=True, repr=False)
class IdentificationResult(RecordedResult):
    """An identified robot; `at_targets` says what may be hidden where the configuration asks for MEIR.

    Attributes:
        result: everything that the identification found.
        accepted: whether corrections beyond manufacture are.
    """

    FILES: ClassVar = {"model.yaml": "model", "identification.json": "record", **PAGE, "robot.urdf": "urdf"}
    result: Identification
    accepted: bool = False

    @property
    def said(self) -> Said:
        result = self.result
        goodness, further = result.goodness, Said("", []) if self.at_targets is None else self.at_targets.said
        summary = f"{counted(len(result.robot.actuators), 'actuator')} of {result.robot.name}"
        if goodness.chi2 is not None and goodness.p_value is not None:
            summary += f", chi2 {goodness.chi2:.4g} for {goodness.dof}, p = {goodness.p_value:.3g}"
        first = sentences(each for each in result.suspicions if isinstance(each, BeyondManufacture))
        # What is said of the recordings where they are read is not said again.
        doubts = sentences(each for each in self._doubts if not isinstance(each, Implausible))
        tables = [] if result.arm is None else [accuracy_table(result.arm)]
        if result.robot.actuators and result.calibration != "geometric":
            about = "with 95 % intervals; compliance is its inverse."
            tables.append(stiffness_table(identified_stiffness(result), result.robot, about))
        return Said(
            summary,
            [*first, *identified_sentences(result), *further.sentences],
            [f"warning: {text}" for text in doubts],
            lambda: identification_record(result) | dict(further.document()),
            tables,
        )

    @property
    def _doubts(self) -> list[Remark]:
        """All but the corrections beyond manufacture, which come first of all that is said."""
        return [each for each in self.result.suspicions if not isinstance(each, BeyondManufacture)]

    @property
    def refused(self) -> bool:
        """Whether the recordings fit only if they are read otherwise, or not at all; or corrections are unaccepted."""
        read = any(isinstance(each, Implausible) and each.otherwise for each in self.result.suspicions)
        return read or not self._written

    @property
    def _written(self) -> bool:
        """Whether no correction is beyond manufacture, or somebody accepts them."""
        return self.accepted or not any(isinstance(each, BeyondManufacture) for each in self.result.suspicions)

    @property
    def chi2(self) -> float | None:
        """χ² of the fit; None where the noise was estimated from the recordings."""
        return self.result.goodness.chi2

    @property
    def p_value(self) -> float | None:
        """Probability of a χ² as large as this if the model is right; None where there is no test."""
        return self.result.goodness.p_value

    @property
    def covariance(self) -> FloatArray:
        """Covariance of the compliances ((m/N)², or (rad/(N·m))²), in the order of `stiffness`."""
        return self.result.covariance

    @property
    def stiffness(self) -> pd.DataFrame:
        """Estimate and 95 % interval of every actuator's stiffness, by its name."""
        frame = _frame(self.result.stiffness, "actuator", self.result.robot.actuators)
        return frame.assign(unit=stiffness_unit(self.result.robot))

    @property
    def geometry(self) -> pd.DataFrame | None:
        """Estimate and 95 % interval of every error of the geometry (m or rad), or None where it is nominal."""
        interval = self.result.geometry
        return None if interval is None else _frame(interval, "parameter", self.result.geometry_names)

    @property
    def urdf(self) -> str | None:
        """The corrected URDF of an arm whose geometry was identified, else None; none with unaccepted corrections."""
        if self.result.arm is None or self.result.geometry is None or not self._written:
            return None
        return calibrated_urdf(self.result.arm, self.result.recordings)

    def page(self) -> Page:
        result, said, at = self.result, self.said, self.at_targets
        robot, train = result.robot, result.recordings.rows(result.fitted)
        drawn, view = picture(robot, at_rest(robot, np.median(train.configurations, axis=0)), note=_PICTURE)
        fit, data = residuals(result, train)
        configuration = "" if at is None else at.problem.source
        files = {"robot": self.robot.document.source, "config": configuration, "recordings": result.recordings.source}
        stiffness = [table for table in said.tables if table.id == "stiffness-table"]
        doubts = sentences(self._doubts)
        sections = (
            said.section("Result", *([Sentences(doubts)] if doubts else []), self._key_figures()),
            PageSection("stiffness", "Stiffness", [stiffness_figure(result), *stiffness] if stiffness else []),
            *(arm_sections(result) if result.arm is not None else []),
            *([geometry_section(result)] if result.geometry is not None and result.arm is None else []),
            PageSection("fit", "How well the model fits", fit),
            *([] if at is None else at.sections("the identified robot")),
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

    def _key_figures(self) -> KeyFigures:
        result = self.result
        train, held_out = rms(result.fit.residuals), rms(result.test_residuals)
        items = [] if self.at_targets is None else [self.at_targets.figure]
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


def _frame(interval: Intervals, name: str, names: tuple[str, ...]) -> pd.DataFrame:
    """Estimates with their intervals, by names."""
    columns = {"estimate": interval.estimate, "low": interval.low, "high": interval.high}
    return pd.DataFrame(columns, index=pd.Index(names, name=name))

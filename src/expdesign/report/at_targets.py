"""What a model that recordings determined says at the targets of a configuration: acceptance, and what may be hidden.

Most recordings are identified without targets, and need not wait for planning.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from expdesign.assurance.acceptance.budget import NOISE
from expdesign.assurance.acceptance.decision import Decision, undecided
from expdesign.assurance.acceptance.fitted import FittedModel
from expdesign.assurance.acceptance.hidden_risk import decided_by, left_out_by
from expdesign.assurance.model_error.recorded import Shown
from expdesign.assurance.model_error.statement import AccuracyStatement, WhatIsHidden
from expdesign.estimation.identify import Identification
from expdesign.estimation.load_errors import load_columns
from expdesign.estimation.remarks import Implausible
from expdesign.planning.criteria.targets import GivenVariances
from expdesign.planning.problem import DesignProblem
from expdesign.report.acceptance_texts import acceptance_record, sentences
from expdesign.report.blocks import KeyFigure, PageSection, Paragraph, table_of
from expdesign.report.error_budget import EXPLAINED, acceptance_figure, acceptance_rows, headings
from expdesign.report.hidden_physics import hidden_blocks
from expdesign.report.said import Said

if TYPE_CHECKING:
    from expdesign.diagnosis.result import Diagnosis

_UNDECIDED = (
    "The expanded uncertainties are those of the refuted model, multiplied by the Birge ratio of its residuals. They "
    "do not bound what the missing physics does at the targets."
)


@dataclass
class AtTargets:
    """A model at the targets of a configuration.

    Attributes:
        problem: with the targets.
        model: as its recordings determined it.
        left_out: the physics of what the recordings show; None where they refute the model.
        acceptance: whether the robot is accepted.
        hidden: what the recordings may hide; None where that is not asked, or the model does not explain them.
    """

    problem: DesignProblem
    model: FittedModel
    left_out: Shown | None
    acceptance: Decision
    hidden: WhatIsHidden | None = None

    @classmethod
    def _of(
        cls, problem: DesignProblem, model: FittedModel, remedy: str, *, refuted: bool, otherwise: bool
    ) -> "AtTargets":
        """A model; nothing is decided where its recordings refute it, or fit only if they are read otherwise."""
        left_out = None if refuted else left_out_by(problem, model)
        found = decided_by(problem, model, left_out, refuted=refuted, remedy=remedy)
        return cls(problem, model, left_out, undecided(found) if otherwise else found)

    @classmethod
    def identified(cls, problem: DesignProblem, result: Identification) -> "AtTargets":
        """An identified robot; not decided where it is refuted."""
        noise, recorded = result.noise, result.recordings.rows(result.fitted)
        drawn = None if result.arm is None else result.arm.drawn
        model = FittedModel(result.fit, recorded, result.whitening, noise.degrees, result.loads, drawn)
        otherwise = any(isinstance(each, Implausible) and each.otherwise for each in result.suspicions)
        refuted = result.goodness.refuted
        return cls._of(problem, model, "run `expdesign diagnose`", refuted=refuted, otherwise=otherwise)

    @classmethod
    def diagnosed(cls, problem: DesignProblem, result: "Diagnosis") -> "AtTargets":
        """The model that a diagnosis found; nothing is decided where it is no explanation of the recordings."""
        sample = result.names.sample
        counts, recorded = sample.counts, result.recordings.rows(sample.counts)
        whitening, known = sample.whitening, result.known
        if result.loads is not None:
            weighs = result.loads.weights.any()
            whitening = whitening.weighing(load_columns(result.loads.effects, result.loads.weights) if weighs else None)
        degrees = result.noise.degrees
        if result.noise.origin == "residuals":  # what was found takes some
            degrees = min(degrees, float(max(result.after.dof, 1)))
        model = FittedModel(
            known.seen_by(counts), recorded, whitening.rows(counts), degrees, result.loads, result.drawn
        )
        remedy = "record what separates the explanations, or look at the place that is named"
        otherwise = any(doubt.otherwise for doubt in result.doubts)
        return cls._of(problem, model, remedy, refuted=result.refuted, otherwise=otherwise)

    def look_for_hidden(self) -> None:
        """Find what recordings that the base model explains may hide as well."""
        shown = None if self.model.fit.chain.effects else self.left_out
        self.hidden = (shown or Shown(self.problem, self.model.recordings, self.model.whitening)).hidden()

    @property
    def accuracy(self) -> AccuracyStatement | None:
        """What may be hidden, beside noise and load errors."""
        if self.hidden is None:
            return None
        budget, targets = self.acceptance.budget, self.problem.targets
        parts = {True: np.zeros(budget.tolerance.shape), False: np.zeros(budget.tolerance.shape)}
        for each in budget.contributions:
            parts[each.name == NOISE] += each.deviation**2
        noise, load_errors = (np.where(targets.importance > 0.0, parts[kind], 0.0) for kind in (True, False))
        return AccuracyStatement.of(GivenVariances(targets, noise, load_errors), self.hidden)

    @property
    def said(self) -> Said:
        """The decision, and what may still be hidden: a line for each sentence."""
        record: dict[str, Any] = {"acceptance": acceptance_record(self.acceptance)}
        lines, accuracy = sentences(self.acceptance), self.accuracy
        if self.hidden is not None:
            record |= {"hidden": self.hidden.record, "accuracy": None if accuracy is None else accuracy.record}
            lines.append((accuracy or self.hidden).sentence)
        return Said("", lines, document=lambda: record)

    @property
    def figure(self) -> KeyFigure:
        """The verdict, for the first section of a page."""
        return acceptance_figure(self.acceptance)

    def sections(self, of: str) -> list[PageSection]:
        """The sections of a page about the model that `of` names."""
        decision = self.acceptance
        frame = pd.json_normalize(
            [
                {"target": number} | axis
                for number, target in enumerate(acceptance_record(decision)["targets"], start=1)
                for axis in target["axes"]
            ]
        )
        caption = f"Uncertainty budget and acceptance of {of}; u are standard uncertainties (JCGM 100:2008)."
        table = table_of("acceptance-table", caption, headings(decision), acceptance_rows(decision), frame)
        explained = Paragraph(EXPLAINED if decision.decided else _UNDECIDED)
        hidden = [] if self.hidden is None else hidden_blocks(self.hidden.physics)
        return [
            PageSection("acceptance", "Acceptance", [table, explained]),
            PageSection("hidden", "What may still be hidden", hidden),
        ]

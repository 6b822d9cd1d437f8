"""What is said of plans: what `evaluate` and `next` return, and the texts of the page of `run`."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray
from expdesign.assurance.acceptance.decision import Decision
from expdesign.assurance.acceptance.planned import planned_decisions
from expdesign.assurance.model_error.meir import meir_of_problem
from expdesign.assurance.model_error.statement import AccuracyStatement, WhatIsHidden, hidden_by_plan
from expdesign.chain.recordings.recordings import Recordings
from expdesign.counted import counted
from expdesign.errors import ExpdesignError
from expdesign.estimation.goodness import StatementOfFit
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.record import evaluation_record
from expdesign.planning.front import Front
from expdesign.planning.plan import Plan
from expdesign.planning.problem import DesignProblem
from expdesign.report import words
from expdesign.report.acceptance_texts import acceptance_record, beside_the_plan, sentences
from expdesign.report.blocks import Definitions, PageSection, table_of
from expdesign.report.design_data import criteria_table, further_criteria
from expdesign.report.glossary import words_section
from expdesign.report.next_steps import next_steps
from expdesign.report.result import Result, TableResult
from expdesign.report.said import Said


def steps_after(problem: DesignProblem) -> PageSection:
    """The way from the plan to a compensated robot, with the commands."""
    files = {"config": problem.source, "robot": problem.robot_file, "model": "identified/model.yaml"}
    regressor = problem.loaded.regressor
    if not regressor.referenced:
        return next_steps("evaluate", "identify poses", noun=regressor.noun, **files)
    columns = ", ".join(problem.loaded.robot.coordinates.deflection)
    names = ("evaluate", "simulate", "sheet", "check", "identify", "diagnose", "compensate")
    return next_steps(*names, columns=columns, **files)


def vocabulary(front: Front) -> PageSection:
    """The words of the page, for a reader who has not met them."""
    names = ["Deflection", "Tolerance", "RMS, σ", "DUIR", "FEIR", "total"]
    names += ["MEIR"] if "meir" in front.criteria else []
    names += ["O1 to O5"] if {"o1", "o2", "o3", "o4", "o5"} & set(further_criteria(front)) else []
    names += ["O_TP, O_MV"] if any(name.startswith(("o_tp", "o_mv")) for name in front.criteria) else []
    return words_section(*names, "Front", "Recommended", "Knee", "Hypervolume")


def lower_bound_sentences(problem: DesignProblem, front: Front, run: Mapping[str, Any]) -> list[str]:
    """How near the designs come to what no plan can surpass, or why that was not computed."""
    bound = run["duir_lower_bound"]
    if bound is None:
        return [f"No lower bound of DUIR: {run['duir_lower_bound_certified_on']}."]
    if bound <= 0.0:
        return []
    duir = front.criteria["duir"]
    recommended = words.number(100.0 * (duir[front.recommended] / bound - 1.0), 2)
    least = words.number(100.0 * (duir.min() / bound - 1.0), 2)
    measurements = words.count(problem.space.measurements, "measurement")
    texts = [
        f"No plan of {measurements} has an error from measurement noise (DUIR) below {words.number(bound)} tolerances.",
        f"The recommended design is {recommended}\u00a0% above this bound"
        + ("." if least == recommended else f", the best design on the front {least}\u00a0%."),
    ]
    if front.complete and "duir" in front.objectives:
        texts.append("Every design was evaluated: none has a smaller DUIR than the front.")
    elif duir.min() > bound:
        better = words.number(100.0 * (1.0 - bound / duir.min()), 2)
        texts.append(f"A plan with a smaller DUIR, if there is one, is at most {better}\u00a0% better.")
    return [" ".join(texts)]


def planned_count(problem: DesignProblem, front: Front) -> int:
    """How many measurements the recommended design takes."""
    return int(problem.space.taken(front.decisions[front.recommended]).sum())


def poses_text(problem: DesignProblem, front: Front) -> str:
    """At how many different poses the recommended design measures."""
    configurations, _ = problem.space.decode(front.decisions[front.recommended])
    poses = words.count(len(np.unique(configurations.round(9), axis=0)), "pose")
    return f"at {poses}" if problem.loaded.regressor.needs_load else f"at {poses}, without load"


def _missing(share: float | None, *, complete: bool) -> str:
    if complete:
        return "none: all designs were evaluated"
    if not share:
        return "not estimated"
    return f"about {words.number(100.0 * share, 2)} % of it (estimate; unknown branches of the front are not included)"


def about_run(problem: DesignProblem, front: Front, run: Mapping[str, Any]) -> PageSection:
    """How the designs were searched for, and their further criteria."""
    robot, settings = problem.loaded.robot, problem.optimiser
    point = ", ".join(words.number(float(value)) for value in front.reference_point)
    bound, scope = run.get("duir_lower_bound"), run.get("duir_lower_bound_certified_on")
    clauses = [f"{words.sentence(clause)}." for clause in (scope or "").rstrip(".").split("; ")]
    versions = ", ".join(f"{name} {version}" for name, version in run.get("versions", {}).items())
    items = [
        ("Robot", f"{robot.name} ({robot.kind})"),
        *([] if problem.found is None else [("Model of the robot", problem.found.note)]),
        ("Configuration", problem.source),
        ("Objectives", ", ".join(words.criterion(name) for name in front.objectives)),
        ("Search", f"NSGA-II, population {settings.population}, effort {settings.effort}"),
        ("Why it ended", f"{words.sentence(run.get('search_ended', front.ended) or 'not recorded')}."),
        ("Seed", str(run.get("seed", settings.seed))),
        ("Designs evaluated", str(run.get("evaluations", front.evaluations))),
        ("Hypervolume", f"{words.number(front.hypervolume, 4)} with respect to ({point})"),
        ("Missing hypervolume", _missing(run.get("missing_hypervolume"), complete=front.complete)),
        ("Lower bound of DUIR", "not computed" if bound is None else words.number(bound, 4)),
        *([("How it was computed", " ".join(clauses))] if scope else []),
    ]
    if "wall_s" in run:
        items.insert(6, ("Time", f"{words.number(float(run['wall_s']))} s"))
    if "ended_by_hand" in run:
        items.insert(5, ("Ended by hand", f"{run['ended_by_hand']}; the search was not finished"))
    if versions:
        items.append(("Versions", versions))
    criteria = [criteria_table(front, front.recommended)] if further_criteria(front) else []
    return PageSection("run", "About this run", (Definitions(items), *criteria))


def recommendation(front: Front) -> list[str]:
    """Why a design is recommended that has not the least total of the front; nothing where it has."""
    total = front.criteria["total"]
    least = int(total.argmin())
    if least == front.recommended or front.passing is None:
        return []
    passing = "is the only one that is" if front.passing == 1 else f"has the least of the {front.passing} that are"
    return [
        f"Design {least + 1} has the least total of all, {words.number(float(total[least]))} tolerances, and is not "
        f"expected to pass: design {front.recommended + 1} {passing}."
    ]


@dataclass(frozen=True, repr=False)
class EvaluationResult(Result):
    """A plan as the criteria see it.

    Attributes:
        problem: by which it is judged.
        plan: what is judged.
        assessment: the pieces of every criterion, for a batch of this one design.
        remarks: what is doubtful about the plan, in words.
        unidentified: the error that says what the plan cannot identify, or None.
    """

    problem: DesignProblem
    plan: Plan
    assessment: Assessment
    remarks: tuple[str, ...]
    unidentified: ExpdesignError | None = None

    @property
    def said(self) -> Said:
        record = evaluation_record(self.assessment, self.problem.further)
        record["acceptance"] = acceptance_record(self.acceptance)
        if meir_of_problem(self.problem) is not None:
            record["hidden"] = None if self.hidden is None else self.hidden.record
            record["accuracy"] = None if self.accuracy is None else self.accuracy.record
        rows = [
            [
                criterion.title,
                "not identifiable" if record[name] is None else f"{record[name]:.6g}",
                criterion.unit,
                "larger" if criterion.maximise else "smaller",
            ]
            for name, criterion in self.problem.criteria.items()
        ]
        table = table_of("criteria", "Criteria of the plan.", ["Criterion", "Value", "Unit", "Better"], rows)
        accuracy = record.get("accuracy")
        lines = [*sentences(self.acceptance), *([accuracy["sentence"]] if accuracy else [])]
        values = [
            f"{name} {np.nan if record[name] is None else record[name]:.4g}" for name in ("duir", "feir", "total")
        ]
        notes = [f"expdesign: {remark}" for remark in self.remarks]
        return Said(f"{', '.join(values)} tolerances", lines, notes, lambda: record, [table])

    @property
    def acceptance(self) -> Decision:
        """Expanded uncertainty, tolerance and pass or fail of every axis of every target."""
        return planned_decisions(self.problem, self.assessment)[0]

    @cached_property
    def hidden(self) -> WhatIsHidden | None:
        """What the plan hides; None where MEIR is not asked for, or the targets are not identified."""
        return hidden_by_plan(self.problem, self.assessment, "this plan")

    @property
    def accuracy(self) -> AccuracyStatement | None:
        """Noise, load errors and what may be hidden; None where MEIR is not asked for, or nothing is determined."""
        return AccuracyStatement.of(self.assessment, self.hidden)

    @property
    def total(self) -> float:
        """RMS error to expect after compensation, in tolerances; NaN where the targets are not identified."""
        return float(self.criteria["value"]["total"])

    @property
    def criteria(self) -> pd.DataFrame:
        """Value, unit and sense of every criterion, by its name; NaN where it cannot be identified."""
        known = self.problem.criteria
        columns = {
            "value": [float(criterion.values(self.assessment)[0]) for criterion in known.values()],
            "unit": [criterion.unit for criterion in known.values()],
            "better": ["larger" if criterion.maximise else "smaller" for criterion in known.values()],
        }
        return pd.DataFrame(columns, index=pd.Index(list(known), name="criterion"))


@dataclass(frozen=True, repr=False)
class NextResult(TableResult):
    """The next measurements, and what they are expected to achieve.

    Attributes:
        text: the plan of the next measurements, numbered on from the recordings.
        recordings: what was measured so far.
        before: expected total error now, in tolerances; infinite where the recordings do not determine it.
        after: the same with each further measurement, shape (k,).
        fit: whether the base model accounts for the recordings, or None where that is not tested, as for a robot whose
            diagnosis found more than the base model.
        undetermined: what the recordings alone do not determine, in words, or None.
        decisions: whether the robot is expected to pass now and with each further measurement, k + 1 of them.
        accuracy: expected error, in tolerances, at which it was to stop, or None.
    """

    recordings: Recordings
    before: float
    after: FloatArray
    fit: StatementOfFit | None
    undetermined: str | None
    decisions: tuple[Decision, ...]
    accuracy: float | None = None

    @property
    def said(self) -> Said:
        totals, decisions, accuracy, fit = self.totals, self.decisions, self.accuracy, self.fit
        lines, count = [], len(self.after)
        refuted, decided = fit is not None and fit.refuted, decisions[0].decided
        if fit is not None and refuted:
            lines += [
                f"{fit.sentence()} More of them will not help until `expdesign diagnose` has found why.",
                "What follows assumes that the base model is right.",
            ]
        if self.undetermined is not None:
            lines.append(f"so far: {self.undetermined}")
        enough = next((index for index, decision in enumerate(decisions) if decision.robot_passes), None)
        verdict = sentences(decisions[0])[0]
        if enough == 0 and decided and not refuted:
            verdict = f"{verdict} No further measurement is needed."
        lines.append(verdict)
        if accuracy is not None and totals[0] <= accuracy and decided and not refuted:
            lines.append(f"already within {accuracy:g} tolerances, the accuracy that was asked for")
        for index, total in enumerate(totals):
            when = f"with {index} more" if index else "expected total error now"
            lines.append(f"{when}: {f'{total:.4g} tolerances' if np.isfinite(total) else 'not determined'}")
        lines += beside_the_plan(decisions[0].budget)
        if accuracy is not None and totals[-1] > accuracy:
            lines.append(f"{count} more {'is' if count == 1 else 'are'} not enough for {accuracy:g} tolerances")
        if decided and enough:
            lines.append(f"with {enough} more the robot is expected to pass")
        elif decided and enough is None:
            lines.append(f"with {count} more the robot is still not expected to pass")
        return Said(counted(count, "further measurement"), lines)

    @property
    def totals(self) -> FloatArray:
        """Expected total error now and with each further measurement, shape (k + 1,)."""
        return np.concatenate([[self.before], self.after])

"""Sentences about plans: what `run`, `evaluate` and `next` say, and the texts of the page of `run`."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.assurance.acceptance.decision import Decision
from expdesign.counted import counted
from expdesign.estimation.goodness import StatementOfFit
from expdesign.planning.criteria.criterion import Criterion
from expdesign.planning.front import Front
from expdesign.planning.problem import DesignProblem
from expdesign.report import words
from expdesign.report.acceptance_texts import beside_the_plan, sentences
from expdesign.report.blocks import Definitions, PageSection, table_of
from expdesign.report.design_data import criteria_table, further_criteria
from expdesign.report.glossary import words_section
from expdesign.report.next_steps import next_steps
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


def _lower_bound(problem: DesignProblem, front: Front, run: Mapping[str, Any]) -> list[str]:
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


def next_said(
    totals: FloatArray,
    decisions: Sequence[Decision],
    fit: StatementOfFit | None,
    undetermined: str | None,
    accuracy: float | None,
) -> Said:
    """What `next` says: the error to expect now and with each further measurement, and whether that is enough.

    Args:
        totals: expected total error now and with each of k further measurements, in tolerances, shape (k + 1,).
        decisions: whether the robot is expected to pass with each of these.
        fit: whether the base model accounts for the recordings, or None where that is not tested.
        undetermined: what the recordings alone do not determine, in words, or None.
        accuracy: expected error, in tolerances, at which it was to stop, or None.
    """
    lines, count = [], len(totals) - 1
    refuted, decided = fit is not None and fit.refuted, decisions[0].decided
    if fit is not None and refuted:
        lines += [
            f"{fit.sentence()} More of them will not help until `expdesign diagnose` has found why.",
            "What follows assumes that the base model is right.",
        ]
    if undetermined is not None:
        lines.append(f"so far: {undetermined}")
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
    if not decided:
        return Said(counted(count, "further measurement"), lines)
    if enough:
        lines.append(f"with {enough} more the robot is expected to pass")
    elif enough is None:
        lines.append(f"with {count} more the robot is still not expected to pass")
    return Said(counted(count, "further measurement"), lines)


def run_said(problem: DesignProblem, front: Front, run: Mapping[str, Any], accepted: Decision) -> Said:
    """What `run` says: the front, why the search ended, acceptance of the recommended design, and what is not known.

    Args:
        problem: what was searched.
        front: what was found.
        run: the content of `run.json` (file-formats.md, run.json).
        accepted: the decision about the recommended design.
    """
    best = {name: float(values[front.recommended]) for name, values in front.criteria.items()}
    summary = (
        f"{counted(len(front), 'design')} on the front; recommended design {front.recommended + 1}: "
        f"DUIR {best['duir']:.4g}, FEIR {best['feir']:.4g}, total {best['total']:.4g} tolerances."
    )
    texts = [summary, f"The search ended because {front.ended}.", *recommendation(front)]
    texts += [run["plan_ended"]] if "plan_ended" in run else []
    texts += sentences(accepted)
    texts += [run[name]["sentence"] for name in ("accuracy", "unseen") if name in run]
    return Said(summary, [*texts, *_lower_bound(problem, front, run)], document=lambda: run)


def evaluated(
    criteria: Mapping[str, Criterion], record: Mapping[str, Any], accepted: Decision, remarks: Sequence[str]
) -> Said:
    """What `evaluate` says: every criterion, and what is accepted.

    Args:
        criteria: by their names.
        record: the document of `evaluate --json` (file-formats.md, evaluate --json).
        accepted: the decision about the plan.
        remarks: what is doubtful about it, in words.
    """
    rows = [
        [
            criterion.title,
            "not identifiable" if record[name] is None else f"{record[name]:.6g}",
            criterion.unit,
            "larger" if criterion.maximise else "smaller",
        ]
        for name, criterion in criteria.items()
    ]
    table = table_of("criteria", "Criteria of the plan.", ["Criterion", "Value", "Unit", "Better"], rows)
    accuracy = record.get("accuracy")
    lines = [*sentences(accepted), *([accuracy["sentence"]] if accuracy else [])]
    values = [f"{name} {np.nan if record[name] is None else record[name]:.4g}" for name in ("duir", "feir", "total")]
    notes = [f"expdesign: {remark}" for remark in remarks]
    return Said(f"{', '.join(values)} tolerances", lines, notes, lambda: record, [table])

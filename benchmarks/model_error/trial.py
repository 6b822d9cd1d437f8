"""One machine and one plan: measure, diagnose, compensate, and look at what is attained."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray
from expdesign.chain.models.model_file import Model
from expdesign.chain.recordings.reader import points_from_table, recordings_from_table
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.diagnosis.diagnose import diagnose as diagnose_recordings
from expdesign.diagnosis.result import Diagnosis
from expdesign.errors import ExpdesignError
from expdesign.estimation.compensation.compensate import compensate
from expdesign.estimation.identify import identify
from expdesign.io.output import csv_text
from expdesign.io.table import parse_table
from expdesign.io.yaml_reader import YamlDocument
from expdesign.planning.plan import Plan, plan_frame
from expdesign.planning.problem import DesignProblem

from .machine import Concealed, Machine


@dataclass(frozen=True)
class Outcome:
    """What one experiment led to.

    Attributes:
        verdict: of the diagnosis, `failed` where it ended in an error.
        named: physics and components that were found.
        noticed: whether the recordings contradict the base model.
        right: whether the hidden physics was found at its component, by name or as indistinguishable from the name.
        error: at the targets with the model that the diagnosis found, in tolerances.
        undiagnosed: the same with the base model.
        seconds: processor time.
    """

    verdict: str
    named: str
    noticed: bool
    right: bool
    error: float
    undiagnosed: float
    seconds: float


def outcome(
    problem: DesignProblem, targets: LoadedPoints, machine: Machine, plan: Plan, seed: int, without: frozenset[str]
) -> Outcome:
    """Go round the loop once; the same seed draws the same noise."""
    began = time.process_time()
    robot = problem.loaded.robot
    rows = plan_frame(plan, problem.loaded, False)
    recordings = recordings_from_table(parse_table(csv_text(machine.measured(rows, seed)), "recordings"), robot)
    document = YamlDocument("robot", Path(), problem.config["robot"])
    base = Model.from_fit(identify(robot, recordings).fit, document, "recordings")
    undiagnosed = attained(problem, targets, machine, base)
    try:
        found = diagnose_recordings(robot, recordings, without=without)
        error = attained(problem, targets, machine, Model.from_fit(found.predictive.fit, document, "recordings"))
    except ExpdesignError:
        return Outcome("failed", "", True, False, undiagnosed, undiagnosed, time.process_time() - began)
    named = "; ".join(f"{finding.physics} {finding.component}" for finding in found.findings)
    noticed, right = found.verdict != "consistent", is_right(found, machine.concealed)
    return Outcome(found.verdict, named, noticed, right, error, undiagnosed, time.process_time() - began)


def is_right(found: Diagnosis, concealed: Concealed) -> bool:
    """Whether a finding is the hidden physics; without any, whether nothing was found."""
    if not concealed.physics:
        return not found.findings
    return any(
        concealed.physics in (finding.physics, *finding.indistinguishable)
        and not set(concealed.components).isdisjoint(finding.component.split(", "))
        for finding in found.findings
    )


def attained(problem: DesignProblem, targets: LoadedPoints, machine: Machine, model: Model) -> float:
    """Error at the targets after compensation, weighted as in the criterion `total`, in tolerances."""
    errors = machine.errors(compensate(model, targets).commands, targets)
    squares = (errors**2 * problem.targets.importance).sum(axis=1)
    return float(np.sqrt(squares @ problem.targets.weights / problem.targets.weights.sum()))


def by_hand(problem: DesignProblem, fractions: FloatArray) -> Plan:
    """A plan from places in the range of every variable, -1 to 1, shape (m, g); choices count in equal steps."""
    space = problem.space
    middle, half = 0.5 * (space.upper + space.lower), 0.5 * (space.upper - space.lower)
    decisions = middle + half * np.where(space.discrete, fractions, 0.9 * fractions)
    return plan_of_decisions(problem, np.where(space.discrete, np.round(decisions), decisions))


def plan_of_decisions(problem: DesignProblem, decisions: FloatArray) -> Plan:
    """The plan that decisions (m, g) stand for, every measurement a series of its own."""
    configurations, loads = problem.space.decode(decisions)
    return Plan(configurations, loads, np.arange(1, len(decisions) + 1))


def targets_of(problem: DesignProblem) -> LoadedPoints:
    """The targets with the payloads that are assumed there."""
    robot = problem.loaded.robot
    names = [*robot.configuration, "mass_kg", "com_x_m", "com_y_m", "com_z_m"]
    rows = [[*t["pose"], t["payload"]["mass_kg"], *t["payload"]["com_m"]] for t in problem.config["targets"]]
    frame = pd.DataFrame(np.array(rows, dtype=float), columns=names)
    return points_from_table(parse_table(csv_text(frame), "targets"), robot)

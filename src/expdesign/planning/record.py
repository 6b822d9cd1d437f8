"""`run.json` (file-formats.md, run.json): what a search was given and what it found, as one document."""

from importlib.metadata import version
from typing import Any

import expdesign
from expdesign.planning.front import Front
from expdesign.planning.optimality.bounds import CriterionBounds
from expdesign.planning.problem import DesignProblem

PACKAGES = ("casadi", "numpy", "pandas", "pymoo", "scipy")
"""On whose versions the numbers depend, beside this one."""


def versions() -> dict[str, str]:
    """The versions of the packages on which the numbers depend."""
    return {"expdesign": expdesign.__version__} | {name: version(name) for name in PACKAGES}


def run_record(problem: DesignProblem, front: Front, duir: CriterionBounds, total: CriterionBounds) -> dict[str, Any]:
    """The content of `run.json` but for the time; `duir` and `total` are bounds of these criteria."""
    record: dict[str, Any] = {
        "config": problem.config,
        "seed": problem.optimiser.seed,
        "versions": versions(),
        "evaluations": front.evaluations,
        "duir_lower_bound": duir.lower.value,
        "duir_lower_bound_certified_on": duir.lower.certified_on,
        "total_lower_bound": total.lower.value,
        "total_lower_bound_certified_on": total.lower.certified_on,
        "whole_plans": {"duir": duir.record, "total": total.record},
        "objectives": list(front.objectives),
        "hypervolume": front.hypervolume,
        "missing_hypervolume": front.missing,
        "reference_point": front.reference_point.tolist(),
        "designs": len(front),
        "recommended": front.recommended + 1,
        "knee": front.knee + 1,
    }
    for criterion in problem.further:
        record[criterion.name] = float(front.criteria[criterion.name][front.recommended])
    return record

"""`expdesign run`: the Pareto front of a configuration, its plans and its report."""

import time
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Any

import typer

from expdesign.commands.console import note, progress
from expdesign.design.front import Front
from expdesign.design.optimality.certificate import LowerBound, duir_lower_bound, total_lower_bound
from expdesign.design.plan import csv_text
from expdesign.design.problem import DesignProblem
from expdesign.design.problem_file import read_problem
from expdesign.design.result import pareto_frame, plan_of, plans_frame
from expdesign.design.search import Progress, search
from expdesign.errors import InputError
from expdesign.files.output import json_text, output_folder, require_writable, write_file


def command(
    config: Annotated[Path, typer.Argument(help="Run configuration (YAML).")],
    out: Annotated[
        Path | None, typer.Option(help="Folder for the results; a new one under results/ if left out.")
    ] = None,
) -> None:
    """Find the Pareto front of DUIR against FEIR and the recommended plan.

    Example: expdesign run configs/hexapod-h1.yaml --out results/mine
    """
    from expdesign.report.design_report import design_report  # noqa: PLC0415 (slow to import)
    from expdesign.report.stored import write_report  # noqa: PLC0415

    folder = out or _new_folder(config)
    require_writable(folder)
    problem = read_problem(config)
    if problem.space.genes == 0:
        what = "every pose and every load is fixed, so that there is nothing to choose"
        remedy = "Give an interval or a list of choices; `expdesign evaluate` judges a plan that is given."
        raise InputError(what, where=f"{config}, experiment", remedy=remedy)
    started = time.perf_counter()
    with progress("searching") as bar:

        def report(state: Progress) -> None:
            text = state.note or f"front {state.front_size}, hypervolume {state.hypervolume:.6g}"
            bar.update(state.generation, state.generations, text)

        front = search(problem, report)
    with progress("bounding") as bar:
        bar.update(0, 2, "DUIR")
        duir = duir_lower_bound(problem, front.genes)
        bar.update(1, 2, "total")
        bounds = (duir, total_lower_bound(problem, front.genes))
        bar.update(2, 2, "")
    run = run_record(problem, front, bounds, time.perf_counter() - started)
    with output_folder(folder) as scratch:
        write_file(scratch / "pareto.csv", csv_text(pareto_frame(front)))
        write_file(scratch / "plans.csv", csv_text(plans_frame(problem, front)))
        write_file(scratch / "plan.csv", csv_text(plan_of(problem, front, front.recommended)))
        write_file(scratch / "run.json", json_text(run))
        write_report(scratch, design_report(problem, front, run))
    best = {name: float(values[front.recommended]) for name, values in front.criteria.items()}
    note(
        f"{len(front)} designs on the front; recommended design {front.recommended + 1}: "
        f"DUIR {best['duir']:.4g}, FEIR {best['feir']:.4g}, total {best['total']:.4g} tolerances."
    )
    print(folder / "report.html")


def _new_folder(config: Path) -> Path:
    """A folder under `results/` that does not exist yet."""
    number = 1
    while (folder := Path("results") / f"{config.stem}-run-{number}").exists():
        number += 1
    return folder


def run_record(
    problem: DesignProblem, front: Front, bounds: tuple[LowerBound, LowerBound], seconds: float
) -> dict[str, Any]:
    """The content of `run.json` (interfaces.md); `bounds` are those of DUIR and of total."""
    duir, total = bounds
    packages = ("expdesign", "casadi", "numpy", "pandas", "pymoo", "scipy")
    return {
        "config": problem.config,
        "seed": problem.optimiser.seed,
        "versions": {name: version(name) for name in packages},
        "wall_s": seconds,
        "evaluations": front.evaluations,
        "duir_lower_bound": duir.value,
        "duir_lower_bound_certified_on": duir.certified_on,
        "total_lower_bound": total.value,
        "total_lower_bound_certified_on": total.certified_on,
        "objectives": list(front.objectives),
        "hypervolume": front.hypervolume,
        "reference_point": front.reference_point.tolist(),
        "designs": len(front),
        "recommended": front.recommended + 1,
        "knee": front.knee + 1,
    }

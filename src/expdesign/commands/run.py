"""`expdesign run`: the Pareto front of a configuration, its plans and its report."""

from pathlib import Path
from typing import Annotated

import typer

import expdesign as xd
from expdesign.acceptance.decision import sentences
from expdesign.acceptance.recommended import recommended_acceptance
from expdesign.commands.console import note, stages
from expdesign.files.output import new_folder, require_writable


def command(
    config: Annotated[Path, typer.Argument(help="Run configuration (YAML).")],
    out: Annotated[
        Path | None, typer.Option(help="Folder for the results; a new one under results/ if left out.")
    ] = None,
) -> None:
    """Find the Pareto front of DUIR against FEIR and the recommended plan.

    Example: expdesign run configs/hexapod-h1.yaml --out results/mine
    """
    folder = out or new_folder(config.stem)
    require_writable(folder)
    with stages() as report:
        result = xd.run(config, report=report)
    page = result.save(folder)
    front = result.front
    best = {name: float(values[front.recommended]) for name, values in front.criteria.items()}
    note(
        f"{len(front)} designs on the front; recommended design {front.recommended + 1}: "
        f"DUIR {best['duir']:.4g}, FEIR {best['feir']:.4g}, total {best['total']:.4g} tolerances."
    )
    for text in sentences(recommended_acceptance(result.problem, front)):
        note(text)
    if "accuracy" in result.record:
        note(result.record["accuracy"]["sentence"])
    if result.record["duir_lower_bound"] is None:
        note(f"no lower bound of DUIR: {result.record['duir_lower_bound_certified_on']}")
    if result.protocol is not None:
        note(f"{folder / 'poses.csv'} has every pose to measure, references included; `expdesign correct` reads it")
    print(page)

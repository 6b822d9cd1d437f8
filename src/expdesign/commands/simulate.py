"""`expdesign simulate`: recordings of a plan as the model gives them, with noise and load errors."""

from pathlib import Path
from typing import Annotated

import typer

import expdesign as xd
from expdesign.commands.console import note


def command(
    config: Annotated[Path, typer.Argument(help="Run configuration (YAML).")],
    plan: Annotated[Path, typer.Argument(help="Plan (CSV).")],
    out: Annotated[Path, typer.Option(help="File for the recordings.")],
    model: Annotated[
        Path | None,
        typer.Option(
            "--model",
            "--truth",
            help="Model or robot file (YAML) that deflects; the configuration's robot if left out.",
        ),
    ] = None,
    seed: Annotated[int, typer.Option(help="Of the noise and the load errors.")] = 1,
    noise: Annotated[bool, typer.Option("--noise/--no-noise", help="With the configuration's noise.")] = True,
    load_errors: Annotated[
        bool, typer.Option("--load-errors/--no-load-errors", help="With the configuration's load errors.")
    ] = True,
) -> None:
    """Simulate the recordings of a plan.

    Example: expdesign simulate configs/hexapod-h1.yaml plan.csv --out recordings.csv --seed 3
    """
    result = xd.simulate(config, plan, model=model, seed=seed, noise=noise, load_errors=load_errors)
    result.save(out)
    note(f"{len(result.text)} rows simulated (seed {seed}{'' if noise else ', no noise'})")
    print(out)

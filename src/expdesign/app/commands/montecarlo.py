"""`expdesign montecarlo`: the accuracy that a plan attains in very many repetitions, beside the prediction."""

from pathlib import Path
from typing import Annotated

import typer

import expdesign as xd
from expdesign.app.api.inputs import purpose_of
from expdesign.app.commands.console import note
from expdesign.app.commands.engines import CLUSTER, WORKERS, elsewhere, engine_of
from expdesign.app.commands.writing import Config, Folder, Force, PlanPath, require_folder

GROUP = ("research", 2)
"""Where it stands in the list of commands."""


def command(
    config: Config,
    plan: PlanPath,
    out: Folder,
    samples: Annotated[int, typer.Option(help="Number of repetitions.")] = 100_000,
    seed: Annotated[int, typer.Option(help="Seed of all random numbers.")] = 1,
    plant: Annotated[
        str, typer.Option(help="What is measured and commanded: `explicit`, or `equilibrium` (robots on legs).")
    ] = "explicit",
    distribution: Annotated[str, typer.Option(help="Of the load errors: `normal` or `uniform`.")] = "normal",
    truth: Annotated[
        Path | None, typer.Option(help="Robot or model file (YAML) that is really measured and commanded.")
    ] = None,
    workers: Annotated[int | None, typer.Option(help=f"{WORKERS}; 1 if left out.")] = None,
    cluster: Annotated[str | None, typer.Option(help=CLUSTER)] = None,
    force: Force = False,
) -> None:
    """Repeat experiment, identification and exact compensation, and compare with DUIR, FEIR and total.

    Example: expdesign montecarlo configs/hexapod-h1.yaml results/mine/plan.csv --out results/mine-montecarlo
    """
    require_folder(out, xd.MonteCarloResult, purpose_of("montecarlo", config, plan), force=force)
    with engine_of(workers, cluster, default=1) as engine:
        done = xd.montecarlo(
            config,
            plan,
            samples=samples,
            seed=seed,
            plant=plant,
            distribution=distribution,
            truth=truth,
            engine=elsewhere(engine),
            progress=True,
        )
    for remark in done.remarks:
        note(f"expdesign: {remark}")
    page = done.save(out, force=force)
    print(done.summary)
    print(page)

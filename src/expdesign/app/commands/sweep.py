"""`expdesign sweep`: many runs with other values, resumable, on one machine or a cluster."""

from pathlib import Path
from typing import Annotated

import typer

import expdesign as xd
from expdesign.app.commands.console import note
from expdesign.app.commands.engines import CLUSTER, WORKERS, engine_of
from expdesign.app.commands.writing import Force
from expdesign.app.sweeps.store import TABLE

GROUP = ("research", 3)
"""Where it stands in the list of commands."""


def command(
    sweep: Annotated[Path, typer.Argument(help="What varies (YAML).")],
    out: Annotated[Path, typer.Option(help="Folder for the results; the same folder continues a sweep.")],
    workers: Annotated[int | None, typer.Option(help=f"{WORKERS}; as many as it has processors if left out.")] = None,
    cluster: Annotated[str | None, typer.Option(help=CLUSTER)] = None,
    force: Force = False,
) -> None:
    """Do many runs with other values; interrupted, the same command goes on.

    Example: expdesign sweep configs/sweep-measurements.yaml --out results/measurements --workers 2
    """
    try:
        with engine_of(workers, cluster) as engine:
            result = xd.sweep(sweep, out, engine=engine, progress=True, force=force)
    except KeyboardInterrupt:
        note("Finished runs are kept; the same command goes on from there.")
        raise
    if result.failed:
        note(f"{result.failed} of {len(result.table)} runs have no result; the column `message` says why.")
    print(out / TABLE)

"""`expdesign sweep`: many runs with other values, resumable, on one machine or a cluster."""

import os
from pathlib import Path
from typing import Annotated

import typer

import expdesign as xd
from expdesign.commands.console import note, stages
from expdesign.errors import InputError
from expdesign.sweeps.engine import Engine, Processes, Serial
from expdesign.sweeps.store import TABLE


def command(
    sweep: Annotated[Path, typer.Argument(help="What varies (YAML).")],
    out: Annotated[Path, typer.Option(help="Folder for the results; the same folder continues a sweep.")],
    workers: Annotated[
        int | None, typer.Option(help="Processes of this machine; as many as it has processors if left out.")
    ] = None,
    cluster: Annotated[
        str | None, typer.Option(help="Address of a Dask scheduler instead, e.g. tcp://192.168.0.5:8786.")
    ] = None,
) -> None:
    """Do many runs with other values; interrupted, the same command goes on.

    Example: expdesign sweep configs/sweep-measurements.yaml --out results/measurements --workers 2
    """
    try:
        with stages() as report:
            result = xd.sweep(sweep, out, engine=_engine(workers, cluster), report=report)
    except KeyboardInterrupt:
        note("Finished runs are kept; the same command goes on from there.")
        raise
    if result.failed:
        note(f"{result.failed} of {len(result.table)} runs have no result; the column `message` says why.")
    print(out / TABLE)


def _engine(workers: int | None, cluster: str | None) -> Engine:
    if cluster is not None:
        if workers is not None:
            remedy = "Workers of a cluster are started with it (`dask worker ADDRESS --nthreads 1`)."
            raise InputError("only one of `--workers` and `--cluster` can be given", where="--workers", remedy=remedy)
        from expdesign.sweeps.cluster import Cluster  # noqa: PLC0415 (an extra)

        return Cluster(cluster)
    if workers is not None and workers < 1:
        raise InputError(f"{workers} is not a number of processes", where="--workers", remedy="Use at least 1.")
    count = workers or os.cpu_count() or 1
    return Serial() if count == 1 else Processes(count)

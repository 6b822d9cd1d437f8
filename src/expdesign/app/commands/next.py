"""`expdesign next`: the measurements that would most improve the accuracy at the targets."""

from pathlib import Path
from typing import Annotated

import numpy as np
import typer

import expdesign as xd
from expdesign.app.api.inputs import purpose_of
from expdesign.app.commands.console import note_unknown_columns
from expdesign.app.commands.writing import Config, Force, require_file

GROUP = ("research", 5)
"""Where it stands in the list of commands."""


def command(
    config: Config,
    recordings: Annotated[Path, typer.Argument(help="What was measured so far (CSV).")],
    out: Annotated[Path, typer.Option(help="File for the plan of the next measurements.")],
    count: Annotated[
        int | None, typer.Option(help="How many; 1 if left out, or as many as the accuracy takes.")
    ] = None,
    accuracy: Annotated[float | None, typer.Option(help="Expected error, in tolerances, at which to stop.")] = None,
    seed: Annotated[int, typer.Option(help="Of the candidates that are drawn.")] = 1,
    force: Force = False,
) -> None:
    """Plan the next measurements, given what was measured.

    Example: expdesign next configs/hexapod-h1.yaml recordings.csv --out plan-next.csv --accuracy 0.8
    """
    require_file(out, purpose_of("next", config, recordings), force=force)
    planned = xd.plan_next(config, recordings, count=count, accuracy=accuracy, seed=seed)
    planned.save(out, force=force)
    note_unknown_columns(planned.recordings)
    if planned.fit is not None and planned.fit.refuted:
        print(f"{planned.fit.sentence()} More of them will not help until `expdesign diagnose` has found why.")
    if planned.undetermined is not None:
        print(f"so far: {planned.undetermined}")
    totals = planned.totals
    wanted = accuracy if accuracy is not None else 1.0
    if totals[0] <= wanted:
        print(f"already within {wanted:g} tolerances: no further measurement is needed")
    for index, total in enumerate(totals):
        when = f"with {index} more" if index else "expected total error now"
        print(f"{when}: {_tolerances(float(total))}")
    if accuracy is not None and totals[-1] > accuracy:
        count = len(planned.after)
        print(f"{count} more {'is' if count == 1 else 'are'} not enough for {accuracy:g} tolerances")
    print(out)


def _tolerances(value: float) -> str:
    return f"{value:.4g} tolerances" if np.isfinite(value) else "not determined"

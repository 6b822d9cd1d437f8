"""`expdesign simulate`: recordings of a plan as the model gives them, with noise and load errors."""

from pathlib import Path
from typing import Annotated

import typer

import expdesign as xd
from expdesign.app.api.inputs import purpose_of
from expdesign.app.commands.console import note
from expdesign.app.commands.writing import Config, Force, OtherRobot, PlanPath, require_file

GROUP = ("data", 3)
"""Where it stands in the list of commands."""


def command(
    config: Config,
    plan: PlanPath,
    out: Annotated[Path, typer.Option(help="File for the recordings.")],
    model: Annotated[
        Path | None,
        typer.Option(
            "--model",
            "--truth",
            help="Model or robot file (YAML) that deflects; the configuration's robot if left out.",
        ),
    ] = None,
    conceal: Annotated[
        list[str] | None,
        typer.Option(
            help="Physics that really deflects, e.g. 'leg_backlash at leg 4, 5 um'; repeatable. See `physics`."
        ),
    ] = None,
    seed: Annotated[int, typer.Option(help="Of the noise and the load errors.")] = 1,
    noise: Annotated[bool, typer.Option("--noise/--no-noise", help="With the configuration's noise.")] = True,
    load_errors: Annotated[
        bool, typer.Option("--load-errors/--no-load-errors", help="With the configuration's load errors.")
    ] = True,
    other_robot: OtherRobot = False,
    force: Force = False,
) -> None:
    """Simulate the recordings of a plan.

    Example: expdesign simulate configs/hexapod-h1.yaml plan.csv --out recordings.csv --seed 3
    """
    require_file(out, purpose_of("simulate", config, plan), force=force)
    result = xd.simulate(
        config,
        plan,
        model=model,
        conceal=conceal or (),
        seed=seed,
        noise=noise,
        load_errors=load_errors,
        other_robot=other_robot,
    )
    result.save(out, force=force)
    note(f"{result.summary} (seed {seed}{'' if noise else ', no noise'})")
    print(out)

"""`expdesign compare`: criteria across designs, over one or more configurations."""

from pathlib import Path
from typing import Annotated

import typer

import expdesign as xd
from expdesign.app.api.compare import RANDOM, SAMPLES
from expdesign.app.api.inputs import purpose_of
from expdesign.app.commands.engines import CLUSTER, WORKERS, elsewhere, engine_of
from expdesign.app.commands.writing import Force, require_folder
from expdesign.errors import InputError
from expdesign.io.output import new_folder

GROUP = ("research", 1)
"""Where it stands in the list of commands."""


def command(
    configs: Annotated[list[Path], typer.Argument(help="Run configurations (YAML).")],
    out: Annotated[
        Path | None, typer.Option(help="Folder for the results; a new one under results/ if left out.")
    ] = None,
    plan: Annotated[list[str] | None, typer.Option(help="A further plan, NAME=FILE.csv; can be repeated.")] = None,
    separate: Annotated[
        bool, typer.Option("--separate", help="Allow other targets, tolerances or noise; nothing is overlaid then.")
    ] = False,
    samples: Annotated[int, typer.Option(help="Repetitions of the experiment per design.")] = SAMPLES,
    random: Annotated[int, typer.Option(help="Random designs per configuration.")] = RANDOM,
    generations: Annotated[
        int | None, typer.Option(help="Of the search for each criterion; as configured if left out.")
    ] = None,
    seed: Annotated[int, typer.Option(help="Of the searches, the random designs and the experiments.")] = 1,
    workers: Annotated[int | None, typer.Option(help=f"{WORKERS}; 1 if left out.")] = None,
    cluster: Annotated[str | None, typer.Option(help=CLUSTER)] = None,
    force: Force = False,
) -> None:
    """Compare the designs of every criterion, random ones and given plans by the accuracy that they attain.

    Example: expdesign compare configs/hexapod-h1.yaml --plan mine=plan.csv --out results/compare
    """
    folder = out or new_folder("compare")
    require_folder(folder, xd.ComparisonResult, purpose_of("compare", *configs), force=force)
    plans = _plans(plan or [])
    with engine_of(workers, cluster, default=1) as engine:
        result = xd.compare(
            *configs,
            plans=plans,
            separate=separate,
            samples=samples,
            random=random,
            generations=generations,
            seed=seed,
            engine=elsewhere(engine),
            progress=True,
        )
    page = result.save(folder, force=force)
    print(result.summary)
    print(page)


def _plans(texts: list[str]) -> dict[str, Path]:
    plans: dict[str, Path] = {}
    for name, file in map(_named, texts):
        if name in plans:
            remedy = "Give each plan a name of its own."
            raise InputError(f"there are two plans `{name}`", where="--plan", remedy=remedy)
        plans[name] = file
    return plans


def _named(text: str) -> tuple[str, Path]:
    name, separator, file = text.partition("=")
    if not separator or not file:
        raise InputError(f"`{text}` is no named plan", where="--plan", remedy="Write NAME=FILE, e.g. mine=plan.csv.")
    return name.strip(), Path(file)

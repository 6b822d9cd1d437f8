"""`expdesign run`: the Pareto front of a configuration, its plans and its report."""

import os
import sys
import webbrowser
from pathlib import Path
from typing import Annotated

import typer

import expdesign as xd
from expdesign.acceptance.decision import sentences
from expdesign.acceptance.recommended import recommended_acceptance
from expdesign.api.inputs import problem_of
from expdesign.commands.console import note, stages
from expdesign.files.output import new_folder, require_writable


def command(
    config: Annotated[Path, typer.Argument(help="Run configuration (YAML).")],
    out: Annotated[
        Path | None, typer.Option(help="Folder for the results; a new one under results/ if left out.")
    ] = None,
    watch: Annotated[
        bool, typer.Option("--watch", help="Show the front as it grows in the browser, where the run can be ended.")
    ] = False,
    seconds: Annotated[
        float | None, typer.Option(min=0.0, help="End the search after so many seconds with what is there.")
    ] = None,
    workers: Annotated[
        int, typer.Option(min=1, help="Processes of this machine; the results are the same. More than 2 are no use.")
    ] = 2,
    port: Annotated[int, typer.Option(help="Of the page of --watch on this machine; any that is free if 0.")] = 0,
) -> None:
    """Find the Pareto front of DUIR against FEIR and the recommended plan.

    Example: expdesign run configs/hexapod-h1.yaml --out results/mine --watch
    """
    folder = out or new_folder(config.stem)
    require_writable(folder)
    if watch:
        result, page = _watched(config, folder, port, seconds, workers)
    else:
        with stages() as report:
            result = xd.run(config, report=report, seconds=seconds, workers=workers)
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


def _watched(config: Path, folder: Path, port: int, seconds: float | None, workers: int) -> tuple[xd.Run, Path]:
    """The run with a page on which it can be looked at and ended, and the path of its report."""
    from expdesign.watching.server import serve  # noqa: PLC0415 (needed here alone)
    from expdesign.watching.watched import Watched  # noqa: PLC0415

    problem = problem_of(config)
    watched = Watched(problem, str(folder))
    with serve(watched, port) as watch:
        note(f"watch it at {watch.address}")
        _open(watch.address)
        with stages() as report:

            def both(title: str, done: int, total: int, text: str) -> None:
                report(title, done, total, text)
                watched.stage(title, done, total, text)

            result = xd.run(problem, report=both, follow=watched.follow, seconds=seconds, workers=workers)
        watched.stage("writing", 0, 0, "")
        page = result.save(folder)
        watched.ended("ended" if "ended_by_hand" in result.record else "finished")
        watch.report = page
    return result, page


def _open(address: str) -> None:
    """Open a page where a person sits at a screen; elsewhere the address has been said."""
    screen = sys.platform in ("darwin", "win32") or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    if sys.stderr.isatty() and screen:
        webbrowser.open(address)

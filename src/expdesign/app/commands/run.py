"""`expdesign run`: the Pareto front of a configuration, its plans and its report."""

import os
import signal
import sys
import time
import webbrowser
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

import expdesign as xd
from expdesign.app.api.configuration import problem_of
from expdesign.app.api.inputs import purpose_of
from expdesign.app.commands import BEGUN
from expdesign.app.commands.console import note
from expdesign.app.commands.writing import Config, Force, require_folder
from expdesign.assurance.acceptance.decision import sentences
from expdesign.assurance.acceptance.planned import recommended_acceptance
from expdesign.io.output import new_folder

GROUP = ("way", 3)
"""Where it stands in the list of commands."""


def command(
    config: Config,
    out: Annotated[
        Path | None, typer.Option(help="Folder for the results; a new one under results/ if left out.")
    ] = None,
    watch: Annotated[
        bool, typer.Option("--watch", help="Show the front as it grows in the browser, where the run can be ended.")
    ] = False,
    seconds: Annotated[
        float | None, typer.Option(min=0.0, help="End after so many seconds in all, with what is there.")
    ] = None,
    port: Annotated[int, typer.Option(help="Of the page of --watch on this machine; any that is free if 0.")] = 0,
    force: Force = False,
) -> None:
    """Find the Pareto front of DUIR against FEIR and the recommended plan.

    Ctrl-C ends the search with what is there; all is written, and the plan before it is bounded.

    Example: expdesign run configs/hexapod-h1.yaml --out results/mine --watch
    """
    folder = out or new_folder(config.stem)
    require_folder(folder, xd.RunResult, purpose_of("run", config), force=force)
    if seconds is not None:  # what it took to get here counts too
        seconds = max(0.0, seconds - (time.perf_counter() - BEGUN))
    with _interruptible() as interrupted:
        if watch:
            result, page = _watched(config, folder, port, seconds, interrupted, force=force)
        else:
            result = xd.run(
                config,
                progress=True,
                ended=interrupted,
                seconds=seconds,
                searched=lambda run: run.save_plan(folder, force=force),
            )
            page = result.save(folder, force=force)
    print(result.summary)
    for text in sentences(recommended_acceptance(result.problem, result.front)):
        print(text)
    if "accuracy" in result.record:
        print(result.record["accuracy"]["sentence"])
    if result.record["duir_lower_bound"] is None:
        print(f"no lower bound of DUIR: {result.record['duir_lower_bound_certified_on']}")
    if result.protocol is not None:
        note(f"{folder / 'poses.csv'} has every pose to measure, references included; `expdesign correct` reads it")
    print(page)


@contextmanager
def _interruptible() -> Iterator[Callable[[], bool]]:
    """Whether somebody has pressed Ctrl-C; who presses it twice, ends the program."""
    pressed = False

    def note_it(number: int, frame: object) -> None:
        nonlocal pressed
        if pressed:
            raise KeyboardInterrupt
        pressed = True
        note("ending with the best plans so far; Ctrl-C again ends without them")

    before = signal.signal(signal.SIGINT, note_it)
    try:
        yield lambda: pressed
    finally:
        signal.signal(signal.SIGINT, before)


def _watched(
    config: Path,
    folder: Path,
    port: int,
    seconds: float | None,
    interrupted: Callable[[], bool],
    *,
    force: bool,
) -> tuple[xd.RunResult, Path]:
    """The run with a page on which it can be looked at and ended, and the path of its report."""
    from expdesign.app.watching.server import serve  # noqa: PLC0415 (needed here alone)
    from expdesign.app.watching.watched import Watched  # noqa: PLC0415

    problem = problem_of(config)
    watched = Watched(problem, str(folder))
    with serve(watched, port) as watch:
        note(f"watch it at {watch.address}")
        _open(watch.address)
        result = xd.run(
            problem,
            callback=watched.stage,
            progress=True,
            follow=watched.follow,
            ended=lambda: interrupted() or watched.wanted,
            seconds=seconds,
            searched=lambda run: run.save_plan(folder, force=force),
        )
        watched.stage("writing", 0, 0, "")
        page = result.save(folder, force=force)
        watched.ended("ended" if "ended_by_hand" in result.record else "finished")
        watch.report = page
    return result, page


def _open(address: str) -> None:
    """Open a page where a person sits at a screen; elsewhere the address has been said."""
    screen = sys.platform in ("darwin", "win32") or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    if sys.stderr.isatty() and screen:
        webbrowser.open(address)

"""`expdesign verify`: attained against predicted after compensation, with a test and a certificate."""

from pathlib import Path
from typing import Annotated

import typer

import expdesign as xd
from expdesign.app.api.inputs import purpose_of
from expdesign.app.commands.console import note
from expdesign.app.commands.writing import Folder, Force, OtherRobot, SharedReference, require_folder
from expdesign.assurance.acceptance.about import About, read_about

GROUP = ("way", 8)
"""Where it stands in the list of commands."""


def command(
    model: Annotated[Path, typer.Argument(help="Identified model (YAML) with which the commands were found.")],
    recordings: Annotated[Path, typer.Argument(help="Commands of `compensate` with what was measured (CSV).")],
    out: Folder,
    config: Annotated[
        Path | None, typer.Option(help="Run configuration (YAML) whose targets have the tolerances.")
    ] = None,
    about: Annotated[Path | None, typer.Option(help="Texts of the certificate (YAML).")] = None,
    coverage: Annotated[float | None, typer.Option(help="Of the expanded uncertainty; k = 2 if left out.")] = None,
    shared_reference: SharedReference = None,
    other_robot: OtherRobot = False,
    operator: Annotated[str, typer.Option(help="Who measured.")] = "",
    instrument: Annotated[str, typer.Option(help="What was measured with.")] = "",
    environment: Annotated[str, typer.Option(help="E.g. the temperature.")] = "",
    date: Annotated[str, typer.Option(help="When it was measured.")] = "",
    force: Force = False,
) -> None:
    """Compare the poses attained after compensation with predictions and tolerances, and write a certificate.

    Example: expdesign verify results/mine/model.yaml check.csv --config configs/hexapod-h1.yaml --out results/verified
    """
    require_folder(out, xd.VerificationResult, purpose_of("verify", model, recordings), force=force)
    given = {"operator": operator, "instrument": instrument, "environment": environment, "date": date}
    read = About() if about is None else read_about(about)
    texts = read.model_copy(update={key: value for key, value in given.items() if value})
    result = xd.verify(
        model,
        recordings,
        config=config,
        about=texts,
        coverage=coverage,
        shared_reference=shared_reference,
        other_robot=other_robot,
    )
    from expdesign.report.verification_report import statement  # noqa: PLC0415 (slow to import)

    page = result.save(out, force=force)
    found = result.result
    print(f"verdict: {found.verdict}")
    for text in statement(found):
        print(text)
    stated = ("remarks", "robot", "load")  # known from the model and the recordings otherwise
    empty = [name for name, text in texts.model_dump().items() if not text and name not in stated]
    if empty:
        note(f"left to be filled in by hand: {', '.join(empty)}")
    print(page)

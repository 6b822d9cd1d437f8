"""`expdesign verify`: attained against predicted after compensation, with a test and a certificate."""

from pathlib import Path
from typing import Annotated

import typer

import expdesign as xd
from expdesign.acceptance.about import About, read_about
from expdesign.commands.console import counted, note
from expdesign.files.output import require_writable


def command(
    model: Annotated[Path, typer.Argument(help="Identified model (YAML) with which the commands were found.")],
    recordings: Annotated[Path, typer.Argument(help="Commands of `compensate` with what was measured (CSV).")],
    out: Annotated[Path, typer.Option(help="Folder for the results.")],
    config: Annotated[
        Path | None, typer.Option(help="Run configuration (YAML) whose targets have the tolerances.")
    ] = None,
    about: Annotated[Path | None, typer.Option(help="Texts of the certificate (YAML).")] = None,
    coverage: Annotated[float | None, typer.Option(help="Of the expanded uncertainty; k = 2 if left out.")] = None,
    shared_reference: Annotated[
        bool, typer.Option("--shared-reference", help="Half of each row's variance is common to its series.")
    ] = False,
    operator: Annotated[str, typer.Option(help="Who measured.")] = "",
    instrument: Annotated[str, typer.Option(help="What was measured with.")] = "",
    environment: Annotated[str, typer.Option(help="E.g. the temperature.")] = "",
    date: Annotated[str, typer.Option(help="When it was measured.")] = "",
) -> None:
    """Compare the poses attained after compensation with predictions and tolerances, and write a certificate.

    Example: expdesign verify results/mine/model.yaml check.csv --config configs/hexapod-h1.yaml --out results/verified
    """
    require_writable(out)
    given = {"operator": operator, "instrument": instrument, "environment": environment, "date": date}
    read = About() if about is None else read_about(about)
    texts = read.model_copy(update={key: value for key, value in given.items() if value})
    result = xd.verify(
        model, recordings, config=config, about=texts, coverage=coverage, shared_reference=shared_reference
    )
    page = result.save(out)
    found = result.result
    comparison = found.comparison
    verdict = "as the model predicts" if found.consistent else "not as the model predicts"
    note(
        f"attained {verdict}: chi2 {comparison.chi2:.4g} for {comparison.residuals.size}, p = {comparison.p_value:.3g}"
    )
    open_axes = [axis for target in found.targets for axis in target.axes if axis.conformity == "not proven"]
    wrong = [axis for target in found.targets for axis in target.axes if axis.conformity == "does not conform"]
    note(f"verdict: {found.verdict}" + _reason(len(wrong), len(open_axes)))
    needed = [target.measurements_needed for target in found.targets if not target.passes]
    if found.verdict == "fail" and needed and None not in needed:
        most = max(count for count in needed if count is not None)
        note(f"if the mean errors stay as they are, {most} independent readings of every target would prove conformity")
    stated = ("remarks", "robot", "load")  # known from the model and the recordings otherwise
    empty = [name for name, text in texts.model_dump().items() if not text and name not in stated]
    if empty:
        note(f"left to be filled in by hand: {', '.join(empty)}")
    print(page)


def _reason(wrong: int, unproven: int) -> str:
    parts = []
    if wrong:
        parts.append(f"{counted(wrong, 'axis') if wrong == 1 else f'{wrong} axes'} beyond tolerance")
    if unproven:
        parts.append(f"{'1 axis' if unproven == 1 else f'{unproven} axes'} not proven to be within")
    return f" ({', '.join(parts)})" if parts else ""

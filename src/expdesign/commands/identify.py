"""`expdesign identify`: stiffness with confidence intervals, from recordings."""

from pathlib import Path
from typing import Annotated

import typer

from expdesign.commands.console import note, note_unknown_columns
from expdesign.errors import InputError
from expdesign.files.output import json_text, output_folder, require_writable, write_file
from expdesign.files.yaml_reader import read_yaml
from expdesign.identification.identify import Identification, identify
from expdesign.identification.model_file import Model, model_text
from expdesign.identification.record import identification_record, rms, stiffness_unit
from expdesign.recordings.reader import read_several
from expdesign.robots.robot_file import robot_from_document

SMALLEST_PRIOR = 1e-6
"""%; a smaller deviation would say that nothing has to be identified."""


def command(
    robot: Annotated[Path, typer.Argument(help="Robot (YAML).")],
    recordings: Annotated[list[Path], typer.Argument(help="Recordings (CSV), in one or more files.")],
    out: Annotated[Path, typer.Option(help="Folder for the results.")],
    shared_reference: Annotated[
        bool,
        typer.Option("--shared-reference", help="Half of each row's variance is common to its series."),
    ] = False,
    prior: Annotated[
        float | None, typer.Option(help="Relative standard deviation of `actuator_stiffness` beforehand, in percent.")
    ] = None,
) -> None:
    """Identify the stiffness of every actuator from recordings.

    Example: expdesign identify configs/robots/hexapod-h1.yaml recordings.csv --out results/mine
    """
    from expdesign.report.identification_report import identification_report  # noqa: PLC0415 (slow to import)
    from expdesign.report.stored import write_report  # noqa: PLC0415

    if prior is not None and not SMALLEST_PRIOR <= prior < float("inf"):
        raise InputError(f"{prior:g} % is not a standard deviation", where="--prior", remedy="Give e.g. 30.")
    require_writable(out)
    document = read_yaml(robot)
    measured = read_several(recordings, robot_from_document(document))
    note_unknown_columns(measured)
    result = identify(
        robot_from_document(document),
        measured,
        shared_reference=shared_reference,
        prior=None if prior is None else prior / 100.0,
    )
    model = Model.from_fit(result.fit, document, measured.source)
    record = identification_record(result)
    with output_folder(out) as scratch:
        write_file(scratch / "model.yaml", model_text(model, out))
        write_file(scratch / "identification.json", json_text(record))
        write_report(scratch, identification_report(result))
    _summarise(result)
    print(out / "report.html")


def _summarise(result: Identification) -> None:
    unit = stiffness_unit(result)
    for index, name in enumerate(result.robot.actuators):
        interval = result.stiffness
        note(
            f"{name}: {interval.estimate[index]:.4g} {unit} "
            f"(95 %: {interval.low[index]:.4g} to {interval.high[index]:.4g})"
        )
    goodness = result.goodness
    if goodness.p_value is not None:
        verdict = "" if goodness.p_value >= 0.01 else "; the base model does not explain them, see `expdesign diagnose`"
        dof = f"{goodness.dof} degrees of freedom"
        note(f"chi2 {result.fit.chi2:.6g} for {dof}, p = {goodness.p_value:.3g}{verdict}")
    else:
        for group in result.noise.groups:
            note(f"noise of the {group.name}, estimated from {result.noise.origin}: {group.deviation:.3g}")
    if goodness.lack_of_fit is not None:
        note(f"lack of fit against replicates: p = {goodness.lack_of_fit.p_value:.3g}")
    outliers = int(result.influence.outlier.sum())
    if outliers:
        note(f"{outliers} row(s) look like outliers; they are listed in the report")
    held_out = rms(result.test_residuals)
    if held_out is not None:
        note(f"RMS of the test rows: {held_out:.3g} standard deviations")
    for text in result.suspicions:
        note(f"suspicion: {text}")

"""`diagnose`: where and why the model and the recordings differ."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated

from expdesign.app.api.arguments import Within
from expdesign.app.api.callbacks import Callback, shows_progress, silent
from expdesign.app.api.inputs import RobotInput, purpose_of
from expdesign.app.api.recorded import RecordingsInput, recorded_at, recorded_model
from expdesign.assurance.plausibility.finding import Implausibility, say
from expdesign.assurance.plausibility.recordings import doubts
from expdesign.chain.models.model_file import Model, model_from_document, model_text
from expdesign.chain.recordings.recordings import Recordings, complete_positions
from expdesign.diagnosis.diagnose import diagnose as diagnose_recordings
from expdesign.diagnosis.result import Diagnosis
from expdesign.diagnosis.stages import Stage
from expdesign.errors import InputError
from expdesign.estimation.load_errors import declared_load_errors
from expdesign.io.yaml_reader import parse_yaml
from expdesign.report.diagnosis_report import DiagnosisResult

if TYPE_CHECKING:  # most recordings are diagnosed without targets, and need not wait for planning
    from expdesign.app.api.configuration import Config

Series = Annotated[int, Within("a number of series", "Use at least 1.", 1)]


def _read_here(recordings: Recordings) -> Recordings:
    """Complete positions where markers are measured; what an identification fits beside them is named in a warning."""
    found = complete_positions(recordings)
    if found is recordings:
        return found
    if not len(found):
        what = f"none of {len(recordings)} rows has all three coordinates of a position, which a diagnosis reads"
        remedy = "`expdesign identify` fits single coordinates, distances and gauges; add complete positions."
        raise InputError(what, where=recordings.source, remedy=remedy)
    kinds = {
        "rows with fewer than three coordinates of a position, a distance or a gauge": len(recordings) - len(found),
        "orientations of targets": 0 if recordings.aim is None else len(found),
    }
    left = " and ".join(f"{count} {kind}" for kind, count in kinds.items() if count)
    if left:
        remedy = "`expdesign identify` fits them with the positions; here they are left out."
        say([Implausibility(f"a diagnosis reads complete positions, not {left}", remedy)], recordings.source)
    return found


def _read_again(result: Diagnosis, model: Model) -> Diagnosis:
    """The diagnosis with how far its file is from what it says of itself; infinite where the file is refused."""
    text = model_text(model, model.folder)
    try:
        again = model_from_document(parse_yaml(text, "model.yaml", model.folder))
    except InputError:
        return result.written_otherwise(float("inf"))
    return result.read_again(again.chain, again.values)


@shows_progress("diagnosing")
def diagnose(
    robot: RobotInput,
    recordings: RecordingsInput,
    *,
    series: Series = 3,
    shared_reference: bool | None = None,
    targets: Config | None = None,
    without: Collection[str] = (),
    other_robot: bool = False,
    interruptible: bool = False,
    callback: Callback | None = None,
    progress: bool = False,
) -> DiagnosisResult:
    """Say where the recordings and the model differ, which physics was left out, and whether adding it helps.

    Args:
        robot: robot (YAML) that was measured.
        recordings: recordings (CSV), in one or more files. In Python also a frame.
        series: number of series in `plan-next.csv`, the plan that separates two remaining explanations.
        shared_reference: whether all rows of one series share the noise of one unloaded reading; if left out, as the
            recordings or the configuration of `targets` say.
        targets: run configuration (YAML) of this robot: the diagnosed model is accepted or rejected at its targets.
            Where the recordings are consistent, the report also states which errors they may still hide there. Where
            the configuration calibrates the geometry of an arm (`calibration: both`), nothing is stated about hidden
            errors.
        without: identifiers of physics that the library shall not offer (file-formats.md, Identifiers of physics): what
            it is then taken for, and how well a law at a port stands in for it.
        other_robot: accept a configuration whose robot has another geometry.
        interruptible: whether a `KeyboardInterrupt` ends the search with the best model so far, once there is one.
        callback: called with `diagnosing`, the number of the stage, 0 and a sentence on what is being done (`Stage`).
        progress: whether progress is shown on standard error.

    Raises:
        InputError: a file is missing or wrong.
        SingularConfigurationError: the robot is singular in a row.
        NotIdentifiableError: the recordings do not determine the stiffness.

    Example:
        >>> xd.diagnose("configs/robots/bipod.yaml", "recordings.csv").record["verdict"]
        'consistent'

    Command:
        Ctrl-C ends it and keeps the best model so far; a second Ctrl-C keeps nothing.

        expdesign diagnose configs/robots/hexapod-h1.yaml recordings.csv --out results/diagnosis
    """
    machine, measured, problem = recorded_at(
        robot, recordings, targets, shared_reference, confirmed=other_robot, usable=_read_here
    )
    if problem is not None and not machine.robot.jointed:
        problem.require_elastostatic("what recordings hide is known")

    def report(stage: Stage, detail: str) -> None:
        (callback or silent)("diagnosing", stage.number, 0, stage.of_all(detail))

    if problem is not None:
        from expdesign.assurance.acceptance.fitted import require_what_is_calibrated  # noqa: PLC0415 (of targets)

        require_what_is_calibrated(problem, shown=measured.measurand.absolute)
    result = diagnose_recordings(
        machine.robot,
        measured,
        without=frozenset(without),
        load_errors=declared_load_errors(machine.robot, measured, None if problem is None else problem.load_errors),
        estimator="generalised" if problem is None else problem.estimator,
        interruptible=interruptible,
        report=report,
    )
    calibrated = None if result.verdict == "consistent" else result.calibrated
    result = replace(result, doubts=doubts(measured, machine.robot, result.after.left, calibrated))
    model = recorded_model(
        result,
        result.known,
        machine,
        ~result.recordings.test,
        birge_ratio=max(1.0, result.widening.parameters),  # less is noise that was stated too large
        fit="refuted" if result.refuted else result.after.verdict,
        drawn=result.drawn,
    )
    result = _read_again(result, model)
    at_targets = None
    if problem is not None:
        from expdesign.report.at_targets import AtTargets  # noqa: PLC0415 (of targets)

        at_targets = AtTargets.diagnosed(problem, result)
        # Sizes and motions of hidden physics are those of deflections.
        sought = problem.loaded.regressor.referenced
        if sought and result.verdict == "consistent" and not result.ended:
            report(Stage.HIDDEN, "")
            try:
                at_targets.look_for_hidden()
            except KeyboardInterrupt:
                if not interruptible:
                    raise
                result = replace(result, ended=Stage.HIDDEN.value)
    purpose = purpose_of("diagnose", robot, recordings)
    return DiagnosisResult(machine, model, result, series, at_targets=at_targets, purpose=purpose)

"""`identify`: stiffness with confidence intervals, from recordings."""

from __future__ import annotations

import sys
from collections.abc import Collection
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Literal

from expdesign.app.api.arguments import Within, named_arguments
from expdesign.app.api.inputs import RobotInput, purpose_of
from expdesign.app.api.recorded import RecordingsInput, recorded_at, recorded_model
from expdesign.assurance.plausibility.recordings import doubts
from expdesign.errors import ArgumentError
from expdesign.estimation.arm_options import ArmOptions, Further, Held, Loss
from expdesign.estimation.identify import Identification
from expdesign.estimation.identify import identify as identify_recordings
from expdesign.mechanics.elastostatics.calibration import Calibration
from expdesign.report.identification_report import IdentificationResult

if TYPE_CHECKING:  # most recordings are identified without targets, and need not wait for planning
    from expdesign.app.api.configuration import Config

Percent = Annotated[float | None, Within("a standard deviation in %", "Give e.g. 30.", 1e-6, sys.float_info.max)]
"""A smaller one would say that nothing has to be identified."""

Frames = Literal["known", "unknown"]


def with_doubts(result: Identification) -> Identification:
    """An identification that says, before its own remarks, what physics holds against its recordings."""
    found = doubts(result.recordings, result.robot, result.goodness.left, result.arm)
    return replace(result, suspicions=[*found, *result.suspicions])


@named_arguments
def identify(
    robot: RobotInput,
    recordings: RecordingsInput,
    *,
    shared_reference: bool | None = None,
    prior: Percent = None,
    targets: Config | None = None,
    calibration: Calibration | None = None,
    frames: Frames = "known",
    other_robot: bool = False,
    loss: Loss = "squares",
    further: Collection[Further] = (),
    hold: Collection[Held] = (),
    accept: bool = False,
) -> IdentificationResult:
    """Identify the stiffness of every actuator, the geometry, or both from recordings.

    Args:
        robot: robot (YAML).
        recordings: recordings (CSV), in one or more files. In Python also a frame.
        shared_reference: whether all rows of one series share the noise of one unloaded reading; if left out, as the
            recordings or the configuration of `targets` say.
        prior: prior relative standard deviation of `actuator_stiffness`, in percent; no prior if left out.
        targets: run configuration (YAML): the robot is accepted or rejected at its targets, and its `experiment`
            declares the load errors and the estimator.
        calibration: what to identify: `elastostatic` (stiffness), `geometric` or `both`; if left out, the columns of
            the recordings decide.
        frames: `known`, or `unknown` where measured poses are in other frames than the commands: the displacements of
            the frames of instrument and platform are then identified as well.
        other_robot: accept a configuration whose robot has another geometry.
        loss: how large residuals of an arm's positions count: `squares`, or less with `huber` or `student`.
        further: further errors of an arm to identify from positions: `masses` (of links), `tool` (mass and first
            moments), `harmonics` (errors that repeat with every turn of a joint), `drift` (of the instrument against
            the base, over time).
        hold: groups of an arm's parameters that stay at the drawing: `zeros`, `lengths`, `angles`, `compliances`; the
            recordings decide how large the errors of all others are.
        accept: write corrections of an arm's geometry into `robot.urdf` even where they exceed manufacturing errors.

    Raises:
        InputError: a file is missing or wrong.
        SingularConfigurationError: the robot is singular in a row.
        NotIdentifiableError: the recordings do not determine the stiffness or the geometry.

    Example:
        >>> result = xd.identify("configs/robots/bipod.yaml", "recordings.csv")
        >>> result.stiffness["estimate"].round(-4).tolist()  # N/m
        [10080000.0, 13030000.0]
        >>> result.save("identified").name
        'report.html'

    Command:
        expdesign identify configs/robots/hexapod-h1.yaml recordings.csv --out results/mine
    """
    machine, measured, problem = recorded_at(robot, recordings, targets, shared_reference, confirmed=other_robot)
    relative = None if prior is None else prior / 100.0
    for argument, names in (("further", further), ("hold", hold)):
        if names and not (machine.robot.jointed and measured.measurand.absolute):
            what = f"{', '.join(names)} show in positions or poses of an arm"
            raise ArgumentError(what, argument=argument, remedy="Leave it out.")
    result = identify_recordings(
        machine.robot,
        measured,
        prior=relative,
        calibration=calibration,
        frames_known=frames == "known",
        options=ArmOptions(loss=loss, further=tuple(further), hold=tuple(hold)),
        load_errors=None if problem is None else problem.load_errors,
        estimator="generalised" if problem is None else problem.estimator,
    )
    result = with_doubts(result)
    at_targets = None
    if problem is not None:
        from expdesign.assurance.model_error.meir import meir_of_problem  # noqa: PLC0415 (of targets)
        from expdesign.report.at_targets import AtTargets  # noqa: PLC0415 (of targets)

        at_targets = AtTargets.identified(problem, result)
        if meir_of_problem(problem) is not None:
            at_targets.look_for_hidden()
    goodness = result.goodness
    model = recorded_model(
        result,
        result.fit,
        machine,
        result.fitted,
        birge_ratio=goodness.birge_ratio,
        fit=goodness.verdict,
        drawn=None if result.arm is None else result.arm.drawn,
    )
    purpose = purpose_of("identify", robot, recordings)
    return IdentificationResult(machine, model, result, at_targets=at_targets, accepted=accept, purpose=purpose)

"""Recordings of a robot, as functions take them, with their references and targets, and the model of a fit to them."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

from expdesign.app.api.inputs import RobotInput, load_robot, table_of
from expdesign.app.api.points_said import say_unknown_columns
from expdesign.arrays import BoolArray
from expdesign.assurance.plausibility.finding import Implausibility, say
from expdesign.assurance.plausibility.recordings import recordings_findings
from expdesign.chain.models.estimable import Calibrated
from expdesign.chain.models.model_file import Model
from expdesign.chain.recordings.reader import read_several, recordings_from_table, require_measured
from expdesign.chain.recordings.recordings import DEFLECTIONS, Recordings
from expdesign.chain.recordings.references import Points, Sharing, with_references
from expdesign.errors import InputError
from expdesign.estimation.fit import Fit
from expdesign.mechanics.robots.robot_file import RobotFile
from expdesign.report.result import PathLike, Result

if TYPE_CHECKING:  # most recordings have no targets, and need not wait for planning
    from expdesign.app.api.configuration import Config
    from expdesign.diagnosis.result import Diagnosis
    from expdesign.estimation.identify import Identification
    from expdesign.planning.problem import DesignProblem

RecordingsInput = PathLike | Sequence[PathLike] | pd.DataFrame | Recordings | Result


def read_recordings(recordings: RecordingsInput, robot: RobotInput) -> Recordings:
    """Recordings of a robot, from one or more files or from a frame.

    Raises:
        InputError: a file is missing or wrong.
    """
    if isinstance(recordings, Recordings):
        return recordings
    machine = load_robot(robot).robot
    if isinstance(recordings, pd.DataFrame | Result):
        measured = recordings_from_table(table_of(recordings, "recordings"), machine)
        require_measured(measured, machine)
    else:
        files = [recordings] if isinstance(recordings, str | Path) else recordings
        if not isinstance(files, list | tuple) or not all(isinstance(file, str | Path) for file in files):
            what = f"recordings cannot be a `{type(recordings).__name__}`"
            remedy = "Give one path or several, a frame, `Recordings`, or what `simulate` returned."
            raise InputError(what, remedy=remedy)
        measured = read_several([Path(file) for file in files], machine)
    say(recordings_findings(measured, machine), measured.source)
    say_unknown_columns(measured)
    return measured


def recorded_at(
    robot: RobotInput,
    recordings: RecordingsInput,
    targets: "Config | None",
    option: bool | None,
    *,
    confirmed: bool,
    usable: Callable[[Recordings], Recordings] = lambda recordings: recordings,
) -> "tuple[RobotFile, Recordings, DesignProblem | None]":
    """A robot, its recordings with their references, and the configuration at whose targets something is said of it.

    Args:
        robot: that was measured.
        recordings: of it.
        targets: run configuration, or None.
        option: whether series share their reference, where the caller says so.
        confirmed: whether a configuration of another geometry is meant.
        usable: what is used of the recordings.

    Raises:
        InputError: a file is wrong, or the configuration is of another robot.
    """
    machine, problem = load_robot(robot), None
    if targets is not None:
        from expdesign.app.api.configuration import problem_of_robot  # noqa: PLC0415 (most recordings have no targets)

        problem = problem_of_robot(targets, machine.robot, machine.document.source, confirmed=confirmed)
    measured = referenced(usable(read_recordings(recordings, machine)), option, problem)
    if problem is not None:
        from expdesign.assurance.plausibility.configured import recorded_findings  # noqa: PLC0415 (of configurations)

        say(recorded_findings(measured, problem), measured.source)
    return machine, measured if problem is None else correlated(measured, problem), problem


def correlated(recordings: Recordings, problem: "DesignProblem") -> Recordings:
    """Recordings of deflections whose readings of a row are correlated as a configuration states.

    Where their standard deviations are estimated, each component is by itself.
    """
    if recordings.measurand is not DEFLECTIONS or recordings.deviations is None:
        return recordings
    pose_map = problem.loaded.robot.jacobians(recordings.configurations).pose
    return replace(recordings, within=problem.noise.within(recordings.axes, pose_map))


def referenced(points: Points, option: bool | None, problem: "DesignProblem | None" = None) -> Points:
    """The points with their references; contradictions are logged as warnings (`chain/recordings/references.py`).

    Args:
        points: recordings, or a check measurement's points.
        option: what the caller says, which overrides; None where nothing is said.
        problem: of the configuration that is given with them.
    """
    configured = None if problem is None else problem.noise.shared_reference
    source = "" if problem is None else problem.source
    found, contradictions = with_references(points, Sharing(option, configured, source))
    say([Implausibility(one.what, one.holds, "shared references") for one in contradictions], points.source)
    return found


def recorded_model(
    result: "Identification | Diagnosis", found: Fit, robot: RobotFile, fitted: BoolArray, **stated: Any
) -> Model:
    """The model of a fit, with what its recordings say of predictions.

    Args:
        result: of which the fit is.
        found: parameters and covariance.
        robot: with its file.
        fitted: rows that the fit has seen, shape (N,).
        stated: of the model: its Birge ratio, the verdict of the test of fit (`fit`), what is as drawn.
    """
    recordings, loads = result.recordings, result.loads
    names = recordings.deviation_columns(robot.robot.coordinates)
    return replace(
        Model.from_fit(found, robot.document, recordings.source),
        reading_std=dict(zip(names, result.reading_deviations.tolist(), strict=True)),
        calibrated=Calibrated.of(recordings.rows(fitted), found.chain.robot, ordered=found.chain.counts_rows),
        acting=None if loads is None else loads.at_targets(found),
        **stated,
    )

"""`verify`: a check measurement of compensated poses, and the certificate."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import numpy as np

from expdesign.app.api.arguments import Within, named_arguments
from expdesign.app.api.configuration import Config, problem_of_robot
from expdesign.app.api.inputs import ModelInput, TableInput, document_of, load_model, purpose_of, table_of
from expdesign.app.api.recorded import referenced
from expdesign.arrays import FloatArray
from expdesign.assurance.acceptance.attained import attained_at, compare
from expdesign.assurance.acceptance.certificate import About
from expdesign.assurance.acceptance.check_measurement import CheckMeasurement, read_check_measurement
from expdesign.assurance.acceptance.conformity import judge
from expdesign.assurance.acceptance.verification import Verification
from expdesign.assurance.plausibility.finding import say
from expdesign.assurance.plausibility.recordings import recordings_findings
from expdesign.chain.models.model_file import Model
from expdesign.chain.readings.position import Frame
from expdesign.chain.recordings.recordings import Recordings
from expdesign.errors import InputError
from expdesign.estimation.compensation.arm_targets import instrument_of
from expdesign.estimation.compensation.prediction import after_campaign, require_history, require_regular_points
from expdesign.estimation.compensation.target_loads import TargetLoads
from expdesign.estimation.coverage import STANDARD, Coverage
from expdesign.io.schema import validate
from expdesign.planning.problem import DesignProblem
from expdesign.report.result import PathLike
from expdesign.report.verification_report import VerificationResult

SAME = 1e-6
"""Relative difference below which standard deviations are those that `compensate` wrote."""
MISTAKES = 100.0
"""Factor by which another reading must reduce the misfit: few rows, of a robot that is off by what it deflects."""

Share = Annotated[float | None, Within("a coverage", "Give e.g. 0.95.", 0.0, 1.0, strict=True)]


@named_arguments
def verify(
    model: ModelInput,
    recordings: TableInput,
    *,
    config: Config | None = None,
    about: PathLike | Mapping[str, str] | About | None = None,
    coverage: Share = None,
    shared_reference: bool | None = None,
    other_robot: bool = False,
    frame: Frame = "base",
) -> VerificationResult:
    """Compare the poses attained after compensation with predictions and tolerances, and write a certificate.

    Args:
        model: identified model (YAML) that `compensate` used.
        recordings: commands written by `compensate`, with the measurements filled in (CSV).
        config: run configuration (YAML) with the tolerances of the targets (and the noise, where the recordings do not
            state it).
        about: names, dates and traceability to print on the certificate (YAML).
        coverage: coverage of the expanded uncertainty; if left out, the configuration's, or that of k = 2.
        shared_reference: whether all rows of one series share the noise of one unloaded reading; if left out, as the
            recordings or the configuration of `config` say.
        other_robot: accept a configuration whose robot has another geometry.
        frame: frame of `target_x_m` ... and `measured_x_m` ... of an arm's tip: `base`, or `instrument` as identified;
            the same as for `compensate`. Errors and tolerances are along the axes of the base.

    Raises:
        InputError: a file is missing or wrong.
        SingularConfigurationError: the robot is singular at a command.
        NotIdentifiableError: the model did not determine what a prediction needs.

    Example:
        >>> checked = xd.verify("identified/model.yaml", "check.csv", config="configs/bipod.yaml")
        >>> checked.record["verdict"]
        'not proven'

    Command:
        expdesign verify results/mine/model.yaml check.csv --config configs/hexapod-h1.yaml --out results/verified
    """
    identified = load_model(model)
    robot = identified.chain.robot
    table = table_of(recordings, "recordings")
    require_history(identified, table)
    if frame == "instrument":
        instrument_of(identified)  # or a message
    check = read_check_measurement(table, robot, frame)
    require_regular_points(robot, check.points)
    check = replace(check, points=after_campaign(identified, check.points))
    problem = problem_of_robot(config, robot, identified.source, confirmed=other_robot)
    loads = TargetLoads.of_table(table, robot.coordinates)
    acting = identified.at_targets
    deviations = _deviations(acting, check, loads, problem)
    check = replace(check, points=referenced(check.points, shared_reference, problem))
    comparison = compare(acting, check, deviations, loads)
    chosen = Coverage(coverage) if coverage is not None else STANDARD if problem is None else problem.coverage
    columns = [robot.coordinates.deflection[axis] for axis in check.axes]
    statement = comparison.statement(check.points, columns)
    if statement.refuted and not check.absolute:  # by a mistake in the file, perhaps
        rows = {**vars(check.points), "test": np.zeros(len(check), dtype=bool)}
        read = Recordings(**rows, axes=check.axes, deflections=check.readings, deviations=deviations)
        say([finding for finding in recordings_findings(read, robot, MISTAKES) if finding.otherwise], read.source)
    judged = judge(check, comparison, problem, chosen, robot, loads)
    result = Verification(comparison, statement, judged, chosen, identified.fit == "refuted")
    texts = validate(About, document_of(about or {}, "about"))
    files = [one for one in (model, recordings, config, about) if isinstance(one, str | Path) and Path(one).is_file()]
    hashes = {str(one): hashlib.sha256(Path(one).read_bytes()).hexdigest() for one in files}
    return VerificationResult(identified, check, result, texts, hashes, purpose=purpose_of("verify", model, recordings))


def _deviations(model: Model, check: CheckMeasurement, loads: TargetLoads, problem: DesignProblem | None) -> FloatArray:
    """Standard deviations of the readings (N, k): the recordings' own, or those of the configuration."""
    if check.deviations is not None:
        predicted = attained_at(model, check, loads).deviations[:, check.axes]
        # What `compensate` wrote into `sx_m …` is how well the pose is predicted, not how well it was measured.
        if (np.abs(check.deviations - predicted) > SAME * predicted).any():
            return check.deviations
    if problem is not None:
        noise = problem.noise
        pose_map = model.chain.robot.jacobians(check.points.configurations).pose
        of_axes = dict(zip(noise.axes.tolist(), noise.deviations_at(pose_map).T, strict=True))
        if all(int(axis) in of_axes for axis in check.axes):
            return np.stack([of_axes[int(axis)] for axis in check.axes], axis=-1)
    names = ", ".join(model.chain.robot.coordinates.deviation[axis] for axis in check.axes)
    what = "how well the poses were measured is not stated"
    if check.deviations is not None:
        what += " (the standard deviations are still those of the prediction, which `compensate` wrote)"
    remedy = f"Write those of the instrument into {names}, or give a configuration with them (argument `config`)."
    raise InputError(what, where=check.points.source, remedy=remedy)

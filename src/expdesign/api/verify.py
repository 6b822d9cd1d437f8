"""`verify`: a check measurement of compensated poses, and the certificate."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from expdesign.acceptance.about import About, about_of, read_about
from expdesign.acceptance.budget import tolerances
from expdesign.acceptance.check_measurement import CheckMeasurement, read_check_measurement
from expdesign.acceptance.record import verification_record
from expdesign.acceptance.verification import Tolerances, Verification, compare, judge
from expdesign.api.inputs import Config, ModelInput, PathLike, TableInput, model_of, problem_of, table_of
from expdesign.arrays import FloatArray
from expdesign.compensation.prediction import chain_of, predict_with, require_history, require_regular_points
from expdesign.design.coverage import STANDARD, Coverage
from expdesign.design.problem import DesignProblem
from expdesign.errors import InputError
from expdesign.files.output import json_text, output_folder, write_file
from expdesign.models.model_file import Model
from expdesign.report.page import Page

SAME = 1e-6
"""Relative difference below which standard deviations are those that `compensate` wrote."""


@dataclass(frozen=True)
class Verified:
    """A verified robot.

    Attributes:
        model: of the robot.
        check: what was measured.
        result: what it says.
        about: texts of the certificate.
        files: SHA-256 of every file, by its name.
    """

    model: Model
    check: CheckMeasurement
    result: Verification
    about: About
    files: dict[str, str]

    @property
    def record(self) -> dict[str, Any]:
        """The content of `verification.json`."""
        robot = self.model.chain.robot
        axes = tuple(robot.coordinates.deflection[axis] for axis in self.check.axes)
        return verification_record(self.result, robot, axes, self.about, self.files)

    def page(self) -> Page:
        """The certificate."""
        from expdesign.report.verification_report import verification_report  # noqa: PLC0415 (slow to import)

        return verification_report(self.result, self.model, self.check, self.about, self.files)

    def save(self, folder: PathLike) -> Path:
        """Write the files of `expdesign verify` into a folder and return the path of the certificate."""
        from expdesign.report.stored import PAGE, write_report  # noqa: PLC0415 (slow to import)

        with output_folder(Path(folder)) as scratch:
            write_file(scratch / "verification.json", json_text(self.record))
            write_report(scratch, self.page())
        return Path(folder) / PAGE


def verify(
    model: ModelInput,
    recordings: TableInput,
    *,
    config: Config | None = None,
    about: PathLike | Mapping[str, str] | About | None = None,
    coverage: float | None = None,
    shared_reference: bool = False,
) -> Verified:
    """Compare poses attained at compensated commands with what was predicted, and with their tolerances.

    Args:
        model: identified robot, with which the commands were found.
        recordings: the commands as `compensate` wrote them, with what was measured filled in.
        config: run configuration that names the tolerances (and the noise, where the recordings do not).
        about: texts of the certificate.
        coverage: of the expanded uncertainty; the configuration's, or that of k = 2, if left out.
        shared_reference: whether half of each row's variance is common to its series.

    Raises:
        InputError: a file is missing or wrong.
        SingularConfigurationError: the robot is singular at a command.
        NotIdentifiableError: the model did not determine what a prediction needs.
    """
    if coverage is not None and not 0.0 < coverage < 1.0:
        raise InputError(f"{coverage:g} is not a coverage", where="--coverage", remedy="Give e.g. 0.95.")
    identified = model_of(model)
    robot = identified.chain.robot
    table = table_of(recordings, "recordings")
    require_history(identified, table)
    check = read_check_measurement(table, robot)
    require_regular_points(robot, check.points)
    problem = None if config is None else problem_of(config)
    if problem is not None:
        _require_same_robot(problem, identified)
    deviations = _deviations(identified, check, problem)
    comparison = compare(identified, check, deviations, shared_reference=shared_reference)
    chosen = Coverage(coverage) if coverage is not None else STANDARD if problem is None else problem.coverage
    limits = None
    if problem is not None:
        limits = Tolerances(problem.targets.configurations, tolerances(problem), problem.targets.axes)
    result = Verification(comparison, judge(check, comparison, limits, chosen, robot), chosen)
    return Verified(identified, check, result, _about(about), _hashes(model, recordings, config, about))


def _require_same_robot(problem: DesignProblem, model: Model) -> None:
    robot, other = problem.loaded.robot, model.chain.robot
    if robot.kind != other.kind or robot.configuration != other.configuration:
        what = f"the configuration is of a {robot.kind}, and the model of a {other.kind}"
        raise InputError(what, where=problem.source, remedy="Give the configuration of the robot that was measured.")


def _deviations(model: Model, check: CheckMeasurement, problem: DesignProblem | None) -> FloatArray:
    """Standard deviations of the readings (N, k): the recordings' own, or those of the configuration."""
    if check.deviations is not None:
        predicted = predict_with(chain_of(model, platform=True), model, check.points).deviations[:, check.axes]
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
    remedy = f"Write the instrument's standard deviations into {names}, or give a configuration with them (--config)."
    raise InputError(what, where=check.points.source, remedy=remedy)


def _about(about: PathLike | Mapping[str, str] | About | None) -> About:
    if about is None or isinstance(about, About):
        return about or About()
    return about_of(dict(about)) if isinstance(about, Mapping) else read_about(Path(about))


def _hashes(*inputs: object) -> dict[str, str]:
    """SHA-256 of the inputs that are files, by their names."""
    found: dict[str, str] = {}
    for one in inputs:
        if isinstance(one, str | Path) and Path(one).is_file():
            found[str(one)] = hashlib.sha256(Path(one).read_bytes()).hexdigest()
    return found

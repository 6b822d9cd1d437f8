"""The parts of a run configuration that say how poses are measured, and along which axes accuracy is wanted."""

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.instrument.deflection_noise import DeflectionNoise, ReferencedNoise
from expdesign.chain.readings.registration import pose_covariance
from expdesign.coordinates import Coordinates
from expdesign.errors import InputError
from expdesign.io.nearest import nearest
from expdesign.io.schema import LARGEST
from expdesign.io.yaml_reader import KeyPath, YamlDocument
from expdesign.mechanics.robots.robot import Robot
from expdesign.planning.body_axes import body_axes
from expdesign.planning.schema import DeflectionNoiseSection, ExperimentSection, MeasuredPointsSection, TargetSection

_EXPERIMENT: KeyPath = ("experiment",)


def read_noise(section: DeflectionNoiseSection, robot: Robot, document: YamlDocument) -> DeflectionNoise:
    """The noise of `experiment.deflection_noise`.

    Raises:
        InputError: an axis is unknown, or the covariance is none.
    """
    coordinates = robot.coordinates
    where: KeyPath = (*_EXPERIMENT, "deflection_noise")
    if section.std is not None:
        axes = [axis_of(name, coordinates, document, (*where, "std")) for name in section.std]
        if not axes:
            raise InputError("no axis is measured", where=document.where((*where, "std")), remedy="Name at least one.")
        order = np.argsort(axes)
        deviations = np.array(list(section.std.values()))[order]
        return DeflectionNoise.from_deviations(np.array(axes)[order], deviations, section.shared_reference)
    if section.points is not None:
        return _noise_of_points(section.points, robot, document, shared_reference=section.shared_reference)
    rows = section.covariance or []
    place = document.where((*where, "covariance"))
    if len(rows) != coordinates.n or any(len(row) != coordinates.n for row in rows):
        what = f"a matrix of {coordinates.n}×{coordinates.n} is needed here"
        raise InputError(what, where=place, remedy=f"Order: {', '.join(coordinates.deflection)}.")
    matrix = np.array(rows)
    if np.any(np.diag(matrix) <= LARGEST**-2):
        raise InputError(
            "a variance is not positive (or below any that is)", where=place, remedy="Correct the diagonal."
        )
    scale = np.sqrt(np.diag(matrix))
    if np.abs((matrix - matrix.T) / np.outer(scale, scale)).max() > 1e-6:
        raise InputError("the matrix is not symmetric", where=place, remedy="Correct it.")
    try:
        return DeflectionNoise(np.arange(coordinates.n), (matrix + matrix.T) / 2.0, section.shared_reference)
    except InputError as error:
        raise InputError(error.what, where=place, remedy=error.remedy) from None


def axis_of(name: str, coordinates: Coordinates, document: YamlDocument, where: KeyPath) -> int:
    """Index of a pose coordinate by the name of its deflection; an `InputError` where there is none."""
    if name not in coordinates.deflection:
        remedy = nearest(name, coordinates.deflection)
        raise InputError("unknown axis", where=document.where((*where, name)), remedy=remedy)
    return coordinates.deflection.index(name)


def _noise_of_points(
    section: MeasuredPointsSection, robot: Robot, document: YamlDocument, *, shared_reference: bool
) -> DeflectionNoise:
    """Noise of deflections whose poses are registered from points (theory.md 9.A): twice the covariance of one pose.

    The covariance is that at `section.pose` (the zero pose where it is left out), for all measurements.

    Raises:
        InputError: the robot has no orientation, or the points do not determine one.
    """
    where: KeyPath = (*_EXPERIMENT, "deflection_noise", "points")
    if robot.coordinates.n != 6 or len(robot.configuration) != 6:
        what = "points are for robots with six pose coordinates"
        raise InputError(what, where=document.where(where), remedy="Give `std` or `covariance`.")
    pose = np.zeros(6) if section.pose is None else np.array(section.pose)
    if len(pose) != 6:
        raise InputError("6 numbers are needed here", where=document.where((*where, "pose")), remedy="Correct it.")
    rotation, rates = robot.jacobians(pose).rotation, robot.pose_rates(pose)
    try:
        covariance = pose_covariance(np.array(section.positions), section.std_m, rotation, rates)
    except InputError as error:
        raise InputError(error.what, where=document.where((*where, "positions")), remedy=error.remedy) from None
    return DeflectionNoise(np.arange(6), 2.0 * covariance, shared_reference)


def tolerance_axes(target: TargetSection, robot: Robot, document: YamlDocument, index: int) -> FloatArray:
    """S of a target: rotations about the body's own axes where `tolerance_axes` is `body` (theory.md 9.C), (n, n).

    Raises:
        InputError: the robot's pose has no angles.
    """
    n, split = robot.coordinates.n, robot.coordinates.translations
    if target.tolerance_axes == "pose":
        return np.eye(n)
    where = document.where(("targets", index, "tolerance_axes"))
    if n == split or len(robot.configuration) != n or len(target.pose) != n:
        raise InputError("axes of the body need a pose with angles", where=where, remedy="Take the key out.")
    return body_axes(robot, np.array(target.pose, dtype=float))


def with_reference_pose(
    noise: DeflectionNoise, experiment: ExperimentSection, robot: Robot, document: YamlDocument
) -> DeflectionNoise:
    """The noise with the price of `experiment.reference_pose`, where there is one.

    Raises:
        InputError: the reference pose cannot be used.
    """
    section = experiment.reference_pose
    if section is None:
        return noise
    where: KeyPath = (*_EXPERIMENT, "reference_pose")
    if experiment.calibration != "elastostatic":
        what = "reference poses are for deflections, where the first reference cancels"
        raise InputError(what, where=document.where(where), remedy="Take the key out.")
    if len(robot.configuration) != robot.coordinates.n or len(section.pose) != robot.coordinates.n:
        what = f"a pose of {robot.coordinates.n} numbers is needed here, for a robot on legs"
        raise InputError(what, where=document.where((*where, "pose")), remedy="Correct it.")
    if section.interpolate and noise.shared_reference:
        what = "references cannot be interpolated where loads share one unloaded measurement"
        raise InputError(what, where=document.where((*where, "interpolate")), remedy="Take one of the two out.")
    pose = np.array(section.pose)
    if not bool(robot.usable(pose)):
        what = "the reference pose is beyond the robot's limits, or nearly singular"
        raise InputError(what, where=document.where((*where, "pose")), remedy="Choose another pose.")
    try:
        return ReferencedNoise(noise, pose, robot.jacobians(pose).pose, interpolated=section.interpolate)
    except InputError as error:
        raise InputError(error.what, where=document.where(where), remedy=error.remedy) from None

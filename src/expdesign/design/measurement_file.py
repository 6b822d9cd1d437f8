"""The parts of a run configuration that say how poses are measured, and along which axes accuracy is wanted."""

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.design.body_axes import body_axes
from expdesign.design.schema import ExperimentSection, PointsSection, TargetSection
from expdesign.errors import InputError
from expdesign.files.yaml_reader import KeyPath, YamlDocument
from expdesign.instrument.deflection_noise import DeflectionNoise
from expdesign.instrument.reference_pose import ReferencedNoise
from expdesign.instrument.registration import pose_covariance
from expdesign.robots.robot import Robot

_EXPERIMENT: KeyPath = ("experiment",)


def noise_of_points(
    section: PointsSection, robot: Robot, document: YamlDocument, *, shared_reference: bool
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
    jacobians = robot.jacobians(pose)
    rates = jacobians.pose @ np.linalg.inv(jacobians.forward)
    try:
        covariance = pose_covariance(np.array(section.positions), section.std_m, jacobians.rotation, rates)
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

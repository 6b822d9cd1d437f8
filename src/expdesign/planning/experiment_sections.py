"""Read the sections of a run configuration that say what is calibrated and how poses are measured (`experiment`), and
along which axes accuracy is wanted (`tolerance_axes` of a target); `problem_file.py` reads the whole configuration.
"""

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.readings.registration import pose_covariance
from expdesign.coordinates import Coordinates
from expdesign.errors import InputError
from expdesign.io.nearest import nearest
from expdesign.io.schema import LARGEST
from expdesign.io.yaml_reader import YamlDocument
from expdesign.mechanics.elastostatics.arm_calibration import regressor_for
from expdesign.mechanics.elastostatics.calibration import Regressor
from expdesign.mechanics.robots.robot import Robot
from expdesign.planning.criteria.targets import body_axes
from expdesign.planning.deflection_noise import DeflectionNoise, ReferencedNoise
from expdesign.planning.schema import (
    DeflectionNoiseSection,
    ExperimentSection,
    LoadSection,
    MeasuredPointsSection,
    RunSection,
    TargetSection,
)
from expdesign.planning.tips import pose_of


def read_noise(section: DeflectionNoiseSection, robot: Robot, *, referenced: bool = True) -> DeflectionNoise:
    """The noise of `experiment.deflection_noise`; poses are measured, and not differences, unless `referenced`.

    Raises:
        InputError: an axis is unknown, or the covariance is none.
    """
    coordinates = robot.coordinates
    if section.std is not None:
        axes = [axis_of(name, coordinates, section.where("std")) for name in section.std]
        if not axes:
            raise section.where("std").fault("no axis is measured", "Name at least one.")
        order = np.argsort(axes)
        deviations = np.array(list(section.std.values()))[order]
        return DeflectionNoise.from_deviations(np.array(axes)[order], deviations, section.shared_reference)
    if section.points is not None:
        covariance = _covariance_of_points(section.points, robot)
        return DeflectionNoise(np.arange(6), (1.0 + referenced) * covariance, section.shared_reference)
    rows = section.covariance or []
    place = section.where("covariance")
    if len(rows) != coordinates.n or any(len(row) != coordinates.n for row in rows):
        what = f"a matrix of {coordinates.n}×{coordinates.n} is needed here"
        raise place.fault(what, f"Order: {', '.join(coordinates.deflection)}.")
    matrix = np.array(rows)
    if np.any(np.diag(matrix) <= LARGEST**-2):
        raise place.fault("a variance is not positive (or below any that is)", "Correct the diagonal.")
    scale = np.sqrt(np.diag(matrix))
    if np.abs((matrix - matrix.T) / np.outer(scale, scale)).max() > 1e-6:
        raise place.fault("the matrix is not symmetric", "Correct it.")
    try:
        return DeflectionNoise(np.arange(coordinates.n), (matrix + matrix.T) / 2.0, section.shared_reference)
    except InputError as error:
        raise place.fault(error.what, error.remedy) from None


def axis_of(name: str, coordinates: Coordinates, place: YamlDocument) -> int:
    """Index of a pose coordinate by the name of its deflection; an `InputError` where there is none."""
    if name not in coordinates.deflection:
        raise place.where(name).fault("unknown axis", nearest(name, coordinates.deflection))
    return coordinates.deflection.index(name)


def _covariance_of_points(section: MeasuredPointsSection, robot: Robot) -> FloatArray:
    """Covariance (6, 6) of one pose that is registered from points (theory.md 9.A); that of a deflection is twice it.

    It is that at `section.pose` (the zero pose, or an arm's reference, where it is left out), for all measurements.

    Raises:
        InputError: the robot has no orientation, or the points do not determine one.
    """
    if robot.coordinates.n != 6 or not (robot.jointed or len(robot.configuration) == 6):
        raise section.where().fault("points are for robots with six pose coordinates", "Give `std` or `covariance`.")
    pose = robot.reference_configuration()
    if section.pose is not None:
        given = pose_of(section.pose, robot, section.where("pose"))
        pose[: len(given)] = given
    rotation, rates = robot.jacobians(pose).rotation, robot.pose_rates(pose)
    try:
        return pose_covariance(np.array(section.positions), section.std_m, rotation, rates)
    except InputError as error:
        raise section.where("positions").fault(error.what, error.remedy) from None


def tolerance_axes(target: TargetSection, robot: Robot) -> FloatArray:
    """S of a target: rotations about the body's own axes where `tolerance_axes` is `body` (theory.md 9.C), (n, n).

    Raises:
        InputError: the robot's pose has no angles.
    """
    n, split = robot.coordinates.n, robot.coordinates.translations
    if target.tolerance_axes == "pose":
        return np.eye(n)
    if n == split or len(robot.configuration) != n or len(target.pose) != n:
        raise target.where("tolerance_axes").fault("axes of the body need a pose with angles", "Take the key out.")
    return body_axes(robot, np.array(target.pose, dtype=float))


def with_reference_pose(noise: DeflectionNoise, experiment: ExperimentSection, robot: Robot) -> DeflectionNoise:
    """The noise with the price of `experiment.reference_pose`, where there is one.

    Raises:
        InputError: the reference pose cannot be used.
    """
    section = experiment.reference_pose
    if section is None:
        return noise
    if experiment.calibration != "elastostatic":
        what = "reference poses are for deflections, where the first reference cancels"
        raise section.where().fault(what, "Take the key out.")
    if len(robot.configuration) != robot.coordinates.n or len(section.pose) != robot.coordinates.n:
        what = f"a pose of {robot.coordinates.n} numbers is needed here, for a robot on legs"
        raise section.where("pose").fault(what, "Correct it.")
    if section.interpolate and noise.shared_reference:
        what = "references cannot be interpolated where loads share one unloaded measurement"
        raise section.where("interpolate").fault(what, "Take one of the two out.")
    if len(noise.axes) != robot.coordinates.n:
        what = "a reference pose corrects only what is measured on all axes"
        raise section.where().fault(what, "Give the noise of every axis, or leave the reference pose out.")
    pose = np.array(section.pose)
    if not bool(robot.usable(pose)):
        what = "the reference pose is beyond the robot's limits, or nearly singular"
        raise section.where("pose").fault(what, "Choose another pose.")
    return ReferencedNoise(noise, pose, robot.jacobians(pose).pose, interpolated=section.interpolate)


def read_regressor(section: RunSection, robot: Robot) -> Regressor:
    """The regressor of `experiment.calibration` and `experiment.frames`.

    Raises:
        InputError: the robot has no such calibration, or loads and frames do not go with it.
    """
    experiment = section.experiment
    regressor = regressor_for(experiment.calibration, frames_known=experiment.frames == "known", links=robot.jointed)
    lack = regressor.require(robot)
    if lack is not None:
        what = f"{lack}, and `{robot.name}` is a {robot.kind}"
        raise experiment.where("calibration").fault(what, "Use `elastostatic`.")
    if regressor.referenced and experiment.frames == "unknown":
        what = "deflections are differences, in which unknown frames cancel"
        raise experiment.where("frames").fault(what, "Take the key out.")
    if not regressor.referenced and experiment.deflection_noise.shared_reference:
        what = "geometric calibration measures poses, which have no unloaded reference to share"
        raise experiment.deflection_noise.where("shared_reference").fault(what, "Take the key out.")
    _require_loads(section, regressor)
    return regressor


def _require_loads(section: RunSection, regressor: Regressor) -> None:
    experiment = section.experiment
    if regressor.needs_load:
        if experiment.load is None:
            raise experiment.where("load").fault("the key is missing", "Add it.")
        for target in section.targets:
            if target.payload is None and target.wrench is None:
                raise target.where().fault("exactly one of `payload` and `wrench` is needed", "Add one.")
        return
    remedy = "Take it out, or use `calibration: both`."
    for key in ("load", "load_error", "geometric_stiffness"):
        if getattr(experiment, key):
            raise experiment.where(key).fault("geometric calibration measures poses without load", remedy)
    for target in section.targets:
        for key in ("payload", "wrench"):
            if getattr(target, key) is not None:
                what = "geometric calibration knows nothing of what a load does at a target"
                raise target.where(key).fault(what, remedy)


def load_section(experiment: ExperimentSection) -> LoadSection:
    """`experiment.load`, or a wrench that is zero where measurements have no load."""
    return experiment.load or LoadSection(kind="wrench")

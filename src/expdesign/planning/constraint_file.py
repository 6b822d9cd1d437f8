"""`experiment.constraints` of a run configuration, read."""

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.errors import InputError
from expdesign.io.yaml_reader import KeyPath, YamlDocument
from expdesign.mechanics.loads.load import Load
from expdesign.mechanics.robots.robot import Robot
from expdesign.planning.collisions import Collisions, Primitive, require_library
from expdesign.planning.constraints import Constraints
from expdesign.planning.schema import ConstraintsSection, ExperimentSection, PrimitiveSection
from expdesign.planning.space import DesignSpace, Required

_WHERE: KeyPath = ("experiment", "constraints")


def read_constraints(
    experiment: ExperimentSection, robot: Robot, load: Load, document: YamlDocument
) -> Constraints | None:
    """The constraints, or None where there are none.

    Raises:
        InputError: they contradict each other, the robot or the number of measurements.
    """
    section = experiment.constraints
    if section is None:
        return None
    most = experiment.measurements or 1  # `read_budget` has refused where there is none
    for name in ("distinct_poses", "distinct_masses"):
        if getattr(section, name) > most:
            what = f"{getattr(section, name)} are more than the {most} measurements"
            raise InputError(what, where=document.where((*_WHERE, name)), remedy="Take fewer, or measure more.")
    if (section.distinct_masses > 1 or section.masses_kg) and not load.has_mass:
        remedy = "Take it out, or use `load: {kind: payload}`."
        raise InputError("a wrench has no mass", where=document.where((*_WHERE, "masses_kg")), remedy=remedy)
    dimension = len(robot.gravity)
    boxes = np.zeros((len(section.keep_out), 2, dimension))
    for index, box in enumerate(section.keep_out):
        where = document.where((*_WHERE, "keep_out", index))
        if len(box.low_m) != dimension or len(box.high_m) != dimension:
            raise InputError(f"{dimension} coordinates are needed for each corner", where=where, remedy="In m, in O.")
        boxes[index] = box.low_m, box.high_m
        if (boxes[index, 0] >= boxes[index, 1]).any():
            raise InputError("the corners are the wrong way round", where=where, remedy="low_m is the lower one.")
    effort = robot.effort if section.effort else None
    if section.effort and (effort is None or not np.isfinite(effort).any()):
        where = document.where((*_WHERE, "effort"))
        remedy = "Add `effort=` to the <limit> of its joints, or take the key out."
        raise InputError("the robot states no effort of its actuators", where=where, remedy=remedy)
    collisions = _collisions(section, robot, document)
    return Constraints(boxes, effort, section.distinct_poses, section.distinct_masses, collisions)


def _collisions(section: ConstraintsSection, robot: Robot, document: YamlDocument) -> Collisions | None:
    stated = section.collisions
    if stated is None:
        return None
    where = document.where((*_WHERE, "collisions"))
    if len(robot.gravity) != 3 or robot.drawing(np.zeros((1, len(robot.configuration)))) is None:
        what = f"collisions of a {robot.kind} are not known, which has no legs or links in space"
        raise InputError(what, where=where, remedy="Take the key out; `keep_out` boxes may do.")
    require_library(where)
    parts = {name: _primitive(getattr(stated, name)) for name in ("payload", "platform", "base")}
    return Collisions(stated.clearance_m, stated.leg_radius_m, **parts)


def _primitive(section: PrimitiveSection | None) -> Primitive | None:
    if section is None:
        return None
    sizes = section.box_m or section.cylinder_m or [section.sphere_m or 0.0]
    return Primitive(tuple(sizes), np.array(section.at_m))


def required(section: ConstraintsSection | None, space: DesignSpace, robot: Robot, document: YamlDocument) -> Required:
    """Poses and masses that have to occur, as decisions.

    Raises:
        InputError: one of them cannot be chosen.
    """
    if section is None:
        return Required()
    m = space.measurements
    for name, count in (("poses", len(section.poses)), ("masses_kg", len(section.masses_kg))):
        if count > m:
            what = f"{count} are more than the {m} measurements"
            raise InputError(what, where=document.where((*_WHERE, name)), remedy="Name fewer, or measure more.")
    poses = []
    for index, pose in enumerate(section.poses):
        where = document.where((*_WHERE, "poses", index))
        if len(pose) != space.n_pose:
            raise InputError(f"{space.n_pose} numbers are needed here", where=where, remedy="Like `targets[].pose`.")
        if not bool(robot.usable(np.array(pose))):
            raise InputError("the pose is beyond the limits, or singular", where=where, remedy="Choose another pose.")
        poses.append(_decisions(space, np.array(pose), 0, where))
    masses = []
    for index, mass in enumerate(section.masses_kg):
        where = document.where((*_WHERE, "masses_kg", index))
        masses.append(_decisions(space, np.array([mass]), space.n_pose, where))
    return Required(tuple(poses), tuple(masses))


def _decisions(space: DesignSpace, wanted: FloatArray, first: int, where: str) -> FloatArray:
    """Genes (g,) at which the quantities from `first` on are as wanted; NaN for decisions that others depend on."""
    found = space.decisions_of(wanted, first)
    if found is None:
        remedy = "Only what `experiment.poses` and `experiment.load` allow can occur."
        raise InputError("this cannot be chosen", where=where, remedy=remedy)
    return found

"""Read a design problem from a run configuration."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.recordings.columns import COLUMNS
from expdesign.chain.recordings.joint_columns import with_joint_columns
from expdesign.errors import InputError
from expdesign.estimation.compensation.target_loads import TargetLoads
from expdesign.estimation.coverage import STANDARD
from expdesign.io.kinds import require_kind
from expdesign.io.nearest import nearest
from expdesign.io.schema import Section, validate
from expdesign.io.table import read_table
from expdesign.io.yaml_reader import YamlDocument, read_yaml
from expdesign.mechanics.elastostatics.measurements import LoadedRobot
from expdesign.mechanics.loads.errors.source import LoadErrorSource
from expdesign.mechanics.loads.load import Load, Payload, Wrench
from expdesign.mechanics.robots.kinematic_tree import TIP_COLUMN
from expdesign.mechanics.robots.robot import Robot
from expdesign.planning.budget import Budget, read_budget
from expdesign.planning.constraints import read_constraints, required
from expdesign.planning.criteria.criterion import Criterion, criteria_of_problem, kinds
from expdesign.planning.criteria.targets import Targets
from expdesign.planning.experiment_sections import (
    axis_of,
    load_section,
    read_noise,
    read_regressor,
    tolerance_axes,
    with_reference_pose,
)
from expdesign.planning.found_robot import FoundRobot, robot_of, with_geometric_stiffness
from expdesign.planning.pose_settings import LEFT_OUT
from expdesign.planning.problem import DesignProblem
from expdesign.planning.schema import ExperimentSection, LoadSection, PosesSection, RunSection
from expdesign.planning.space import DesignSpace, Poses
from expdesign.planning.tips import asked_tips, at_tips, pose_columns, pose_of, tip_number
from expdesign.planning.variables import Choices, Interval, Quantity, fixed, steps_of
from expdesign.plugins import implementations


def read_problem(path: Path) -> DesignProblem:
    """The design problem of a run configuration.

    Raises:
        InputError: a file is missing or wrong.
        SingularConfigurationError: the robot is singular at a target.
    """
    return problem_from_document(read_yaml(path))


def problem_from_document(document: YamlDocument) -> DesignProblem:
    """The design problem that a YAML document describes; see `read_problem`."""
    require_kind(document, "run configuration")
    section = validate(RunSection, document)
    robot, written, found = _robot(section)
    if not robot.actuated:
        what = f"a {robot.kind} has no actuators whose stiffness a plan could identify"
        raise section.where("robot").fault(what, "`expdesign diagnose` finds from recordings what it stands on.")
    experiment = section.experiment
    regressor = read_regressor(section, robot)
    load = _load(load_section(experiment), robot)
    budget = read_budget(experiment, regressor.referenced)
    if budget is not None:  # the search chooses how many of them are taken
        experiment = experiment.with_values(measurements=budget.largest)
    poses = _poses(experiment.poses, robot)
    sources = _sources(experiment, load)
    if found is not None and found.physics is not None and experiment.calibration != "elastostatic":
        what = "a model with effects is planned for elastostatic calibration only"
        raise experiment.where("calibration").fault(what, "Take the key out, or name the robot file.")
    if experiment.geometric_stiffness:
        found = with_geometric_stiffness(robot, found, document.source)
    loaded = LoadedRobot(robot, load, sources, regressor, None if found is None else found.physics)
    noise = read_noise(experiment.deflection_noise, robot, referenced=regressor.referenced)
    targets, wrenches, target_loads, own_loads = _targets(section, loaded)
    space = _space(experiment, robot, load, poses, budget)
    problem = DesignProblem(
        loaded=loaded,
        noise=with_reference_pose(noise, experiment, robot),
        targets=targets,
        target_wrenches=wrenches,
        target_loads=target_loads,
        own_loads=own_loads,
        space=space,
        objectives=(),
        optimiser=section.optimiser,
        config=_resolved(section, written, poses),
        source=document.source,
        found=found,
        constraints=read_constraints(experiment, robot, load),
        costs=experiment.costs,
        budget=budget,
        estimator=experiment.estimator,
        validation=0 if experiment.validation is None else experiment.validation.measurements,
        coverage=STANDARD if section.acceptance is None else section.acceptance.chosen,
        robot_file=str(document.folder / section.robot) if isinstance(section.robot, str) else "",
    )
    problem = replace(problem, further=criteria_of_problem(problem, section))
    return replace(problem, objectives=_objectives(section, problem.criteria))


def resolved_config(document: YamlDocument, robot: Robot) -> dict[str, Any]:
    """The configuration of a document with defaults filled in and files written out, as in `DesignProblem.config`.

    It costs far less than the problem, whose deeper contradictions it does not find.

    Args:
        document: a run configuration that holds the robot's mapping itself.
        robot: what that mapping describes.

    Raises:
        InputError: a key or a value is wrong, or a file of candidates is.
    """
    section = validate(RunSection, document)
    return _resolved(section, document.content["robot"], _poses(section.experiment.poses, robot))


def _resolved(section: RunSection, robot: Any, poses: Poses) -> dict[str, Any]:
    config = section.model_dump(mode="json", exclude_none=True)
    config["robot"] = robot
    if isinstance(poses, np.ndarray):
        config["experiment"]["poses"]["candidates"] = poses.tolist()
    return config


def _robot(section: RunSection) -> tuple[Robot, Any, FoundRobot | None]:
    """The robot, the content of its file, and what it was found to be where that is a model file."""
    part = section.where("robot").written_out
    robot, found = robot_of(part)
    return robot, part.content, found


def _load(section: LoadSection, robot: Robot) -> Load:
    coordinates = robot.coordinates
    load: Load = {kind.kind: kind for kind in (Payload, Wrench)}[section.kind](coordinates)
    own = set(load.keys)
    for name in section.model_fields_set - own - {"kind"}:
        what = f"`{name}` has no meaning for a {section.kind} on a {robot.kind}"
        raise section.where(name).fault(what, nearest(name, sorted(own)))
    if load.has_mass:
        if section.mass_kg is None:
            raise section.where("mass_kg").fault("the key is missing", "Add it (kg).")
        mass = section.mass_kg
        if min(mass.values if isinstance(mass, Choices) else (mass.low,)) < 0.0:
            raise section.where("mass_kg").fault("a mass cannot be negative", "Correct it.")
        tilt = section.gravity
        for name in tilt.model_fields_set - set(coordinates.tilt) if tilt else ():
            remedy = f"Known here: {', '.join(f'`{k}`' for k in coordinates.tilt)}."
            raise section.where("gravity", name).fault("unknown key", remedy)
    return load


def _sources(experiment: ExperimentSection, load: Load) -> tuple[LoadErrorSource, ...]:
    known = {cls.source: cls for cls in implementations("expdesign.mechanics.loads.errors", LoadErrorSource)}  # type: ignore[type-abstract]
    sources = []
    for entry in experiment.load_error:
        if entry.source not in known:
            remedy = nearest(entry.source, sorted(known))
            raise entry.where("source").fault(f"unknown source of load error `{entry.source}`", remedy)
        kind = known[entry.source]
        size = kind.dimension(load)
        if size == 0:
            what = f"a {load.kind} of this robot has no `{entry.source}` error"
            raise entry.where("source").fault(what, "Use another source.")
        deviation = np.atleast_1d(np.array(entry.std, dtype=float))
        if deviation.size != size:
            what = f"{size} standard deviation{'s are' if size > 1 else ' is'} needed here, not {deviation.size}"
            raise entry.where("std").fault(what, f"In {kind.unit}.")
        sources.append(kind(deviation, entry.shared))
    return tuple(sources)


def _targets(
    section: RunSection, loaded: LoadedRobot
) -> tuple[Targets, FloatArray, tuple[tuple[LoadedRobot, FloatArray], ...], TargetLoads | None]:
    """The targets, the wrenches there (t, n), the robot under each one's kind of load with the load's parameters, and
    how well their payloads are known: None where wrenches act at some.
    """
    robot, coordinates = loaded.robot, loaded.robot.coordinates
    poses, observations, wrenches, loads = [], [], [], []
    importance = np.zeros((len(section.targets), coordinates.n))
    axes = np.array([tolerance_axes(target, robot) for target in section.targets])
    own = TargetLoads.exact(len(section.targets), coordinates)
    kinds: dict[type[Load], LoadedRobot] = {}  # one object for each kind: its expressions are built once
    for index, target in enumerate(section.targets):
        joints = pose_of(target.pose, robot, target.where("pose"))
        pose = np.concatenate([joints, tip_number(target.tip, robot, target.where("tip"))])
        stated = _vector(target, "gravity_m_s2", coordinates.gravity)
        gravity = robot.gravity if target.gravity_m_s2 is None else stated
        load: Load
        if target.payload is not None:
            load = Payload(coordinates)
            centre = _vector(target.payload, "com_m", coordinates.centre_of_mass)
            parameters = np.array([target.payload.mass_kg, *centre, *gravity])
            own.carries[index] = target.payload.same_as is not None
            if target.payload.std is not None:
                stated = _vector(target.payload.std, "com_m", coordinates.centre_of_mass)
                own.deviations[index] = target.payload.std.mass_kg or 0.0, *stated
        else:
            load = Wrench(coordinates)
            parameters = _vector(target, "wrench", coordinates.wrench)
        require_usable(robot, pose, str(target.where("pose")))
        if type(load) not in kinds:
            kinds[type(load)] = loaded.under(load, instrument=False)
        here = kinds[type(load)]
        observations.append(axes[index] @ here.measure(pose, parameters).observation)
        wrenches.append(here.load.wrenches(robot.jacobians(pose).rotation, parameters))
        poses.append(pose)
        loads.append((here, parameters))
        for name, tolerance in target.tolerance.items():
            importance[index, axis_of(name, coordinates, target.where("tolerance"))] = 1.0 / tolerance**2
    if loaded.regressor.referenced and not np.any(wrenches):
        what = "no target carries a load, so that there is nothing to compensate"
        raise section.where("targets").fault(what, "Name a payload (under gravity) or a wrench.")
    payloads = all(target.payload is not None for target in section.targets)
    if not payloads and (own.carries.any() or own.deviations.any()):
        what = "a target states how well its payload is known, or whose weights it carries, and another has a wrench"
        raise section.where("targets").fault(what, "Give every target a payload, or leave out `std` and `same_as`.")
    weights = np.array([target.weight for target in section.targets])
    arrays = (np.array(poses), np.array(observations), importance, weights)
    body = any(target.tolerance_axes == "body" for target in section.targets)
    targets = Targets(*arrays, coordinates.translations, section.aggregate, axes if body else None)
    return targets, np.array(wrenches), tuple(loads), own if payloads else None


def _vector(section: Section, key: str, names: tuple[str, ...]) -> FloatArray:
    """The numbers at a key, one of each name; 0 where it is left out."""
    values = getattr(section, key)
    if values is None:
        return np.zeros(len(names))
    if len(values) != len(names):
        what = f"{len(names)} numbers are needed here, not {len(values)}"
        raise section.where(key).fault(what, f"Order: {', '.join(names)}." if names else "")
    return np.array(values, dtype=float)


def require_usable(robot: Robot, configuration: FloatArray, where: str) -> None:
    """Raise where a single configuration (n_q,) is beyond the robot's limits or nearly singular.

    Raises:
        InputError: it is beyond the limits.
        SingularConfigurationError: its scaled condition number is too large.
    """
    if float(robot.limit_excess(configuration)) > 1e-12:
        what = f"the pose is beyond the robot's limits: {robot.limit_message(configuration)}"
        raise InputError(what, where=where, remedy="Choose a pose within them, or correct `limits` in the robot file.")
    require_regular(robot, configuration, where)


def require_regular(robot: Robot, configuration: FloatArray, where: str) -> None:
    """Raise a `SingularConfigurationError` where the robot is nearly singular at a configuration (n_q,)."""
    remedy = "Choose another pose, or correct the joints in the robot file."
    robot.jacobians(configuration).require_regular(lambda _: where, remedy)


def _space(
    experiment: ExperimentSection,
    robot: Robot,
    load: Load,
    poses: Poses,
    budget: Budget | None,
) -> DesignSpace:
    section = load_section(experiment)
    names, given = load.own, section.gravity
    quantities = tuple(getattr(section, name) or fixed(0.0) for name in names)
    tilt: tuple[Quantity, ...] = tuple((getattr(given, name) if given else None) or fixed(0.0) for name in load.tilt)
    gravity = robot.gravity if load.has_mass else None
    candidates = (fixed(0.0),) * len(robot.configuration)
    every = (*(candidates if isinstance(poses, np.ndarray) else poses), *quantities, *tilt)
    known = (*robot.configuration, *names, *load.tilt)
    stated = experiment.resolution or {}
    for name in stated:
        if name not in known:
            raise experiment.where("resolution", name).fault("unknown quantity", nearest(name, known))
    widths = np.array([q.high - q.low if isinstance(q, Interval) else 0.0 for q in every])
    steps = steps_of(known, widths, stated)
    measurements = experiment.measurements or 1  # `read_budget` has refused where there is none
    shared = experiment.deflection_noise.shared_reference and measurements > 1
    settings = (0 if budget is None else LEFT_OUT, measurements - 1 if shared else 0)
    chosen = settings if shared or budget is not None else None
    space = DesignSpace(measurements, poses, quantities, tilt, robot.coordinates, gravity, steps, chosen)
    for decision in np.flatnonzero(space.grid.empty):
        name = known[space.variables[decision].columns[0]]
        what = f"no multiple of {stated[name]:g} lies between {space.lower[decision]:g} and {space.upper[decision]:g}"
        raise experiment.where("resolution", name).fault(what, "Use a finer step, or fix the quantity.")
    space.required = required(experiment.constraints, space, robot)
    if space.settings is not None:
        kept = (*space.required.poses, *space.required.masses)
        space.settings = replace(space.settings, budget=budget, kept=kept)
    return space


def _poses(section: PosesSection, robot: Robot) -> Poses:
    names, place = pose_columns(robot), section.where("candidates")
    tips = asked_tips(section.tips, robot, section.where("tips"))
    if isinstance(section.candidates, list):
        rows = [pose_of(row, robot, place.where(index)) for index, row in enumerate(section.candidates)]
        if not rows:
            raise place.fault("there is no candidate", "Name at least one pose, or a file (CSV).")
        return at_tips(_distinct(np.array(rows)), tips)
    if section.candidates is not None:
        table = read_table(place.file, COLUMNS)
        if tips is not None and table.has(TIP_COLUMN):
            return _distinct(with_joint_columns(table, robot).numbers(robot.configuration))
        return at_tips(_distinct(table.numbers(names)), tips)
    form = "bounds" if section.bounds is not None else "grid"
    axes: dict[str, Quantity] = section.bounds or section.grid or {}
    for name in axes:
        if name not in names:
            remedy = "Name tips under `tips`." if name == TIP_COLUMN and tips else nearest(name, names)
            raise section.where(form, name).fault("unknown coordinate", remedy)
    chosen = tuple(axes.get(name) or fixed(0.0) for name in names)
    return chosen if tips is None else (*chosen, tips)


def _distinct(rows: FloatArray) -> FloatArray:
    """The rows (r, n_q) without repetitions, in their order: measurements at equal poses are to stand together."""
    _, first = np.unique(rows, axis=0, return_index=True)
    return rows[np.sort(first)]


def _objectives(section: RunSection, known: dict[str, Criterion]) -> tuple[Criterion, ...]:
    names, place = section.objectives, section.where("objectives")
    for index, name in enumerate(names):
        if name not in known:
            raise place.where(index).fault(f"unknown criterion `{name}`", nearest(name, [cls.name for cls in kinds()]))
    if len(set(names)) != len(names):
        raise place.fault("a criterion appears twice", "Name each once.")
    if not names:
        raise place.fault("at least one criterion is needed", "E.g. `[duir, feir]`.")
    return tuple(known[name] for name in names)

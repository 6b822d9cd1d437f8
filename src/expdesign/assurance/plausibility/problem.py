"""Run configurations: loads, deflections, noise, ranges and tolerances against each other and against the robot."""

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.assurance.plausibility.finding import Implausibility, extent, largest, outside
from expdesign.assurance.plausibility.robot import gravity_findings, robot_findings
from expdesign.assurance.plausibility.targets import centre_findings, deflection_findings, pose_findings
from expdesign.planning.problem import DesignProblem

_UNITS = {True: ("m", "µm or mm"), False: ("rad", "µrad, mrad or degrees")}
"""Of translations and of rotations, and what they are mistaken for."""


NOISES, ANGULAR_NOISES = (1e-12, 1e-3), (1e-12, 2e-2)
"""m, rad; standard deviations between which instruments are."""
RATIO = 150.0
"""Of loads in the experiment and at the targets beyond which one of them is in another unit."""
UNSEEN, PERFECT = 1.0, 1e7
"""Largest deflection in standard deviations of its reading below and above which one of them is in another unit."""
UNEVEN = 3e4
"""Ratio of that of translations to that of rotations beyond which the noise of one is in another unit."""
COARSE, ANGULAR_COARSE, FINEST = 1e-2, 0.2, 1e-12
"""m, rad, either; tolerances that need no calibration, or that none reaches."""
UNKNOWN_DIRECTION, UNKNOWN_FORCE = 0.3, 10.0
"""rad, and times the force at the targets, that a load error is not."""
SAMPLES = 200
"""Measurements drawn from the design space to be judged."""


def problem_findings(problem: DesignProblem) -> list[Implausibility]:
    """What speaks against a run configuration."""
    space, robot = problem.space, problem.loaded.robot
    corners, drawn = np.stack([space.lower, space.upper]), space.sample(SAMPLES, np.random.default_rng(0))
    found = [
        *robot_findings(robot),
        *pose_findings(robot, space.decode(np.concatenate([corners, drawn]))[0], "experiment.poses"),
        *pose_findings(robot, problem.targets.configurations, "targets"),
        *_noise(problem),
        *_tolerances(problem),
        *_unused(problem),
        *_gravity(problem),
    ]
    if problem.loaded.regressor.referenced:
        poses, loads = space.decode(drawn)
        usable = robot.usable(poses)
        poses, loads = poses[usable], loads[usable]
        found += [*_centres(problem), *_masses(problem, poses, loads), *_deflections(problem, poses, loads)]
        found += _load_errors(problem, loads)
    return found


def _unused(problem: DesignProblem) -> list[Implausibility]:
    """Keys that are read and have no effect."""
    if not problem.config["optimiser"].get("bound_seconds"):
        return []
    what = "the key has no effect: bounds are those of the convex relaxation"
    return [Implausibility(what, "Remove it.", "optimiser.bound_seconds")]


def _gravity(problem: DesignProblem) -> list[Implausibility]:
    """Of targets that state their own."""
    robot, found = problem.loaded.robot, []
    names = robot.coordinates.gravity
    for index, (loaded, parameters) in enumerate(problem.target_loads):
        columns = loaded.load.columns
        gravity = np.array([parameters[columns.index(name)] for name in names if name in columns])
        if len(gravity) and not np.array_equal(gravity, robot.gravity):
            found += gravity_findings(gravity, f"targets.{index}.gravity_m_s2")
    return found[:1]


def _noise(problem: DesignProblem) -> list[Implausibility]:
    robot, noise = problem.loaded.robot, problem.noise
    found = list[Implausibility]()
    for axis, deviation in zip(noise.axes, np.sqrt(np.diag(noise.covariance)).tolist(), strict=True):
        linear = bool(axis < robot.coordinates.translations)
        limits, (unit, others) = NOISES if linear else ANGULAR_NOISES, _UNITS[linear]
        likely = f"Is it in {others}?"
        if deviation < limits[0]:
            likely = f"Is it a variance, or divided by 1e6 twice? In {unit}."
        where = f"experiment.deflection_noise, {robot.coordinates.deflection[axis]}"
        found += outside(deviation, *limits, f"no instrument has a noise of {{:.3g}} {unit}", likely, where)
    return found[:1]


def _tolerances(problem: DesignProblem) -> list[Implausibility]:
    robot, importance = problem.loaded.robot, problem.targets.importance
    found = list[Implausibility]()
    for target, axis in np.argwhere(importance > 0.0):
        tolerance, linear = float(1.0 / np.sqrt(importance[target, axis])), bool(axis < robot.coordinates.translations)
        coarse, (unit, others) = COARSE if linear else ANGULAR_COARSE, _UNITS[linear]
        where = f"targets.{target}.tolerance, {robot.coordinates.deflection[axis]}"
        what = f"a tolerance of {{:.3g}} {unit} needs no calibration"
        found += outside(tolerance, 0.0, coarse, what, f"Is it in {others}?", where)
        what = "a tolerance of {:.3g} is below what can be measured"
        found += outside(tolerance, FINEST, np.inf, what, "Check its unit.", where)
    return found[:1]


def _centres(problem: DesignProblem) -> list[Implausibility]:
    robot = problem.loaded.robot
    if not robot.coordinates.centre_of_mass:
        return []
    loads = problem.space.decode(np.stack([problem.space.lower, problem.space.upper]))[1]
    centres = [(problem.loaded.load.centres(loads), "experiment.load")]
    for index, (loaded, parameters) in enumerate(problem.target_loads):
        centres.append((loaded.load.centres(parameters), f"targets.{index}.payload.com_m"))
    return [finding for places, where in centres for finding in centre_findings(robot, places, where)][:1]


def _masses(problem: DesignProblem, poses: FloatArray, loads: FloatArray) -> list[Implausibility]:
    """Loads of the experiment at poses that can be reached against those of the targets."""
    loaded = problem.loaded
    if not len(poses):
        return []
    split = loaded.robot.coordinates.translations
    wrenches = loaded.load.wrenches(loaded.robot.jacobians(poses).rotation, loads)
    found = list[Implausibility]()
    for part, noun, units in (
        (slice(0, split), "force", "a mass in grams, or a force in kN"),
        (slice(split, None), "moment", "a moment in N·mm, or a centre of mass in millimetres"),
    ):
        here, there = (largest(np.linalg.norm(each[:, part], axis=1)) for each in (wrenches, problem.target_wrenches))
        ratio = here / there if here > 0.0 and there > 0.0 else 1.0
        what = f"the largest {noun} is {here:.3g} in the experiment and {there:.3g} at the targets"
        found += outside(ratio, 1.0 / RATIO, RATIO, what, f"Is one of them {units}?", "experiment.load")
    return [*found[:1], *_carried(problem)]


def _carried(problem: DesignProblem) -> list[Implausibility]:
    """Targets that carry the weights of the experiment and are heavier than all of them together ever are."""
    own, load = problem.own_loads, problem.loaded.load
    if own is None or not load.has_mass:
        return []
    heaviest = float(problem.space.ranges[1][problem.space.n_pose])
    for index in np.flatnonzero(own.carries):
        mass = float(problem.target_loads[index][1][0])
        if mass > heaviest * (1.0 + 1e-6):
            what = (
                f"the target carries the weights of the experiment, {mass:.4g} kg, which are {heaviest:.4g} kg at most"
            )
            likely = "Is it a payload of its own? Then leave `same_as` out."
            return [Implausibility(what, likely, f"targets.{index}.payload.same_as")]
    return []


def _deflections(problem: DesignProblem, poses: FloatArray, loads: FloatArray) -> list[Implausibility]:
    loaded, robot = problem.loaded, problem.loaded.robot
    at_targets = problem.targets.observation @ robot.compliance
    in_plan = np.zeros((0, robot.coordinates.n))
    if len(poses):
        in_plan = loaded.measure(poses, loads).observation @ robot.compliance
    found = [*deflection_findings(robot, at_targets, "targets")]
    found += deflection_findings(robot, in_plan, "experiment.load")
    return found[:1] or _seen(problem, in_plan)


def _seen(problem: DesignProblem, in_plan: FloatArray) -> list[Implausibility]:
    """Deflections in the plan against the noise: translations and rotations apart."""
    if not len(in_plan):
        return []
    noise, split = problem.noise, problem.loaded.robot.coordinates.translations
    deviations = np.sqrt(np.diag(noise.covariance))
    ratio = np.abs(in_plan[:, noise.axes]) / deviations
    linear = noise.axes < split
    best, where = (
        [float(ratio[:, kind].max()) for kind in (linear, ~linear) if kind.any()],
        "experiment.deflection_noise",
    )
    what = "no deflection would be above the noise (the largest is {:.2g} standard deviations)"
    likely = "Is the noise in µm or mm, a mass in tonnes, a force in kN, or the stiffness in another unit?"
    found = outside(max(best), UNSEEN, np.inf, what, likely, where)
    what = "the noise would be {:.2g} times smaller than the deflections"
    likely = "Is it in another unit, or a load (a mass in grams) or the stiffness?"
    found += outside(max(best), 0.0, PERFECT, what, likely, where)
    if found or len(best) < 2 or min(best) >= UNSEEN:
        return found
    kinds = ("translations", "rotations") if best[0] < best[1] else ("rotations", "translations")
    what = f"the largest of all {kinds[0]} is {min(best):.2g} standard deviations, of {kinds[1]} {max(best):.2g}"
    likely = f"Is the noise of the {kinds[0]} in another unit?"
    return outside(max(best) / min(best) if min(best) else np.inf, 0.0, UNEVEN, what, likely, where)


def _load_errors(problem: DesignProblem, loads: FloatArray) -> list[Implausibility]:
    """Errors of the load of 0, or as large as the load itself or the robot."""
    robot, load = problem.loaded.robot, problem.loaded.load
    split = robot.coordinates.translations
    forces = largest(problem.target_wrenches[:, :split])
    masses = loads[:, 0] if load.has_mass else np.empty(0)
    lightest = float(masses[masses > 0.0].min(initial=np.inf))
    known = {
        "com": ("a centre of mass", "m", extent(robot), "Is it in millimetres?"),
        "mass": ("a mass", "kg", lightest, "Is it in grams? The lightest load is no heavier."),
        "direction": ("a direction", "rad", UNKNOWN_DIRECTION, "Is it in degrees or mrad?"),
        "wrench": ("a force", "N", UNKNOWN_FORCE * forces, "Is it in mN?"),
    }
    found = list[Implausibility]()
    for index, source in enumerate(problem.loaded.sources):
        where = f"experiment.load_error.{index}"
        what = f"a standard deviation of 0 declares no error of the {source.source}"
        likely = "State how well the load is known, or remove the source."
        found += outside(largest(source.deviation), 1e-300, np.inf, what, likely, where)
        noun, unit, limit, likely = known.get(source.source, ("", "", None, ""))
        of_limit = largest(source.deviation[:split]) if source.source == "wrench" else largest(source.deviation)
        what = f"{noun} with a standard deviation of {largest(source.deviation):.3g} {unit} is as good as unknown"
        found += outside(of_limit, 0.0, limit or np.inf, what, likely, where)
    return found

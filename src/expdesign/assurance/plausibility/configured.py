"""Rows of a plan or of recordings beside their configuration: its loads, poses and bounds."""

import numpy as np

from expdesign.arrays import IntArray
from expdesign.assurance.model_error.physics import plan_points
from expdesign.assurance.plausibility.finding import Implausibility
from expdesign.assurance.plausibility.targets import load_findings, target_findings
from expdesign.chain.models.estimable import Calibrated
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.planning.plan import Plan
from expdesign.planning.problem import DesignProblem

SAMPLES = 200
"""Measurements drawn from the design space, whose corners are added."""
ROUNDING = 1e-5
"""Part of a bound, or of the width between both, by which a file may round a value beyond it."""
_OF_CONFIGURATION = "in the configuration's experiment"
_ROWS = 6
"""Rows that one message names."""


def calibrated_by(problem: DesignProblem) -> Calibrated:
    """The ranges of what a configuration lets be measured."""
    space, robot = problem.space, problem.loaded.robot
    drawn = space.sample(SAMPLES, np.random.default_rng(0))
    rows = space.decode(np.concatenate([drawn, np.stack([space.lower, space.upper])]))
    return Calibrated.of(plan_points(problem.loaded, *rows), robot)


def recorded_findings(points: LoadedPoints, problem: DesignProblem) -> list[Implausibility]:
    """What the loads of a configuration say against those of recordings."""
    return load_findings(points, problem.loaded.robot, calibrated_by(problem), _OF_CONFIGURATION)


def plan_findings(points: LoadedPoints, problem: DesignProblem) -> list[Implausibility]:
    """What a configuration says against the rows of a plan."""
    return target_findings(points, problem.loaded.robot, calibrated_by(problem), _OF_CONFIGURATION)


def bound_findings(plan: Plan, lines: IntArray, problem: DesignProblem) -> list[Implausibility]:
    """Quantities of a plan, whose rows stand on `lines` (m,) of a file, beyond the bounds of the configuration."""
    space, robot, load = problem.space, problem.loaded.robot, problem.loaded.load
    names = (*robot.configuration, *load.own)
    values = np.hstack([plan.configurations, plan.loads[:, : len(load.own)]])
    unloaded = (plan.loads[:, :1] == 0.0) & load.has_mass
    found = []
    for axis, (name, low, high) in enumerate(zip(names, *(bound[: len(names)] for bound in space.ranges), strict=True)):
        allowed = ROUNDING * max(abs(low), abs(high)) + 1e-9
        beyond = np.maximum(low - values[:, axis], values[:, axis] - high)
        if name in robot.coordinates.centre_of_mass:
            beyond = np.where(unloaded[:, 0], 0.0, beyond)
        rows = np.flatnonzero(beyond > allowed)
        if not rows.size:
            continue
        worst = values[int(np.argmax(beyond)), axis]
        bounds = f"{low:.6g}" if low == high else f"{low:.6g} to {high:.6g}"
        named = ", ".join(str(lines[row]) for row in rows[:_ROWS]) + (", …" if len(rows) > _ROWS else "")
        what = f"{name} is {worst:.6g}, beyond the bounds of the configuration ({bounds})"
        where = f"row{'s' * (len(rows) > 1)} {named}"
        found.append(Implausibility(what, "If that is meant, widen the bounds.", where))
    return found

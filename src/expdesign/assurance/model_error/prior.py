"""Prior sizes of left-out physics on one robot, in the units of the effects' parameters."""

from dataclasses import replace

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.assurance.model_error.left_out import Omitted
from expdesign.assurance.model_error.settings import Assumptions
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.sizes import PhysicalSizes
from expdesign.mechanics.elastostatics.maps import actuator_forces
from expdesign.planning.problem import DesignProblem


def prior_deviations(
    problem: DesignProblem, physics: tuple[Omitted, ...], assumptions: Assumptions, errors: FloatArray
) -> FloatArray:
    """σ of every column of `physics`, shape (D,).

    Args:
        problem: whose robot and targets the sizes may be multiples of.
        physics: what is left out.
        assumptions: with sizes in place of the declared ones.
        errors: weighted deflections of the targets per compliance (in units of 1/apK) and per column, shape
            (q, n_p + D).
    """
    sizes = _sizes(problem, errors[:, : len(problem.loaded.robot.stiffness)])
    column = errors.shape[1] - sum(entry.columns for entry in physics)
    deviations = []
    for entry in physics:
        for index in entry.free:
            parameter = entry.effect.parameters[index]
            size = assumptions.size(entry.effect, parameter)
            deviations.append(sizes.of(size, entry.effect, parameter, errors[:, column]))
            column += 1
    return np.array(deviations)


def with_steps(problem: DesignProblem, physics: tuple[Omitted, ...], assumptions: Assumptions) -> tuple[Omitted, ...]:
    """The entries, those with memory and one parameter with the prior size of that parameter as their step."""
    n_p = len(problem.loaded.robot.stiffness)
    sizes = _sizes(problem, np.zeros((1, n_p)))
    stepped = []
    for entry in physics:
        if entry.effect.states and entry.columns == 1:
            parameter = entry.effect.parameters[entry.free[0]]
            size = assumptions.size(entry.effect, parameter)
            step = sizes.of(size, entry.effect, parameter, np.zeros(1))
            entry = replace(entry, step=step)  # noqa: PLW2901
        stepped.append(entry)
    return tuple(stepped)


def usual_size(problem: DesignProblem, effect: Effect, parameter: Parameter) -> float:
    """σ of one parameter of an effect on the robot of a problem."""
    count = len(problem.loaded.robot.stiffness)
    return _sizes(problem, np.zeros((1, count))).of(effect.size(parameter), effect, parameter, np.zeros(1))


def _sizes(problem: DesignProblem, base: FloatArray) -> PhysicalSizes:
    """At the targets."""
    robot, targets = problem.loaded.robot, problem.targets.configurations
    forces = actuator_forces(robot.jacobians(targets), problem.target_wrenches)
    measured = [loaded.measure(pose, load) for pose, (loaded, load) in zip(targets, problem.target_loads, strict=True)]
    return PhysicalSizes(robot, forces, np.mean([np.diag(m.compliance) for m in measured], axis=0), base)

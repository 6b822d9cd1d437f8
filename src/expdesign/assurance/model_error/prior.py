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


class PriorSizes:
    """Prior sizes on the robot of a problem, at its targets.

    Args:
        problem: whose robot and targets the sizes may be multiples of.
        assumptions: with sizes in place of the declared ones.
        springs: weighted deflections of the targets per compliance in units of 1/apK, shape (q, n_p); none where no
            size is a multiple of them.
    """

    def __init__(self, problem: DesignProblem, assumptions: Assumptions, springs: FloatArray | None = None) -> None:
        robot, targets = problem.loaded.robot, problem.targets.configurations
        forces = actuator_forces(robot.jacobians(targets), problem.target_wrenches)
        pairs = zip(targets, problem.target_loads, strict=True)
        measured = [loaded.measure(pose, load) for pose, (loaded, load) in pairs]
        mean = np.mean([np.diag(m.compliance) for m in measured], axis=0)
        self.assumptions = assumptions
        self._springs = np.zeros((1, len(robot.stiffness))) if springs is None else springs
        self._sizes = PhysicalSizes(robot, forces, mean, self._springs)

    def of(self, effect: Effect, parameter: Parameter, moved: FloatArray | None = None) -> float:
        """σ of one parameter, of which one unit moves the weighted deflections by so much, shape (q,)."""
        moved = np.zeros(len(self._springs)) if moved is None else moved
        return self._sizes.of(self.assumptions.size(effect, parameter), effect, parameter, moved)


def prior_deviations(
    problem: DesignProblem, physics: tuple[Omitted, ...], assumptions: Assumptions, errors: FloatArray
) -> FloatArray:
    """σ of every column of `physics`, shape (D,), from weighted deflections per compliance and column (q, n_p + D)."""
    base, moved = np.split(errors, [len(problem.loaded.robot.stiffness)], axis=1)
    sizes = PriorSizes(problem, assumptions, base)
    parameters = [(entry.effect, entry.effect.parameters[index]) for entry in physics for index in entry.free]
    return np.array([sizes.of(*each, column) for each, column in zip(parameters, moved.T, strict=True)])


def with_steps(problem: DesignProblem, physics: tuple[Omitted, ...], assumptions: Assumptions) -> tuple[Omitted, ...]:
    """The entries, those with memory and one parameter with the prior size of that parameter as their step."""
    sizes = PriorSizes(problem, assumptions)
    return tuple(
        replace(entry, step=sizes.of(entry.effect, entry.effect.parameters[entry.free[0]]))
        if entry.effect.states and entry.columns == 1
        else entry
        for entry in physics
    )

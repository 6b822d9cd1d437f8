"""Prior sizes of left-out physics on one robot, in the units of the effects' parameters."""

from dataclasses import replace

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.assurance.model_error.left_out import LeftOut
from expdesign.assurance.model_error.settings import Assumptions
from expdesign.chain.component import Part
from expdesign.chain.declaration import Size
from expdesign.chain.effect import Effect, Parameter
from expdesign.mechanics.elastostatics.maps import actuator_forces
from expdesign.planning.problem import DesignProblem

_REFERENCE = 100.0
"""N or N·m; the force to which parameters of non-linear springs refer."""


def prior_deviations(
    problem: DesignProblem, physics: tuple[LeftOut, ...], assumptions: Assumptions, errors: FloatArray
) -> FloatArray:
    """σ of every column of `physics`, shape (D,).

    Args:
        problem: whose robot and targets the sizes may be multiples of.
        physics: what is left out.
        assumptions: with sizes in place of the declared ones.
        errors: weighted deflections of the targets per compliance (in units of 1/apK) and per column, shape
            (q, n_p + D).
    """
    scale = _Scale(problem, errors[:, : len(problem.loaded.robot.stiffness)])
    column = errors.shape[1] - sum(entry.columns for entry in physics)
    deviations = []
    for entry in physics:
        for index in entry.free:
            parameter = entry.effect.parameters[index]
            size = assumptions.size(entry.effect, parameter)
            deviations.append(size.value * scale.unit(size, entry.effect, parameter.name, errors[:, column]))
            column += 1
    return np.array(deviations)


def with_steps(problem: DesignProblem, physics: tuple[LeftOut, ...], assumptions: Assumptions) -> tuple[LeftOut, ...]:
    """The entries, those with memory and one parameter with the prior size of that parameter as their step."""
    n_p = len(problem.loaded.robot.stiffness)
    scale = _Scale(problem, np.zeros((1, n_p)))
    stepped = []
    for entry in physics:
        if entry.effect.states and entry.columns == 1:
            parameter = entry.effect.parameters[entry.free[0]]
            size = assumptions.size(entry.effect, parameter)
            step = size.value * scale.unit(size, entry.effect, parameter.name, np.zeros(1))
            entry = replace(entry, step=step)  # noqa: PLW2901
        stepped.append(entry)
    return tuple(stepped)


def usual_size(problem: DesignProblem, effect: Effect, parameter: Parameter) -> float:
    """σ of one parameter of an effect on the robot of a problem."""
    size = effect.size(parameter)
    count = len(problem.loaded.robot.stiffness)
    scale = _Scale(problem, np.zeros((1, count)))
    return size.value * scale.unit(size, effect, parameter.name, np.zeros(1))


class _Scale:
    """What sizes are multiples of, on one robot with its targets."""

    def __init__(self, problem: DesignProblem, base: FloatArray) -> None:
        self.robot = problem.loaded.robot
        self.base = base
        targets = problem.targets.configurations
        jacobians = self.robot.jacobians(targets)
        self.force = np.abs(actuator_forces(jacobians, problem.target_wrenches)).max(axis=0)
        measured = [
            loaded.measure(pose, load) for pose, (loaded, load) in zip(targets, problem.target_loads, strict=True)
        ]
        self.pose_compliance = np.mean([np.diag(m.compliance) for m in measured], axis=0)

    def unit(self, size: Size, effect: Effect, parameter: str, error: FloatArray) -> float:
        """What one unit of a size is, in the parameter's unit."""
        if not size.of:
            return 1.0
        if size.of == "pose compliance":
            i, j = (self._axis(name) for name in parameter.split("_")[1:3])
            return float(np.sqrt(self.pose_compliance[i] * self.pose_compliance[j]))
        component = effect.component
        single = component.part in (Part.LEG, Part.JOINT) and component.number > 0
        legs = [component.index] if single else list(range(len(self.robot.stiffness)))
        compliance = float(self.robot.compliance[legs].mean())
        if size.of == "actuator compliance":
            return compliance
        if size.of == "actuator force":
            return float(self.force[legs].max() or self.force.max())
        moved, own = float(np.linalg.norm(error)), float(np.linalg.norm(self.base[:, legs].sum(axis=1)))
        if moved > 0.0 and own > 0.0:
            return own / moved
        # Actuators that carry nothing at the targets: what one yields under the parameter's reference force.
        return compliance * _REFERENCE if parameter.endswith(("_m", "_rad")) else 1.0

    def _axis(self, name: str) -> int:
        names = [column.rsplit("_", 1)[0] for column in self.robot.coordinates.deflection]
        return names.index(name if name in names else f"d{name}")

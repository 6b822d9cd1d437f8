"""What declared sizes of physics are on one robot, at some poses under some loads."""

from collections.abc import Sequence

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import Part
from expdesign.chain.declaration import Size
from expdesign.chain.effect import Effect, Parameter
from expdesign.mechanics.robots.robot import Robot

_REFERENCE = 100.0
"""N or N·m; the force to which parameters of non-linear springs refer."""


class PhysicalSizes:
    """Standard deviations of parameters, in their units.

    Args:
        robot: the robot.
        forces: in its actuators (N, N·m), shape (N, n_p).
        pose_compliance: √ of its squares are sizes of compliances of the platform and the base: the diagonal of D at
            some pose, or its mean over several, shape (n,).
        springs: what springs yield in what is compared, per compliance in units of 1/apK, shape (M, n_p); None where
            no parameter is compared with them.
    """

    def __init__(
        self, robot: Robot, forces: FloatArray, pose_compliance: FloatArray, springs: FloatArray | None = None
    ) -> None:
        self.robot, self.pose_compliance = robot, pose_compliance
        self.springs = np.zeros((0, len(robot.stiffness))) if springs is None else springs
        self.force: FloatArray = np.abs(forces).max(axis=0)

    def of(self, size: Size, effect: Effect, parameter: Parameter, moved: FloatArray | None = None) -> float:
        """σ of a parameter.

        Args:
            size: as it is declared, or as a person states it.
            effect: that has the parameter.
            parameter: of it.
            moved: what one unit of the parameter moves in what is compared, shape (M,); None where it is not known.
        """
        return size.value * self._unit(size, effect, parameter.name, np.zeros(0) if moved is None else moved)

    def _unit(self, size: Size, effect: Effect, parameter: str, moved: FloatArray) -> float:
        """What one unit of a size is, in the parameter's unit."""
        if not size.of:
            return 1.0
        if size.of == "pose compliance":
            i, j = (self._axis(name) for name in parameter.split("_")[1:3])
            return float(np.sqrt(self.pose_compliance[i] * self.pose_compliance[j]))
        legs = self._legs(effect)
        compliance = float(self.robot.compliance[legs].mean())
        if size.of == "actuator compliance":
            return compliance
        if size.of == "actuator force":
            return float(self.force[legs].max() or self.force.max())
        by_it, own = float(np.linalg.norm(moved)), float(np.linalg.norm(self.springs[:, legs].sum(axis=1)))
        if by_it > 0.0 and own > 0.0:
            return own / by_it
        # Actuators that carry nothing: what one yields under the parameter's reference force.
        return compliance * _REFERENCE if parameter.endswith(("_m", "_rad")) else 1.0

    def _legs(self, effect: Effect) -> Sequence[int]:
        component = effect.component
        single = component.part in (Part.LEG, Part.JOINT) and component.number > 0
        return [component.index] if single else list(range(len(self.robot.stiffness)))

    def _axis(self, name: str) -> int:
        names = [column.rsplit("_", 1)[0] for column in self.robot.coordinates.deflection]
        return names.index(name if name in names else f"d{name}")

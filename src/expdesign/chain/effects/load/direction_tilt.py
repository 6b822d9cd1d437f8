"""Gravity, or the load, does not act along the assumed direction (theory.md 5.2, tilt of gravity)."""

import casadi as ca

from expdesign.chain.component import PAYLOAD, Component
from expdesign.chain.declaration import Declaration, Input, Size
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.row import Row
from expdesign.mechanics.loads.load import small_rotation
from expdesign.mechanics.robots.orientation import moment
from expdesign.mechanics.robots.robot import Robot


class LoadDirectionTilt(Effect):
    """The force is turned by small angles about x and y of O: a payload's moment follows from its lever, a free
    wrench turns as a whole.
    """

    physics = "load_direction_tilt"
    declared = Declaration(
        left_out="gravity or load in another direction",
        phrase="a load that is not along its assumed direction",
        usually="machines that were not levelled, slanting cables",
        port="payload",
        inputs=(Input.FORCE,),
        sizes=(Size("tilt_?_rad", 5e-4, "assumed: a machinist's level, 0.5 mm/m"),),
    )

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return [PAYLOAD]

    def describe(self) -> tuple[Parameter, ...]:
        names = ("tilt_x_rad", "tilt_y_rad") if self.robot.coordinates.translations > 2 else ("tilt_z_rad",)
        return tuple(Parameter(name, 1e-3, low=-0.5, high=0.5) for name in names)

    def load(self, wrench: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        split = self.robot.coordinates.translations
        force = wrench[:split]
        turned = small_rotation(force, theta)
        if wrench.shape[0] == split:
            return turned
        turning = wrench[split:]
        as_payload = turning + moment(row.lever, turned - force)
        # About the normal of the plane a moment stays what it is.
        as_wrench = small_rotation(turning, theta) if split == 3 else turning
        return ca.vertcat(turned, row.payload * as_payload + (1.0 - row.payload) * as_wrench)

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        parts = [
            f"{1e3 * v[0]:.2f} ({1e3 * v[1]:.2f} to {1e3 * v[2]:.2f}) mrad ({name[:6]})" for name, v in values.items()
        ]
        return f"The load acts {' and '.join(parts)} away from the assumed direction."

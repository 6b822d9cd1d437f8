"""A leg's or joint's stiffness changes with its force: hardening, softening, Hertz contact, tension unlike compression.

A joint's characteristic counts from zero torque: where on it the joint works, its own links' weight decides.
"""

from collections.abc import Callable
from enum import StrEnum

import casadi as ca

from expdesign.chain.component import Component, actuators_and_all, reference_force, turning
from expdesign.chain.declaration import Declaration, Input, Size
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.row import Row
from expdesign.mechanics.robots.robot import Robot

_REFERENCE = 100.0
"""N or N·m; the parameters refer to this force, so that all forms are of one size."""
_NEWTON_STEPS = 6


class Characteristic(StrEnum):
    """What stands in series with the linear spring, or (cubic) in its place."""

    QUADRATIC = "quadratic"
    SQUARE = "square"
    CUBE = "cube"
    ASYMMETRIC = "asymmetric"
    HERTZ = "hertz"
    CUBIC = "cubic"


_SERIES: dict[Characteristic, Callable[[ca.SX], ca.SX]] = {
    Characteristic.QUADRATIC: lambda f: f * ca.fabs(f),
    Characteristic.SQUARE: lambda f: f**2,
    Characteristic.CUBE: lambda f: f**3,
    Characteristic.ASYMMETRIC: ca.fabs,
    Characteristic.HERTZ: lambda f: ca.sign(f) * ca.exp(2.0 / 3.0 * ca.log(ca.fmax(ca.fabs(f), 1e-9))),
}


class LegNonlinearStiffness(Effect):
    """Something non-linear in series with the spring, or a spring that hardens.

    `quadratic`, `square`, `cube`, `asymmetric` and `hertz`: Δq gains a·g(τ), g being τ·|τ|, τ², τ³, |τ| or
    sign(τ)·|τ|^⅔. `cubic`: the spring obeys τ = k·(x + b·x³), b > 0 hardening. Forces count from zero load, not from
    the reference state.
    """

    physics = "leg_nonlinear_stiffness"
    declared = Declaration(
        left_out="stiffness that depends on the force",
        phrase="a spring that is not linear in {component}",
        usually="preload, rubber and rolling contacts",
        port="actuators",
        inputs=(Input.FORCE,),
        sizes=(
            Size("*", 0.1, "assumed: secant and tangent differ by a tenth at the targets' loads", "own deflection"),
        ),
    )
    forms = tuple(Characteristic)

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return actuators_and_all(robot)

    def describe(self) -> tuple[Parameter, ...]:
        force, motion = ("Nm", "rad") if turning(self.robot, self.actuators) else ("N", "m")
        if self.variant is Characteristic.CUBIC:
            # b in units of the square of the linear elongation at the reference force.
            return (Parameter(f"hardening_at_100{force}", 0.1, low=-0.3, high=1e3),)
        return (Parameter(f"{self.variant}_at_100{force}_{motion}", 1e-6, low=-1e-2, high=1e-2),)

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        before = reference_force(row)
        gained = ca.SX.zeros(elongation.shape[0])
        for leg in self.actuators:
            change = self._beyond(before[leg] + force[leg], theta[0]) - self._beyond(before[leg], theta[0])
            gained[leg] = change * (compliance[leg] * _REFERENCE if self.variant is Characteristic.CUBIC else 1.0)
        return elongation + gained, state

    def _beyond(self, force: ca.SX, parameter: ca.SX) -> ca.SX:
        """Elongation beyond the linear spring's."""
        relative = force / _REFERENCE
        if self.variant is not Characteristic.CUBIC:
            return parameter * _SERIES[self.variant](relative)
        # A softening spring carries no more force than at its summit, 1/√(3·|b|); there the elongation ends.
        summit = 0.95 / ca.sqrt(3.0 * ca.fmax(-parameter, 1e-9))
        x = relative
        for _ in range(_NEWTON_STEPS):
            x = ca.fmin(ca.fmax(x, -summit), summit)
            x = x - (x + parameter * x**3 - relative) / ca.fmax(1.0 + 3.0 * parameter * x**2, 0.05)
        return ca.fmin(ca.fmax(x, -summit), summit) - relative

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        name, (value, _, _) = next(iter(values.items()))
        at = "100 N·m" if "Nm" in name else "100 N"
        if self.variant is Characteristic.CUBIC:
            kind = "hardens" if value > 0.0 else "softens"
            return f"The stiffness of {self.component} {kind} with its force (cubic spring, {value:+.3g} at {at})."
        return (
            f"The stiffness of {self.component} changes with its force ({self.variant}): {1e6 * value:+.2f} "
            f"{'µrad' if name.endswith('rad') else 'µm'} beyond the linear spring at {at}."
        )

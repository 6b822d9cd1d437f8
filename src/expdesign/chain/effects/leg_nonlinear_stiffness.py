"""A leg's stiffness changes with its force: hardening, softening, Hertz contact, tension unlike compression."""

from collections.abc import Callable

import casadi as ca

from expdesign.chain.components import legs_and_all, reference_force
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.row import Row
from expdesign.recordings.recordings import LoadedPoints
from expdesign.robots.robot import Robot

_REFERENCE = 100.0
"""N; the parameters are the extra length change at this force, so that all forms have one unit."""

_FORMS: dict[str, Callable[[ca.SX], ca.SX]] = {
    "quadratic": lambda f: f * ca.fabs(f),
    "cubic": lambda f: f**3,
    "asymmetric": ca.fabs,
    "hertz": lambda f: ca.sign(f) * ca.exp(2.0 / 3.0 * ca.log(ca.fmax(ca.fabs(f), 1e-9))),
}


class LegNonlinearStiffness(Effect):
    """Δq gains a·(g(τ) − g(τ of the reference state)), g one of the forms in units of 100 N."""

    physics = "leg_nonlinear_stiffness"

    @classmethod
    def places(cls, robot: Robot, points: LoadedPoints) -> list[tuple[str, str]]:
        return [(component, form) for component in legs_and_all(robot) for form in _FORMS]

    def describe(self) -> tuple[Parameter, ...]:
        return (Parameter(f"{self.variant}_at_100N_m", 1e-6),)

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        before = reference_force(row)
        form = _FORMS[self.variant]
        gained = ca.SX.zeros(elongation.shape[0])
        for leg in self.legs:
            change = form((before[leg] + force[leg]) / _REFERENCE) - form(before[leg] / _REFERENCE)
            gained[leg] = theta[0] * change
        return elongation + gained, state

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        value = 1e6 * next(iter(values.values()))[0]
        return (
            f"The stiffness of {self.component} changes with its force ({self.variant}): {value:+.2f} µm beyond the "
            "linear spring at 100 N."
        )

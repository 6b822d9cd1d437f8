"""The base, or the instrument's stand, wanders during a campaign: Brownian motion of the frame between them.

Each coordinate of the frame is a Brownian motion from the first row on, as the Karhunen–Loève series

    x(t) = σ·Σ_k z_k·√2·sin((k − ½)·π·t/T)/((k − ½)·π),   z_k ~ N(0, 1),  k = 1 ... K

(Ash and Gardner, Topics in Stochastic Processes, 1975, 1.4), whose K terms hold 1 − 2/(π²·K) of its variance. A
campaign whose rows are all series of their own has six such processes, not six free numbers for every row. Beyond the
recorded time the frame stays where it was.
"""

import re
from dataclasses import dataclass
from typing import Self

import casadi as ca

from expdesign.chain.component import INSTRUMENT, Component
from expdesign.chain.declaration import Beyond, Declaration, Input, Size, Variant, rounded
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.row import Row
from expdesign.mechanics.robots.robot import Robot

TERMS = 8
"""K: 97.5 % of the variance."""
_SHIFT, _TURN = 5e-5, 2e-5
"""m, rad; standard deviation at the end of a campaign beforehand: a stand of 1 m that warms or cools by some K."""
_TEXT = re.compile(r"over ([\d.e+-]+) s")


@dataclass(frozen=True)
class Duration:
    """T (s)."""

    seconds: float

    def __str__(self) -> str:
        return f"over {rounded(self.seconds):g} s"

    @classmethod
    def from_text(cls, text: str) -> Self:
        """Raises `ValueError` for another text."""
        match = _TEXT.fullmatch(text)
        if match is None:
            raise ValueError(f"`{text}` is no duration")
        return cls(float(match.group(1)))


class FrameWander(Effect):
    """The reading y gains x(t) + w(t)×y, three Brownian motions each."""

    physics = "thermal_drift"
    declared = Declaration(
        left_out="wandering of the instrument against the base",
        phrase="a frame that wanders ({component})",
        usually="stands and floors that warm up",
        port="environment",
        form="random walk",
        inputs=(Input.TIME,),
        beyond=Beyond.HOLDS,
        sizes=(
            Size("turn_?_?_rad", _TURN, "assumed: a stand of 1 m that warms by some K on one side"),
            Size("shift_?_?_m", _SHIFT, "assumed: a stand of 1 m that warms by some K"),
        ),
    )
    measurands = ()

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return [INSTRUMENT]

    @classmethod
    def variant_from_text(cls, robot: Robot, text: str) -> Variant:
        return Duration.from_text(text)

    def describe(self) -> tuple[Parameter, ...]:
        kinds = (("shift", "m", _SHIFT), ("turn", "rad", _TURN))
        return tuple(
            Parameter(f"{kind}_{axis}_{term}_{unit}", size, spread=size)
            for kind, unit, size in kinds
            for axis in "xyz"
            for term in range(1, TERMS + 1)
        )

    def reading(self, reading: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        time = ca.fmin(ca.fmax(row.clock, 0.0), self.variant.seconds) / self.variant.seconds
        rates = [(k - 0.5) * ca.pi for k in range(1, TERMS + 1)]
        basis = ca.vertcat(*(ca.sqrt(2.0) * ca.sin(rate * time) / rate for rate in rates))
        moved = ca.reshape(theta, TERMS, 6).T @ basis
        place = reading[:3] + moved[:3] + ca.cross(moved[3:], reading[:3])
        return ca.vertcat(place, reading[3:])

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        largest = max(abs(v[0]) for name, v in values.items() if name.startswith("shift"))
        return f"The instrument wanders against the base {self.variant}, by terms of up to {1e3 * largest:.3g} mm."

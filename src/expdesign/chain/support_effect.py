"""`SupportEffect`, the base class of effects of a support (what a body stands on): drives, whole loads, dependence on
the pose. The effects are in `effects/support`.

A support's twist follows from the six components of the wrench about the origin of P. A drive is one of them (`about
x`: the moment about x and the rotation it causes), or the moment about a horizontal axis of any azimuth (`oblique`),
under which the body may turn about x and y.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Self

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import BASE, on
from expdesign.chain.declaration import Parameter, Variant, rounded
from expdesign.chain.effect import Effect, Shows
from expdesign.chain.form import Form
from expdesign.chain.recordings.recordings import LoadedPoints, measured_axes
from expdesign.chain.row import Row
from expdesign.mechanics.robots.robot import Robot


@dataclass(frozen=True)
class Drive:
    """A component of the load that drives, and the motions that it causes.

    Attributes:
        name: in variants.
        axes: places of these motions in a twist: one, or those about x and y for an axis that is found.
    """

    name: str
    axes: tuple[int, ...]

    def __str__(self) -> str:
        return self.name

    @property
    def oblique(self) -> bool:
        """Whether the axis of the moment is found."""
        return len(self.axes) > 1

    @property
    def where(self) -> str:
        """The drive in a sentence."""
        return "about an oblique axis" if self.oblique else self.name

    def load(self, wrench: Any, azimuth: Any = 0.0) -> Any:
        """What drives of a wrench (6,) or of many (6, N): its component, or the moment about the axis of an azimuth."""
        if self.oblique:
            return ca.cos(azimuth) * wrench[3] + ca.sin(azimuth) * wrench[4]
        return wrench[self.axes[0]]

    def twist(self, amounts: ca.SX) -> ca.SX:
        """Twist (6,) of the body from the amounts of its motions."""
        return ca.SX.eye(6)[:, list(self.axes)] @ amounts

    def parameters(self, name: str, threshold: Parameter, *, low: float = float("-inf")) -> tuple[Parameter, ...]:
        """Amounts per load that begin with `name`, then their shape: a threshold and, if oblique, the azimuth."""
        if not self.oblique:
            return Parameter(f"{name}_{{motion}}_per_{{force}}", 1e-6, low=low), threshold
        amounts = (Parameter(f"{name}_{axis}_rad_per_Nm", 1e-6) for axis in ("rx", "ry"))
        return *amounts, threshold, Parameter("azimuth_rad", 1.0, neutral=0.0, low=-10.0, high=10.0, shape=True)

    def split(self, theta: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX | float]:
        """Amounts, threshold and azimuth of these parameters."""
        count = len(self.axes)
        return theta[:count], theta[count], theta[-1] if self.oblique else 0.0

    def starts(
        self, azimuths: Sequence[float], thresholds: Callable[[tuple[float, ...]], Sequence[float]]
    ) -> list[FloatArray]:
        """Where a search starts: no motion, each threshold that is asked for under each azimuth there is."""
        shapes = [(azimuth,) for azimuth in azimuths] if self.oblique else [()]
        free = np.zeros(len(self.axes))
        return [np.array([*free, threshold, *shape]) for shape in shapes for threshold in thresholds(shape)]


DRIVES = tuple(
    Drive(f"{how} {axis}", (3 * k + i,)) for k, how in enumerate(("along", "about")) for i, axis in enumerate("xyz")
)
"""In the order of a wrench."""
OBLIQUE = Drive("oblique", (3, 4))
_VARIES = 1e-9
FARTHEST = 50.0
"""m; a centre or an axis of rotation farther away than this is a translation."""


def shown_drives(points: LoadedPoints) -> set[Drive]:
    """Drives whose load varies and whose motion was measured."""
    spread = np.ptp(points.wrenches, axis=0)
    seen = measured_axes(points)
    varies = _VARIES * max(spread.max(), 1e-300)
    return {drive for drive in (*DRIVES, OBLIQUE) if all(i in seen and spread[i] > varies for i in drive.axes)}


def driven(robot: Robot, points: LoadedPoints) -> Shows:
    """Forms of these drives alone show."""
    seen = shown_drives(points)
    return lambda component, form: form.drive in seen  # type: ignore[attr-defined]


def whole_load(wrench: ca.SX, row: Row) -> tuple[ca.SX, ca.SX]:
    """The whole load of a row and that of its reference state (6,) each."""
    return row.absolute + (wrench - row.wrench), row.absolute - row.wrench


@dataclass(frozen=True)
class Over:
    """The range of a pose coordinate (its column, the `index`-th) over which a quantity is a parabola."""

    name: str
    low: float
    high: float
    index: int

    def __str__(self) -> str:
        return f"{self.name} {self.low:.6g} to {self.high:.6g}"

    @property
    def sentence(self) -> str:
        """At which pose a value holds, for people."""
        return f"halfway between {self.name} = {self.low:.6g} and {self.high:.6g}, and it changes with {self.name}"


TwistLaw = Callable[["SupportForm", ca.SX, Row, ca.SX, ca.SX], tuple[ca.SX, ca.SX]]
"""The twist (6,) that the body gains and the next states, from the form, the wrench, the row, states and parameters."""


@dataclass(frozen=True)
class SupportForm(Form):
    """A form of what a support does under a drive; its parameters may be parabolas over a pose coordinate.

    Attributes:
        twist: by how much the body moves.
        drive: direction of the load; rotations about all axes where there is none.
        over: the range of the pose coordinate.
    """

    twist: TwistLaw | None = field(default=None, compare=False)
    drive: Drive = field(default=DRIVES[3], compare=False)
    over: Over | None = field(default=None, compare=False)

    def along(self, over: Over) -> Self:
        """The same with parameters at the middle of a range, then per u and per u² (u = −1 … 1 over the range)."""
        free = [p for p in self.parameters if not p.shape]
        # A sum of powers has no simple sign; what is negative somewhere shows in the intervals.
        every = [Parameter(f"{p.name}{ending}", p.scale) for ending in ("", "_slope", "_curvature") for p in free]
        parameters = (*every, *(p for p in self.parameters if p.shape))
        return replace(self, name=f"{self.name} over {over}", parameters=parameters, over=over)

    def at(self, theta: ca.SX, row: Row) -> ca.SX:
        """Parameters that are no shapes at the pose of a row, from their powers (1, u and u² where they have some)."""
        if self.over is None:
            return theta
        u = (2.0 * row.pose[self.over.index] - (self.over.low + self.over.high)) / (self.over.high - self.over.low)
        return ca.reshape(theta, -1, 3) @ ca.vertcat(1.0, u, u**2)


def over_pose(points: LoadedPoints, names: tuple[str, ...]) -> list[Over]:
    """The ranges of the pose coordinates that vary."""
    low, high = points.configurations.min(axis=0), points.configurations.max(axis=0)
    return [
        Over(name, rounded(low[i]), rounded(high[i]), i)
        for i, name in enumerate(names)
        if high[i] - low[i] > 1e-2 * max(abs(high[i]), abs(low[i]), 1e-3)
    ]


class SupportEffect(Effect):
    """An effect of what a body stands on, each of whose forms is a twist of the body."""

    at = on(lambda robot: robot.on_support, BASE)
    together = True
    forms: ClassVar[tuple[SupportForm, ...]]
    variant: SupportForm

    @classmethod
    def variant_from_text(cls, robot: Robot, text: str) -> Variant:
        head, over, ends = text.partition(" over ")
        form = super().variant_from_text(robot, head)
        if not over or not isinstance(form, SupportForm):
            return form
        name, low, _, high = ends.split(" ")
        return form.along(Over(name, float(low), float(high), robot.configuration.index(name)))

    @property
    def units(self) -> tuple[str, str]:
        return ("N", "m") if self.variant.drive.axes[0] < 3 else ("Nm", "rad")

    def structure_with_memory(
        self, deflection: ca.SX, wrench: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        if self.variant.twist is None:
            return deflection, state
        twist, following = self.variant.twist(self.variant, wrench, row, state, theta)
        return deflection + row.rates @ twist, following


def taken_up(load: ca.SX, changeover: ca.SX, width: ca.SX) -> ca.SX:
    """Where in a gap a load holds the body, from −½ to ½: ½·x/√(1 + x²), x = (load − changeover)/width."""
    x = (load - changeover) / width
    return 0.5 * x / ca.sqrt(1.0 + x**2)

"""Errors of the instrument: its frame drifts, its axes are turned, its scale is wrong."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import casadi as ca

from expdesign.chain.component import INSTRUMENT, Component, on_any
from expdesign.chain.declaration import Beyond, Declaration, Input, Size, Variant, rounded
from expdesign.chain.effect import Effect, Parameter, Values, When
from expdesign.chain.form import Form
from expdesign.chain.recordings.recordings import DEFLECTIONS, POSITIONS, LoadedPoints, measured_axes
from expdesign.chain.row import Row
from expdesign.mechanics.robots.orientation import angles_of, rotation_matrix
from expdesign.mechanics.robots.robot import Robot

_HOUR = 3600.0


_DRIFT = tuple(Parameter(f"drift_{axis}_m_per_h", 1e-4) for axis in "xyz")
_TURNING = tuple(Parameter(f"drift_r{axis}_rad_per_h", 1e-5) for axis in "xyz")


class InstrumentDrift(Effect):
    """An instrument that measures positions drifts: its frame shifts and turns slowly against the robot's base.

    The reading y gains v·t + (w·t)×y, t the time since the first recorded row. Variants: `shift` and `shift and turn`
    (w, about the instrument's origin).
    """

    identifier = "instrument.drift"
    physics = "thermal_drift"
    declared = Declaration(
        left_out="drift of the instrument's frame",
        phrase="thermal drift of {component}",
        usually="tripods and stands that warm up",
        port="environment",
        laws=("drift",),
        inputs=(Input.TIME,),
        beyond=Beyond.HOLDS,
        sizes=(
            Size("drift_r?_rad_per_h", 1e-5, "assumed: a stand of 0.1 m that warms by 1 K on one side"),
            Size("drift_?_m_per_h", 1e-5, "assumed: a stand of 1 m of steel that warms by 1 K in an hour"),
        ),
    )
    measurands = (POSITIONS,)
    forms = (Form(name="shift", parameters=_DRIFT), Form(name="shift and turn", parameters=(*_DRIFT, *_TURNING)))
    at = on_any(INSTRUMENT)
    when: ClassVar[When] = lambda robot, points: points.timed

    def reading(self, reading: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        hours = row.clock / _HOUR
        moved = reading + theta[:3] * hours
        return moved if theta.shape[0] == len(_DRIFT) else moved + ca.cross(theta[3:6] * hours, reading)

    def sentence(self, values: Values) -> str:
        shift = {name: value for name, value in values.items() if name.endswith("_m_per_h")}
        return self.said("The instrument drifts against the robot's base by ({all:1e3 .3g}) mm per hour.", shift)


_POSES, _DIFFERENCES = Form(), Form(name="differences")
_ABOUT = tuple(Form(name=f"about {axis}") for axis in "xyz")
"""What is read in the instrument's axes: poses, differences of poses, or a body turned about one axis alone."""


def _seen_turns(points: LoadedPoints) -> list[Form]:
    """Variants for a body: a turn about an axis shows where the two axes that it mixes were measured."""
    axes = measured_axes(points)
    pairs = (({1, 2}, {4, 5}), ({0, 2}, {3, 5}), ({0, 1}, {3, 4}))
    seen = [axis for axis, mixed in zip(_ABOUT, pairs, strict=True) if any(pair <= axes for pair in mixed)]
    return [_POSES] if len(seen) == len(pairs) else seen


class InstrumentMisalignment(Effect):
    """The instrument's axes are rotated from the base frame by Q.

    An instrument that measures poses reads the position Qᵀ·p and the orientation Qᵀ·R·Q in its own axes, and a
    deflection is the difference of two such readings. Some software turns the differences themselves instead; at poses
    away from zero the two differ. Q is given by the angles of `fixed-xyz`, Q = Rz(rot_z)·Ry(rot_y)·Rx(rot_x), whatever
    the robot's own convention; the columns of Q are the instrument's axes in the base frame.

    Variants: empty (poses are read in the turned axes), `differences` (deflections are turned), and for bodies of which
    not all axes were measured `about z` and so on (deflections are turned about one axis).
    """

    identifier = "instrument.misalignment"
    physics = "instrument_misalignment"
    declared = Declaration(
        left_out="turned axes of the instrument",
        phrase="an instrument that is turned",
        usually="mounting by eye",
        port="instrument",
        sizes=(Size("rot_?_rad", 1e-3, "assumed: axes aligned with an edge, 1 mrad"),),
    )
    measurands = (DEFLECTIONS,)
    at = on_any(INSTRUMENT)
    says = "The instrument's axes are rotated from the base frame by ({all:1e3 .2f}) mrad."

    @classmethod
    def variants(cls, robot: Robot) -> list[Variant]:
        if robot.on_support:
            return [_POSES, *_ABOUT]
        # What reads poses turns them; deflections of an arm are twists, and the plane has one axis to turn about.
        return [_POSES, _DIFFERENCES] if robot.orientation is not None else [_POSES]

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> Sequence[tuple[Component, Variant]]:
        if robot.on_support:
            return [(INSTRUMENT, variant) for variant in _seen_turns(points)]
        return super().shown(robot, points)

    def describe(self) -> tuple[Parameter, ...]:
        axes = "xyz" if self.robot.coordinates.translations > 2 else "z"
        if self.variant in _ABOUT:
            axes = "xyz"[_ABOUT.index(self.variant)]
        return tuple(Parameter(f"rot_{axis}_rad", 1e-2, low=-1.0, high=1.0) for axis in axes)

    def reading(self, reading: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        if self.robot.coordinates.translations < 3:
            c, s = ca.cos(theta[0]), ca.sin(theta[0])
            return ca.vertcat(c * reading[0] + s * reading[1], -s * reading[0] + c * reading[1], reading[2:])
        if self.variant in _ABOUT:
            theta = ca.SX.eye(3)[:, _ABOUT.index(self.variant)] @ theta
        turn = rotation_matrix(theta, "fixed-xyz")
        orientation = self.robot.orientation
        if self.variant != _POSES or not self.robot.on_legs or orientation is None:
            return ca.vertcat(turn.T @ reading[:3], turn.T @ reading[3:])
        angles = angles_of(turn.T @ row.rotation @ turn, orientation)
        pose = ca.SX.sym("read", 6)
        rates = ca.substitute(self.robot.inverse_kinematics.pose_rate_map(pose), pose, ca.vertcat(row.pose[:3], angles))
        twist = ca.solve(row.rates, reading)
        return rates @ ca.vertcat(turn.T @ twist[:3], turn.T @ twist[3:])


class InstrumentScale(Effect):
    """The instrument's scale is wrong on one or more axes: it reads (1 + s_i)·d_i on the translational axes."""

    identifier = "instrument.scale"
    physics = "instrument_scale"
    declared = Declaration(
        left_out="wrong scale of the instrument",
        phrase="a wrong scale of the instrument",
        usually="optics and electronics that are not calibrated",
        port="instrument",
        sizes=(Size("scale_?", 1e-3, "assumed: gauges calibrated to 0.1 % of their range"),),
    )

    at = on_any(INSTRUMENT)
    quantities = (Parameter("scale_{axis}", 1e-2, low=-0.9, high=9.0),)

    def reading(self, reading: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        rest = ca.SX.zeros(reading.shape[0] - theta.shape[0])
        return reading * (1.0 + ca.vertcat(theta, rest))

    def sentence(self, values: Values) -> str:
        parts = ", ".join(f"{100 * v[0]:+.2f} % on {name[-1]}" for name, v in values.items())
        return f"The instrument's scale is off: {parts}."


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
    """The base, or the instrument's stand, wanders during a campaign: Brownian motion of the frame between them.

    The reading y gains x(t) + w(t)×y. Each coordinate is a Brownian motion from the first row on, as the
    Karhunen–Loève series

        x(t) = σ·Σ_k z_k·√2·sin((k − ½)·π·t/T)/((k − ½)·π),   z_k ~ N(0, 1),  k = 1 ... K

    (Ash and Gardner, Topics in Stochastic Processes, 1975, 1.4), whose K terms hold 1 − 2/(π²·K) of its variance. A
    campaign whose rows are all series of their own has six such processes, not six free numbers for every row. Beyond
    the recorded time the frame stays where it was.
    """

    identifier = "instrument.wander"
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

    at = on_any(INSTRUMENT)

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

    def sentence(self, values: Values) -> str:
        largest = max(abs(v[0]) for name, v in values.items() if name.startswith("shift"))
        return f"The instrument wanders against the base {self.variant}, by terms of up to {1e3 * largest:.3g} mm."

"""An instrument that measures positions drifts: its frame shifts and turns slowly against the robot's base.

The instrument's axes are rotated from the base frame by Q.

An instrument that measures poses reads the position Qᵀ·p and the orientation Qᵀ·R·Q in its own axes, and a deflection
is the difference of two such readings. Some software turns the differences themselves instead; at poses away from zero
the two differ.

Q is given by the angles of `fixed-xyz`, Q = Rz(rot_z)·Ry(rot_y)·Rx(rot_x), whatever the robot's own convention; the
columns of Q are the instrument's axes in the base frame.

The instrument's scale is wrong on one or more axes.
"""

from collections.abc import Sequence
from enum import StrEnum

import casadi as ca
import numpy as np

from expdesign.chain.component import INSTRUMENT, Component
from expdesign.chain.declaration import Beyond, Declaration, Input, Size, Variant
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.recordings.recordings import DEFLECTIONS, POSITIONS, LoadedPoints
from expdesign.chain.row import Row
from expdesign.chain.support import measured_axes
from expdesign.mechanics.robots.orientation import angles_of, rotation_matrix
from expdesign.mechanics.robots.robot import Robot

_HOUR = 3600.0


class FrameMotion(StrEnum):
    """Whether the instrument turns as well."""

    SHIFT = "shift"
    SHIFT_AND_TURN = "shift and turn"


class InstrumentDrift(Effect):
    """The reading y gains v·t + (w·t)×y, t the time since the first recorded row. Variants: `shift` and `shift and
    turn` (w, about the instrument's origin).
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
    forms = tuple(FrameMotion)

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return [INSTRUMENT]

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> Sequence[tuple[Component, Variant]]:
        if points.time is None or not np.any(np.diff(points.time) > 0.0):
            return []
        return super().shown(robot, points)

    def describe(self) -> tuple[Parameter, ...]:
        shift = [Parameter(f"drift_{axis}_m_per_h", 1e-4) for axis in "xyz"]
        turn = [Parameter(f"drift_r{axis}_rad_per_h", 1e-5) for axis in "xyz"]
        return tuple(shift if self.variant is FrameMotion.SHIFT else shift + turn)

    def reading(self, reading: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        hours = row.clock / _HOUR
        moved = reading + theta[:3] * hours
        return moved if self.variant is FrameMotion.SHIFT else moved + ca.cross(theta[3:6] * hours, reading)

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        shift = ", ".join(f"{1e3 * values[f'drift_{axis}_m_per_h'][0]:.3g}" for axis in "xyz")
        return f"The instrument drifts against the robot's base by ({shift}) mm per hour."


class Axes(StrEnum):
    """What is read in the instrument's axes: poses, differences of poses, or a body turned about one axis alone."""

    POSES = ""
    DIFFERENCES = "differences"
    ABOUT_X = "about x"
    ABOUT_Y = "about y"
    ABOUT_Z = "about z"


_ABOUT = (Axes.ABOUT_X, Axes.ABOUT_Y, Axes.ABOUT_Z)


def _seen_turns(points: LoadedPoints) -> list[Axes]:
    """Variants for a body: a turn about an axis shows where the two axes that it mixes were measured."""
    axes = measured_axes(points)
    pairs = (({1, 2}, {4, 5}), ({0, 2}, {3, 5}), ({0, 1}, {3, 4}))
    seen = [axis for axis, mixed in zip(_ABOUT, pairs, strict=True) if any(pair <= axes for pair in mixed)]
    return [Axes.POSES] if len(seen) == len(pairs) else seen


class InstrumentMisalignment(Effect):
    """Variants: empty (poses are read in the turned axes), `differences` (deflections are turned), and for bodies of
    which not all axes were measured `about z` and so on (deflections are turned about one axis).
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

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return [INSTRUMENT]

    @classmethod
    def variants(cls, robot: Robot) -> list[Variant]:
        if robot.on_support:
            return [Axes.POSES, *_ABOUT]
        # What reads poses turns them; deflections of an arm are twists, and the plane has one axis to turn about.
        return [Axes.POSES, Axes.DIFFERENCES] if robot.orientation is not None else [Axes.POSES]

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
        if self.variant in _ABOUT:
            angles = ca.SX.zeros(3)
            angles[_ABOUT.index(self.variant)] = theta[0]
            turn = rotation_matrix(angles, "fixed-xyz")
            return ca.vertcat(turn.T @ reading[:3], turn.T @ reading[3:])
        if theta.shape[0] == 1:
            c, s = ca.cos(theta[0]), ca.sin(theta[0])
            return ca.vertcat(c * reading[0] + s * reading[1], -s * reading[0] + c * reading[1], reading[2:])
        turn = rotation_matrix(theta, "fixed-xyz")
        orientation = self.robot.orientation
        if self.variant is Axes.DIFFERENCES or not self.robot.on_legs or orientation is None:
            return ca.vertcat(turn.T @ reading[:3], turn.T @ reading[3:])
        angles = angles_of(turn.T @ row.rotation @ turn, orientation)
        pose = ca.SX.sym("read", 6)
        rates = ca.substitute(self.robot.inverse_kinematics.pose_rate_map(pose), pose, ca.vertcat(row.pose[:3], angles))
        twist = ca.solve(row.rates, reading)
        return rates @ ca.vertcat(turn.T @ twist[:3], turn.T @ twist[3:])

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        angles = ", ".join(f"{1e3 * v[0]:.2f}" for v in values.values())
        return f"The instrument's axes are rotated from the base frame by ({angles}) mrad."


class InstrumentScale(Effect):
    """It reads (1 + s_i)·d_i on the translational axes."""

    identifier = "instrument.scale"
    physics = "instrument_scale"
    declared = Declaration(
        left_out="wrong scale of the instrument",
        phrase="a wrong scale of the instrument",
        usually="optics and electronics that are not calibrated",
        port="instrument",
        sizes=(Size("scale_?", 1e-3, "assumed: gauges calibrated to 0.1 % of their range"),),
    )

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return [INSTRUMENT]

    def describe(self) -> tuple[Parameter, ...]:
        axes = self.robot.coordinates.axes
        return tuple(Parameter(f"scale_{axis}", 1e-2, low=-0.9, high=9.0) for axis in axes)

    def reading(self, reading: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        rest = ca.SX.zeros(reading.shape[0] - theta.shape[0])
        return reading * (1.0 + ca.vertcat(theta, rest))

    def sentence(self, values: dict[str, tuple[float, float, float]]) -> str:
        parts = ", ".join(f"{100 * v[0]:+.2f} % on {name[-1]}" for name, v in values.items())
        return f"The instrument's scale is off: {parts}."

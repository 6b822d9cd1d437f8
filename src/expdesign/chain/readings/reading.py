"""What the instrument reads: the link between the motion of the platform and the instrument's own errors.

Deflections: how far the load moves the platform, in pose coordinates, by a reading before and one after.

The reading of an instrument that measures poses of the platform, in the coordinates of the commanded ones.

With known frames it is the true pose with its deflection. With unknown ones the instrument's frame and that of the
target on the platform are displaced by (t_I, R_I) and (t_T, R_T), small and unknown (theory.md 9.I):

    p' = R_Iᵀ·(p + R·t_T − t_I),   R' = R_Iᵀ·R·R_T,

p = home + X being the position of P. All base joints, or all platform joints, may be displaced alike to the same
effect: the twelve are a gauge freedom of the geometry, which priors fix and no prediction of a reading depends on.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from expdesign.arrays import BoolArray, FloatArray
from expdesign.chain.declaration import Parameter
from expdesign.chain.recordings.recordings import LoadedPoints, Recordings, Remark
from expdesign.chain.row import Row
from expdesign.coordinates import SPATIAL
from expdesign.mechanics.robots.orientation import angles_of, rotation_matrix
from expdesign.mechanics.robots.robot import Robot


class Reading(ABC):
    """One kind of reading.

    Attributes:
        names: markers whose positions are read, in the order of `Row.marker`; none for deflections.
        oriented: those of which orientations are read as well.
        fixed: fixed points and gauges from which distances are read, in the order of `Row.point`.
        by_instrument: whether an instrument reads it, with its own errors.
        start: of the unknown parameters of the instrument, in the order of `parameters`.
        absolute: whether it says where the platform is, so that geometry shows; deflections are differences.
        chord_steps: to the true pose of a platform whose geometry is not nominal: deflections need it for their lever
            arms only, absolute readings to below their noise.
        linear: whether the base model is linear in its compliances and has no further parameters.
        compliance_spread: standard deviation of a compliance in units of the robot file's before anything is measured.
    """

    names: tuple[str, ...]
    oriented: tuple[str, ...] = ()
    fixed: tuple[str, ...] = ()
    by_instrument: bool = True
    start: FloatArray
    absolute: bool
    chord_steps: int = 4
    linear: bool
    compliance_spread: float

    @property
    @abstractmethod
    def parameters(self) -> tuple[Parameter, ...]:
        """What of the instrument is unknown in every model."""

    @property
    def degeneracies(self) -> list[Remark]:
        """What of the instrument is confounded in the fitted rows."""
        return []

    @property
    def record(self) -> dict[str, object]:
        """What a model file says of it beside the values of `parameters`; empty for deflections."""
        return {}

    def width(self, robot: Robot) -> int:
        """Number of components of a reading."""
        return robot.coordinates.n

    def with_own_weight(self, row: Row, change: ca.SX) -> Row:
        """The row where the robot's own weight loads the actuators by `change` (n_p,) more than assumed."""
        return replace(row, carried=row.carried + change)

    def released(self, spreads: FloatArray) -> FloatArray:
        """Standard deviations of `parameters` where nothing is held that is merely confounded, from those held."""
        return spreads

    @abstractmethod
    def expression(self, robot: Robot, deflection: ca.SX, row: Row, theta: ca.SX, geometry: ca.SX | None) -> ca.SX:
        """The reading (width,) of a platform that deflects.

        Args:
            robot: the robot.
            deflection: in pose coordinates (n,).
            row: the row.
            theta: values of `parameters`.
            geometry: errors of the geometry of the robot's links, or None.
        """

    def pose(self, robot: Robot, deflection: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        """Pose (n,) of a platform at `row.pose` that deflects, in the frames in which targets are given."""
        return row.pose + deflection

    def displacement(self, robot: Robot, deflection: ca.SX, row: Row, theta: ca.SX, command: ca.SX) -> ca.SX:
        """That pose (n,) minus the commanded one, as far as readings of this kind show it."""
        return self.pose(robot, deflection, row, theta) - command

    @abstractmethod
    def at_points(self, points: LoadedPoints) -> LoadedPoints | None:
        """Points with markers numbered as here, or None where the points name none; raises `InputError`."""

    def predictable(self, robot: Robot, recordings: Recordings) -> BoolArray:
        """Rows whose prediction rests on nothing that the fitted rows leave confounded, shape (N,)."""
        return np.ones(len(recordings), dtype=bool)


class Deflection(Reading):
    """The reading is the deflection itself; own weight acts in both states and cancels."""

    names = ()
    absolute = False
    chord_steps = 2
    linear = True
    compliance_spread = float("inf")

    def __init__(self) -> None:
        self.start = np.zeros(0)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return ()

    def with_own_weight(self, row: Row, change: ca.SX) -> Row:
        return replace(row, own=row.own + change)

    def displacement(self, robot: Robot, deflection: ca.SX, row: Row, theta: ca.SX, command: ca.SX) -> ca.SX:
        """Where the unloaded platform stands does not show."""
        return deflection

    def expression(self, robot: Robot, deflection: ca.SX, row: Row, theta: ca.SX, geometry: ca.SX | None) -> ca.SX:
        return deflection

    def at_points(self, points: LoadedPoints) -> LoadedPoints | None:
        return replace(points, marker=None, markers=(), aim=None, poses=False)


DEFLECTION = Deflection()


FRAME_SPREAD = 0.02
"""m or rad; how well the frames are known where they are called unknown."""
_SCALE = 1e-4


@dataclass(frozen=True)
class MeasuredPose(Reading):
    """A measured pose.

    Attributes:
        frames_known: whether the frames of instrument and target are those of the commands.
        start: of the unknown placements of the frames, zeros.
    """

    frames_known: bool = True
    names = ()
    absolute = True
    linear = False
    compliance_spread = 3.0

    @property
    def start(self) -> FloatArray:  # type: ignore[override]
        return np.zeros(len(self.parameters))

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        if self.frames_known:
            return ()
        return tuple(
            Parameter(f"{frame} {axis}", _SCALE, low=-1.0, high=1.0, spread=FRAME_SPREAD)
            for frame in ("instrument", "artefact")
            for axis in SPATIAL.pose
        )

    @property
    def record(self) -> dict[str, object]:
        return {"frames": "known" if self.frames_known else "unknown"}

    def at_points(self, points: LoadedPoints) -> LoadedPoints | None:
        return points if points.poses else None

    def pose(self, robot: Robot, deflection: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        """As the instrument reads it: with unknown frames no other pose is determined."""
        return self.expression(robot, deflection, row, theta, None)

    def expression(self, robot: Robot, deflection: ca.SX, row: Row, theta: ca.SX, geometry: ca.SX | None) -> ca.SX:
        """The pose (n,) that is read of a platform at `row.pose` that deflects."""
        if self.frames_known:
            return row.pose + deflection
        assert robot.orientation is not None
        position, rotation = robot.frame(row.pose, deflection)
        instrument, target = (rotation_matrix(theta[6 * i + 3 : 6 * i + 6], "fixed-xyz") for i in range(2))
        seen = instrument.T @ (position + rotation @ theta[6:9] - theta[:3])
        angles = angles_of(instrument.T @ rotation @ target, robot.orientation)
        return ca.vertcat(seen - ca.SX(robot.inverse_kinematics.home), angles)

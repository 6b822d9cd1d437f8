"""What a laboratory writes with scipy and a kinematics library: no weights, no priors.

Zeros and the six motions of every joint's frame, the instrument's pose and the markers' places, and compliances of the
joints where they are asked for, are fitted by `least_squares` with forward differences; what cannot be told apart is
left to its trust region.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pinocchio as pin
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from research.benchmarks.arms_positions.rows import Rows

Array = npt.NDArray[np.float64]


class Script:
    """The kinematics with errors, in pinocchio."""

    def __init__(self, rows: Rows) -> None:
        self.model = pin.buildModelFromXML(rows.urdf)
        self.data = self.model.createData()
        self.numbers = [self.model.getJointId(name) for name in rows.joints]
        self.columns = [self.model.joints[number].idx_q for number in self.numbers]
        self.drawn = [self.model.jointPlacements[number].copy() for number in self.numbers]
        base, tip = (self.model.getFrameId(end, pin.FrameType.BODY) for end in rows.ends)
        self.base, self.tip = base, tip

    def poses(self, commands: Array, zeros: Array, frames: Array, compliances: Array) -> list[pin.SE3]:
        """Of the tip in the base's frame at commands (N, n); joints turn by their weight's torque at the command."""
        for number, drawn, error in zip(self.numbers, self.drawn, frames, strict=True):
            self.model.jointPlacements[number] = drawn * pin.SE3(pin.exp3(error[3:]), error[:3])
        found, q = [], pin.neutral(self.model)
        for command in commands:
            q[self.columns] = command + zeros
            if compliances.any():
                torque = -pin.computeGeneralizedGravity(self.model, self.data, q)[self.columns]
                q[self.columns] += compliances * torque
            pin.framesForwardKinematics(self.model, self.data, q)
            found.append(self.data.oMf[self.base].actInv(self.data.oMf[self.tip]))
        return found

    def drawn_poses(self, commands: Array) -> list[pin.SE3]:
        """Of the tip of the drawn robot."""
        n = len(self.numbers)
        return self.poses(commands, np.zeros(n), np.zeros((n, 6)), np.zeros(n))

    def readings(self, commands: Array, values: Array) -> Array:
        """Positions (N, markers, 3) with compliances (1e-5 rad/(N·m)), zeros, frames, instrument and places."""
        n = len(self.numbers)
        soft, zeros, frames, stand, places = np.split(values, np.cumsum([n, n, 6 * n, 6]))
        instrument = pin.SE3(pin.exp3(stand[3:]), stand[:3])
        seen = [instrument * pose for pose in self.poses(commands, zeros, frames.reshape(n, 6), 1e-5 * soft)]
        own = places.reshape(-1, 3)
        return np.array([own @ pose.rotation.T + pose.translation for pose in seen])

    def start(self, commands: Array, read: Array) -> Array:
        """As drawn, with the instrument where it sees the tips of the drawn robot, and markers at the tip."""
        n = len(self.numbers)
        tips = np.array([pose.translation for pose in self.drawn_poses(commands)])
        seen = read.mean(axis=1)
        turn, _ = Rotation.align_vectors(seen - seen.mean(axis=0), tips - tips.mean(axis=0))
        shift = seen.mean(axis=0) - turn.apply(tips.mean(axis=0))
        return np.concatenate([np.zeros(8 * n), shift, turn.as_rotvec(), np.zeros(3 * read.shape[1])])


def as_drawn(rows: Rows) -> tuple[Array, int]:
    """Held-out positions (N, markers, 3) of the drawn robot, instrument and markers fitted; number of parameters."""
    return _fitted(rows, first=8)


def by_script(rows: Rows, *, compliances: bool) -> tuple[Array, int]:
    """Held-out positions (N, markers, 3) by the script, and number of parameters."""
    return _fitted(rows, first=0 if compliances else 1)


def _fitted(rows: Rows, *, first: int) -> tuple[Array, int]:
    """Fitted is what follows `first` numbers of every joint: its compliance, zero and frame."""
    script, train = Script(rows), ~rows.held_out
    commands, read = rows.commands[train], rows.positions[train]
    start = script.start(commands, read)
    held = first * len(rows.joints)

    def whole(values: Array) -> Array:
        return np.concatenate([start[:held], values])

    def residuals(values: Array) -> Array:
        return 1e3 * (script.readings(commands, whole(values)) - read).ravel()

    found = least_squares(residuals, start[held:], x_scale="jac", xtol=1e-10)
    return script.readings(rows.commands[rows.held_out], whole(found.x)), len(found.x)

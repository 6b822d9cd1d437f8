"""Errors of an arm's geometry, and its joints' compliances under its own weight as well as the load's.

The parameters are zeros of all joints and the six motions of every joint's frame, of which those are taken that poses
can tell apart (`mechanics/minimal_set.py`): 18 of a six-axis arm with three parallel axes. Where the instrument's frame
and the target's place on the tip are unknown, their twelve displacements are parameters as well and come first; else
the frames of the base and of the tip count. What is measured are poses, or positions where no noise of rotations is
stated. Of several tips each has a target of its own, and a configuration says which one it is measured at.

`regressor_for` chooses the regressor of `experiment.calibration`, by what a robot is commanded in.
"""

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.mechanics.elastostatics.calibration import (
    Calibration,
    Elastostatic,
    Frames,
    Geometric,
    PoseMaps,
    Regressor,
    Stacked,
)
from expdesign.mechanics.minimal_set import minimal_set
from expdesign.mechanics.robots.orientation import angular_velocity_map, frame_turn, twist_transfer
from expdesign.mechanics.robots.robot import Robot
from expdesign.mechanics.symbolic import BatchFunction

TYPICAL_LENGTH, TYPICAL_ANGLE = 3e-4, 1e-3
"""m, rad; of frames and zeros before calibration."""
_TRIED = 40
"""Random configurations from which dependencies are read off."""
_INDEPENDENT = 1e-7
"""Part of a column that has to be left of it, in typical sizes: derivatives are exact."""
_TWIST = ("x", "y", "z", "rx", "ry", "rz")


class ArmGeometric(Regressor):
    """Pose error of the tip per error of the geometry, and per displacement of unknown frames.

    Args:
        frames_known: whether the instrument's frame is the base's, and its target the tip.
    """

    noun = "geometric parameters"
    measurement = "pose measurement"
    needs_load = False

    def __init__(self, *, frames_known: bool = True) -> None:
        self._frames_known = frames_known
        self._chosen: dict[int, IntArray] = {}

    def names(self, robot: Robot) -> tuple[str, ...]:
        every = self._every(robot)
        return tuple(every[index] for index in self._kept(robot))

    def scale(self, robot: Robot) -> FloatArray:
        return _sizes(self.names(robot))

    def require(self, robot: Robot) -> str | None:
        return None if robot.jointed else "geometric calibration of an arm needs links"

    def expressions(self, robot: Robot, configuration: ca.SX) -> dict[str, ca.SX]:
        whole = self._whole(robot, configuration)
        return {"arm": whole[:, self._kept(robot).tolist()]}

    def matrix(self, maps: PoseMaps) -> FloatArray:
        return maps.further["arm"]

    def _every(self, robot: Robot) -> tuple[str, ...]:
        tree = robot.links.tree
        targets = ("target",) if len(tree.tips) == 1 else tuple(f"target {tip}" for tip in tree.tips)
        frames = () if self._frames_known else ("instrument", *targets)
        return (*(f"{frame} {part}" for frame in frames for part in _TWIST), *tree.geometry_names)

    def _whole(self, robot: Robot, configuration: ca.SX) -> ca.SX:
        """The matrix of all parameters, (6, p)."""
        errors = ca.SX.sym("g", robot.links.tree.size)
        position, rotation = robot.links.tip(configuration, errors)
        rates = ca.vertcat(ca.jacobian(position, errors), angular_velocity_map(rotation, errors))
        none = ca.SX.zeros(errors.shape[0])
        position, rotation, whole = ca.substitute([position, rotation, rates], [errors], [none])
        if self._frames_known:
            return whole
        turn, seen = frame_turn(rotation, 6), robot.links.tree.looked_at(configuration)
        return ca.horzcat(twist_transfer(position, 6), *(each * turn for each in seen), whole)

    def _kept(self, robot: Robot) -> IntArray:
        """Indices of a minimal complete set: frames, zeros, lengths, angles, in this order."""
        if id(robot) not in self._chosen:
            names, links = self._every(robot), robot.links
            symbol = ca.SX.sym("q", len(robot.configuration))
            count = len(links.low)
            low, high = (
                np.where(np.isfinite(each), each, side * np.pi) for each, side in ((links.low, -1), (links.high, 1))
            )
            random = np.zeros((_TRIED, len(robot.configuration)))
            random[:, :count] = np.random.default_rng(1).uniform(low, high, (_TRIED, count))
            if len(links.tree.tips) > 1:
                random = np.repeat(random, len(links.tree.tips), axis=0)
                random[:, -1] = np.tile(np.arange(1.0, len(links.tree.tips) + 1.0), _TRIED)
            (rows,) = BatchFunction("arm", [symbol], [self._whole(robot, symbol)])(random)
            order = sorted(range(len(names)), key=lambda index: (_rank(names[index]), index))
            found = minimal_set(rows.reshape(-1, len(names)) * _sizes(names), np.array(order), _INDEPENDENT)
            self._chosen[id(robot)] = found.kept
        return self._chosen[id(robot)]


class ArmElastostatic(Elastostatic):
    """Compliances of an arm's joints as poses show them: A = J̌·diag(τ), τ by the load and by the links' own weight."""

    needs_load = True

    def expressions(self, robot: Robot, configuration: ca.SX) -> dict[str, ca.SX]:
        return {"own weight": robot.links.own_weight_expression(configuration, ca.SX(robot.gravity))}

    def matrix(self, maps: PoseMaps) -> FloatArray:
        own = maps.further["own weight"]
        own = own if own.ndim == maps.forces.ndim else own[..., 0]
        matrix: FloatArray = maps.pose * (maps.forces + own)[..., None, :]
        return matrix


def _rank(name: str) -> int:
    """Place of a parameter in the order of preference."""
    if name.startswith(("instrument", "target")):
        return 0
    if name.endswith("offset"):
        return 1
    return 3 if name.rpartition(" ")[2].startswith("r") else 2


def _sizes(names: tuple[str, ...]) -> FloatArray:
    """Typical sizes (m, rad) by names."""
    angles = [name.endswith("offset") or name.rpartition(" ")[2].startswith("r") for name in names]
    return np.where(angles, TYPICAL_ANGLE, TYPICAL_LENGTH)


def regressor_for(calibration: Calibration, *, frames_known: bool = True, links: bool = False) -> Regressor:
    """The regressor of a calibration, with unknown frames where they are so.

    `links` says that the robot is commanded in joints.
    """
    if calibration == "elastostatic":
        return Elastostatic()
    if links:
        geometric = ArmGeometric(frames_known=frames_known)
        return geometric if calibration == "geometric" else Stacked((geometric, ArmElastostatic()))
    frames = () if frames_known else (Frames(),)
    if calibration == "geometric":
        return Stacked((*frames, Geometric())) if frames else Geometric()
    return Stacked((*frames, Geometric(), Elastostatic()))

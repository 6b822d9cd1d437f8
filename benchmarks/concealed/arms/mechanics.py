"""A six-axis arm with hidden physics, solved with pinocchio: joints that wind up, links and feet that yield.

Equilibria are found by fixed-point iteration on finite positions: every joint stands at its command plus c tau + its
law, tau = J^T w less the torque that the links' weight needs, at the deflected configuration; connections of base,
links and tool are placements that follow the moment which the load makes there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
import pandas as pd
import pinocchio as pin

from virtual_laboratory.legs import LegConditions, LegLaw

from ..linear_model import Array

WRENCH = ("fx_N", "fy_N", "fz_N", "mx_Nm", "my_Nm", "mz_Nm")
DEFLECTION = ("dx_m", "dy_m", "dz_m", "drx_rad", "dry_rad", "drz_rad")
JOINTS = tuple(f"q{joint}_rad" for joint in range(1, 7))
_ITERATIONS, _TOLERANCE = 200, 1e-13

Yield = Callable[[Array, float], Array]
"""Rotation (rad, local axes) of a connection under a moment (N m) at the angle (rad) of the joint before it."""


@dataclass(frozen=True)
class Hidden:
    """What one arm hides: joints' laws and torques, and connections that yield.

    `laws`: per joint index, fresh members whose elongation is an angle under a torque. `torques`: per joint index, a
    torque (N m) from the joint's angle that comes with the load. `base`, `tool` and `links` (by the index of the link's
    joint): connections.
    """

    laws: dict[int, Callable[[], LegLaw]] = field(default_factory=dict)
    torques: dict[int, Callable[[float], float]] = field(default_factory=dict)
    links: dict[int, Yield] = field(default_factory=dict)
    base: Yield | None = None
    tool: Yield | None = None


class Arm:
    """An arm from a URDF text with true joint compliances (rad/(N m)) and hidden physics."""

    def __init__(self, urdf: str, compliance: Array, hidden: Sequence[Hidden] = ()) -> None:
        self._model = pin.buildModelFromXML(urdf)
        self._data = self._model.createData()
        self._tip = self._model.getFrameId("flange")
        self._compliance, self._hidden = compliance, hidden
        self._placements = [self._model.jointPlacements[i].copy() for i in range(self._model.njoints)]
        self._tool = self._model.frames[self._tip].placement.copy()

    def jacobian(self, q: Array) -> Array:
        """Twist of the tip (base axes, about its origin) per joint rate, 6 x 6."""
        return np.array(
            pin.computeFrameJacobian(self._model, self._data, q, self._tip, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        )

    def deflections(self, rows: pd.DataFrame) -> Array:
        """Deflections of the rows, in their order; a series starts relaxed and unloaded."""
        found = np.zeros((len(rows), 6))
        for _, series in rows.groupby("series", sort=False):
            members = [{i: make() for i, make in each.laws.items()} for each in self._hidden]
            command = series[list(JOINTS)].to_numpy(dtype=float)[0]
            at = [LegConditions(0.0, 0.0, float(q)) for q in command]
            for law, joint in ((law, i) for each in members for i, law in each.items()):
                law.start(at[joint])
            reference = self._equilibrium(command, np.zeros(6), members, at, remember=False)
            for row, wrench in zip(series.index, series[list(WRENCH)].to_numpy(dtype=float), strict=True):
                here = self._equilibrium(command, wrench, members, at, remember=True)
                turned = pin.log3(here.rotation @ reference.rotation.T)
                found[rows.index.get_loc(row)] = [*(here.translation - reference.translation), *turned]
        return found

    def _equilibrium(
        self,
        command: Array,
        wrench: Array,
        members: Sequence[dict[int, LegLaw]],
        at: Sequence[LegConditions],
        remember: bool,
    ) -> pin.SE3:
        loaded = bool(np.any(wrench))
        self._yield(command, np.zeros(6))
        q = command.copy()
        for _ in range(_ITERATIONS):
            self._yield(q, wrench)
            torque = self.jacobian(q).T @ wrench
            for each in self._hidden:
                for joint, of_angle in each.torques.items():
                    torque[joint] += of_angle(float(command[joint])) if loaded else 0.0
            weight = pin.computeGeneralizedGravity(self._model, self._data, q)
            wanted = command + self._compliance * (torque - weight)
            for laws in members:
                for joint, law in laws.items():  # laws act on what the load adds, so that they start relaxed
                    wanted[joint] += law.elongation(float(torque[joint]), at[joint])
            moved, q = float(np.abs(wanted - q).max()), wanted
            if moved < _TOLERANCE:
                break
        if remember:
            for laws in members:
                for joint, law in laws.items():
                    law.accept(float(torque[joint]), at[joint])
        return self._place(q)

    def _place(self, q: Array) -> pin.SE3:
        pin.framesForwardKinematics(self._model, self._data, q)
        return self._data.oMf[self._tip].copy()

    def _yield(self, q: Array, wrench: Array) -> None:
        """Turn the connections as the load's moment at them asks for."""
        tip = self._place(q)

        def offset(law: Yield, frame: pin.SE3, angle: float) -> pin.SE3:
            moment = wrench[3:] + np.cross(tip.translation - frame.translation, wrench[:3])
            return pin.SE3(pin.exp3(law(frame.rotation.T @ moment, angle)), np.zeros(3))

        placements, tool = [each.copy() for each in self._placements], self._tool.copy()
        for each in self._hidden:
            if each.base is not None:
                placements[1] = offset(each.base, pin.SE3.Identity(), 0.0) * placements[1]
            for joint, law in each.links.items():  # the link's far end: the next joint, or the tool
                frame, angle = self._data.oMi[joint + 1], float(q[joint])
                if joint + 2 < self._model.njoints:
                    placements[joint + 2] = offset(law, frame, angle) * placements[joint + 2]
                else:
                    tool = offset(law, frame, angle) * tool
            if each.tool is not None:
                tool = tool * offset(each.tool, tip, 0.0)
        for index, placement in enumerate(placements):
            self._model.jointPlacements[index] = placement
        self._model.frames[self._tip].placement = tool

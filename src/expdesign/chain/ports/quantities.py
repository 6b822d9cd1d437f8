"""What a port sees: effort, place, time, temperature and history, as expressions of one row and as numbers of many."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import moment_at, passive_joint_turns, sprung_twist, with_links_beyond
from expdesign.chain.declaration import Input
from expdesign.chain.row import Row, RowData
from expdesign.mechanics.robots.orientation import frame_turn, twist_transfer
from expdesign.mechanics.robots.robot import Robot
from expdesign.mechanics.symbolic import BatchFunction

_STATES = {"stop": 2, "slip": 2, "lag": 2, "latched": 3}
"""Quantities with memory, and how many states each carries: the force of the row before is one of them."""
_FORCES = "effort effort_sign whole rest ground joint_moment carried pair pair_sign weight"
_INPUTS = {
    **dict.fromkeys(_FORCES.split(), Input.FORCE),
    **dict.fromkeys(("clock", "after", "elapsed", "started"), Input.TIME),
    **dict.fromkeys(("warming", "temperature", "warmth"), Input.TEMPERATURE),
}
"""What is neither a place nor remembered, in the words of declarations."""
_DRIFTS = ("clock", "elapsed", "started", "temperature", "warmth")
_LEAST_OVERLAP = 1e-3
"""m, rad; a guide is not drawn out farther."""


@dataclass(frozen=True)
class Quantity:
    """One number that a port sees.

    Attributes:
        kind: what (`_VALUES`), or what remembers a force (`stop`, `lag`) or how far a leg bent (`slip`).
        index: of which actuator, axis or coordinate.
        setting: threshold (N, N·m, rad) of a stop operator, time constant (s) of a lag or of settling, point of a
            distance (m), end of a guide and the way to it, temperature (°C) from which one counts, index of the other
            actuator of a pair, time (s) of a jump.
    """

    kind: str
    index: int = 0
    setting: tuple[float, ...] = ()

    @property
    def states(self) -> int:
        """States carried from row to row of a series."""
        return _STATES.get(self.kind, 0)

    @property
    def drifts(self) -> bool:
        """Whether it goes on changing beyond what was recorded, as time and temperature do."""
        return self.kind in _DRIFTS

    @property
    def input(self) -> Input:
        """What it is in the words of declarations; memory is known by its states, and all other things are places."""
        return Input.HISTORY if self.states else _INPUTS.get(self.kind, Input.PLACE)

    def expression(self, row: Row, robot: Robot, state: ca.SX) -> tuple[ca.SX, ca.SX]:
        """The quantity in one row and the states after it.

        `stop`: s ← clip(s + Δτ, ±r), the stop operator of rate-independent hysteresis (Prandtl and Ishlinskii; Visintin
        1994); `slip`: the same of how far a leg is bent whose joints stick. `latched`: the direction of the last force,
        along the platform's axes (or in its x-y plane), that exceeded a limit. `overlap`: 1/(what is left of a guide
        until it is drawn out), to which the tilt by its clearance is proportional. `settling`: 1 − exp(−t/T) from the
        start of the series. `lag`: the slow part y of a force, T·dy/dt = τ − y; τ changes within the interval. `pair`,
        `pair_sign`: what two actuators carry together, as a bracket on which both stand, and its sign. `after`: 1 in
        rows after a jump.
        """
        if self.kind in ("stop", "slip"):
            follows = _seen("effort" if self.kind == "stop" else "bend", row, robot)
            force, (limit,) = follows[self.index], self.setting
            moved = state[1] + force - state[0]
            stopped = ca.fmax(ca.fmin(moved, limit), -limit)
            return stopped, ca.vertcat(force, stopped)
        if self.kind == "lag":
            force, (time, applied) = _seen("effort", row, robot)[self.index], self.setting
            slow = state[1] + (state[0] - state[1]) * (1.0 - ca.exp(-(1.0 - applied) * row.interval / time))
            slow = slow + (force - slow) * (1.0 - ca.exp(-applied * row.interval / time))
            return slow, ca.vertcat(force, slow)
        if self.kind == "latched":
            limit, planar = self.setting
            force = _carried(row)[: row.gravity.shape[0]]
            within = force[:2] if planar else force
            size = ca.sqrt(ca.sumsqr(within) + 1e-12)
            turned = ca.vertcat(within / size, ca.SX.zeros(3 - within.shape[0]))
            kept = ca.if_else(size > limit, turned, state)
            return kept[self.index], kept
        if self.kind == "overlap":
            end, way = self.setting
            return 1.0 / ca.fmax(way * (end - row.pose[self.index]), _LEAST_OVERLAP), ca.SX.zeros(0)
        if self.kind == "settling":
            return 1.0 - ca.exp(-row.elapsed / self.setting[0]), ca.SX.zeros(0)
        if self.kind in ("pair", "pair_sign"):
            efforts = _seen("effort", row, robot)
            both = efforts[self.index] + efforts[int(self.setting[0])]
            return both if self.kind == "pair" else ca.sign(both), ca.SX.zeros(0)
        if self.kind == "after":
            return ca.if_else(row.clock > self.setting[0], 1.0, 0.0), ca.SX.zeros(0)
        if self.kind == "temperature" and self.setting:
            return _seen(self.kind, row, robot)[self.index] - self.setting[0], ca.SX.zeros(0)
        value = _seen(self.kind, row, robot)
        if self.kind in ("distance", "towards"):
            away = value - ca.SX(list(self.setting))
            length = ca.sqrt(ca.sumsqr(away) + 1e-12)
            return (length if self.kind == "distance" else away[self.index] / length), ca.SX.zeros(0)
        return value[self.index], ca.SX.zeros(0)


def _effort(row: Row) -> ca.SX:
    """Actuator forces (N, N·m) that what is measured shows, the wrench at the platform, and the same about O."""
    forces = row.forward.T @ row.wrench + row.carried if row.carried.shape[0] else ca.SX.zeros(0)
    return ca.vertcat(forces, row.wrench + row.weight, _ground(row))


def _carried(row: Row) -> ca.SX:
    """The wrench at the platform along the platform's axes."""
    wrench = row.wrench + row.weight
    return frame_turn(row.rotation, wrench.shape[0]).T @ wrench


def _own_deflection(row: Row, robot: Robot) -> ca.SX:
    """Deflection by the actuators' springs as the robot file has them."""
    if not len(robot.stiffness):
        return 0.0 * row.wrench
    return row.pose_map @ (_effort(row)[: len(robot.stiffness)] / ca.SX(robot.stiffness))


def _joint_moments(row: Row, robot: Robot) -> ca.SX:
    """Moments about every joint of an arm along the joint's own axes, joint after joint."""
    tree, found = robot.links.tree, []
    for joint in range(len(robot.stiffness)):
        point, frame = tree.joint_frame(row.pose, joint)
        found.append(frame.T @ moment_at(with_links_beyond(robot, row.wrench, row, joint + 1), row, point))
    return ca.vertcat(*found)


def _bends(row: Row, robot: Robot) -> ca.SX:
    """Moments at the ends of legs whose joints do not turn, as the actuators' springs yield, leg after leg.

    In units of 4EI/q (rad): of a beam that is turned by φ and ψ at its ends φ − ψ/2 and ψ − φ/2, and its torsion.
    """
    twist = sprung_twist(robot, row)
    found = []
    for leg in range(len(robot.stiffness)):
        base, *others = (turn @ twist for turn in passive_joint_turns(robot, row, leg))
        if others:
            platform, about = others
            base, others = base - 0.5 * platform, [platform - 0.5 * base, about]
        found += [base, *others]
    return ca.vertcat(*found)


def _turned_gravity(row: Row) -> ca.SX:
    """Gravity along the platform's axes."""
    return row.rotation.T @ row.gravity


def _ground(row: Row) -> ca.SX:
    """The wrench at the platform referred to the origin of O."""
    wrench = row.wrench + row.weight
    return twist_transfer(row.position, wrench.shape[0]).T @ wrench


_VALUES = {
    "effort": lambda row, robot: _effort(row),
    "effort_sign": lambda row, robot: ca.sign(_effort(row)),
    "ground": lambda row, robot: _ground(row),
    "whole": lambda row, robot: row.absolute,
    "rest": lambda row, robot: row.absolute - row.wrench,
    "length": lambda row, robot: row.lengths,
    "pose": lambda row, robot: row.pose,
    "position": lambda row, robot: row.position,
    "distance": lambda row, robot: row.position,
    "towards": lambda row, robot: row.position,
    "rotation": lambda row, robot: ca.vec(row.rotation),
    "clock": lambda row, robot: row.clock,
    "elapsed": lambda row, robot: row.elapsed,
    "started": lambda row, robot: row.clock - row.elapsed,
    "warming": lambda row, robot: row.warming,
    "temperature": lambda row, robot: row.warmth + row.warming,
    "warmth": lambda row, robot: row.warmth,
    "weight": lambda row, robot: ca.sqrt(ca.sumsqr(row.wrench[: row.gravity.shape[0]]) + 1e-12),
    "loaded": lambda row, robot: ca.SX(row.payload),
    "gravity": lambda row, robot: row.gravity,
    "carried": lambda row, robot: _carried(row),
    "bend": _bends,
    "own_gravity": lambda row, robot: _turned_gravity(row),
    "deflection": _own_deflection,
    "joint_moment": _joint_moments,
}


@lru_cache(maxsize=256)
def _seen(kind: str, row: Row, robot: Robot) -> ca.SX:
    """All quantities of a kind without memory: one expression for all laws that use them."""
    return _VALUES[kind](row, robot)


def evaluate(quantities: Sequence[Quantity], rows: RowData, row: Row, robot: Robot) -> FloatArray:
    """Quantities of all rows, shape (N, Q); those with memory follow the rows of every series in order."""
    found = np.empty((len(rows), len(quantities)))
    plain = [i for i, quantity in enumerate(quantities) if not quantity.states]
    memory = [i for i, quantity in enumerate(quantities) if quantity.states]
    if plain:
        values = [quantities[i].expression(row, robot, ca.SX.zeros(0))[0] for i in plain]
        found[:, plain] = BatchFunction("quantities", [row.flat()], [ca.vertcat(*values)])(rows.values)[0]
    if memory:
        state = ca.SX.sym("state", sum(quantities[i].states for i in memory))
        values, following, offset = [], [], 0
        for i in memory:
            width = quantities[i].states
            value, after = quantities[i].expression(row, robot, state[offset : offset + width])
            values.append(value)
            following.append(after)
            offset += width
        step = BatchFunction("remember", [state, row.flat()], [ca.vertcat(*following), ca.vertcat(*values)])
        states = np.zeros((int(rows.series.max()) + 1, state.shape[0]))
        for position in range(int(rows.position.max()) + 1):
            chosen = np.flatnonzero(rows.position == position)
            now, seen = step(states[rows.series[chosen]], rows.values[chosen])
            states[rows.series[chosen]] = now
            found[chosen[:, None], np.array(memory)] = seen
    return found

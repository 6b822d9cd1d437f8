"""What a port sees: effort, place, time, temperature and history, as expressions of one row and as numbers of many.

A kind of quantity says everything about itself in one entry of `KINDS`: its names, its unit and its value.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import moment_at, passive_joint_turns, sprung_twist, with_links_beyond
from expdesign.chain.declaration import Input
from expdesign.chain.memory import relaxed
from expdesign.chain.row import LAGS, Row, RowData
from expdesign.mechanics.robots.orientation import frame_turn, twist_transfer
from expdesign.mechanics.robots.robot import Robot
from expdesign.mechanics.symbolic import BatchFunction

_LEAST_OVERLAP = 1e-3
"""m, rad; a guide is not drawn out farther."""


@dataclass(frozen=True)
class Quantity:
    """One number that a port sees.

    Attributes:
        kind: what, a key of `KINDS`.
        index: of which actuator, axis or coordinate; of a slow temperature, which of `LAGS`.
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
        return KINDS[self.kind].states

    @property
    def drifts(self) -> bool:
        """Whether it goes on changing beyond what was recorded, as time and temperature do."""
        return KINDS[self.kind].drifts

    @property
    def input(self) -> Input:
        """What it is in the words of declarations; memory is known by its states, and all other things are places."""
        return Input.HISTORY if self.states else KINDS[self.kind].input

    def name(self, robot: Robot) -> str:
        """As people speak of it, with the actuator, axis or coordinate."""
        return KINDS[self.kind].name.format_map(_Parts(self, robot))

    def identifier(self, robot: Robot) -> str:
        """As files name it (file-formats.md, diagnosis.json), e.g. `length`; of whose, the component says."""
        return KINDS[self.kind].identifier.format_map(_Parts(self, robot))

    def unit(self, robot: Robot) -> str:
        """Its SI unit; '' of what is a ratio or a direction."""
        return KINDS[self.kind].unit.format_map(_Parts(self, robot))

    @property
    def counted_from(self) -> float:
        """What was taken from a temperature (°C), so that a law of it is none of a constant; 0 of all else."""
        return self.setting[0] if self.kind in _COUNTED and self.setting else 0.0

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
            slow = relaxed(state[1], state[0], (1.0 - applied) * row.interval, time)
            slow = relaxed(slow, force, applied * row.interval, time)
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
        value = _seen(self.kind, row, robot)
        if self.kind in ("distance", "towards"):
            away = value - ca.SX(list(self.setting))
            length = ca.sqrt(ca.sumsqr(away) + 1e-12)
            return (length if self.kind == "distance" else away[self.index] / length), ca.SX.zeros(0)
        return value[self.index] - self.counted_from, ca.SX.zeros(0)


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


def _ground(row: Row) -> ca.SX:
    """The wrench at the platform referred to the origin of O."""
    wrench = row.wrench + row.weight
    return twist_transfer(row.position, wrench.shape[0]).T @ wrench


@dataclass(frozen=True)
class Kind:
    """One kind of quantity. Names and unit are templates of `_PARTS`.

    Attributes:
        name: for people.
        identifier: in files.
        unit: SI unit.
        value: all quantities of the kind in a row; None where `Quantity.expression` makes them of others.
        input: what it is in the words of declarations, where it remembers nothing.
        drifts: whether it goes on changing beyond what was recorded.
        states: how many it carries; the force of the row before is one of them.
    """

    name: str
    identifier: str
    unit: str = ""
    value: Callable[[Row, Robot], ca.SX] | None = None
    input: Input = Input.PLACE
    drifts: bool = False
    states: int = 0


_FORCE, _TIME, _HEAT = Input.FORCE, Input.TIME, Input.TEMPERATURE
_COUNTED = ("temperature", "slow_temperature", "slow_warmth")
"""Kinds that are counted from their setting, where they have one."""
_SERIES = "the time since the series' first row"
KINDS = {
    "effort": Kind("{effort}", "{force}", "{effort_unit}", lambda row, robot: _effort(row), _FORCE),
    "effort_sign": Kind(
        "the sign of {effort}", "{force}_sign", "", lambda row, robot: ca.sign(_effort(row)), _FORCE
    ),
    "stop": Kind("the history of {effort}", "{force}_history", "{effort_unit}", states=2),
    "lag": Kind("the history of {effort}", "{force}_history", "{effort_unit}", states=2),
    "slip": Kind("how far it was bent", "bending_history", "rad", states=2),
    "latched": Kind("the direction of the last force that was large enough", "force_history", states=3),
    "pair": Kind("{pair}", "force_of_both", "N", input=_FORCE),
    "pair_sign": Kind("the sign of {pair}", "force_of_both_sign", input=_FORCE),
    "whole": Kind("{load}", "{component}", "{load_unit}", lambda row, robot: row.absolute, _FORCE),
    "rest": Kind(
        "{load} of the reference", "load_of_reference", "{load_unit}", lambda row, robot: row.absolute - row.wrench,
        _FORCE,
    ),
    "ground": Kind("{wrench} about the origin of O", "{wrench}_about_O", "N", lambda row, robot: _ground(row), _FORCE),
    "carried": Kind(
        "{wrench} along the platform's axes", "{wrench}_along_platform", "", lambda row, robot: _carried(row), _FORCE
    ),
    "weight": Kind(
        "the size of the load", "load", "N",
        lambda row, robot: ca.sqrt(ca.sumsqr(row.wrench[: row.gravity.shape[0]]) + 1e-12), _FORCE,
    ),
    "joint_moment": Kind(
        "the moment about {axis} of joint {joint}", "moment_{axis}", "", _joint_moments, _FORCE
    ),
    "loaded": Kind("loaded", "loaded", "", lambda row, robot: ca.SX(row.payload)),
    "length": Kind("{length}", "{place}", "{length_unit}", lambda row, robot: row.lengths),
    "overlap": Kind("what {coordinate} leaves of its guide", "overlap"),
    "pose": Kind("{coordinate}", "{coordinate}", "{pose_unit}", lambda row, robot: row.pose),
    "position": Kind("the place of P along {axis}", "position_{axis}", "m", lambda row, robot: row.position),
    "distance": Kind("the distance from ({point}) m", "distance", "", lambda row, robot: row.position),
    "towards": Kind("towards", "towards", "", lambda row, robot: row.position),
    "rotation": Kind("rotation", "rotation", "", lambda row, robot: ca.vec(row.rotation)),
    "gravity": Kind("gravity", "gravity", "", lambda row, robot: row.gravity),
    "own_gravity": Kind(
        "gravity along the platform's {axis}", "gravity_{axis}", "", lambda row, robot: row.rotation.T @ row.gravity
    ),
    "bend": Kind("bend", "bend", "", _bends),
    "deflection": Kind(
        "the deflection along {deflection}", "deflection_{deflection}", "{pose_unit}", _own_deflection
    ),
    "clock": Kind("the time since the first row", "time", "s", lambda row, robot: row.clock, _TIME, drifts=True),
    "elapsed": Kind(_SERIES, "time_in_series", "s", lambda row, robot: row.elapsed, _TIME, drifts=True),
    "started": Kind(
        "the time of the series' first row", "time", "s", lambda row, robot: row.clock - row.elapsed, _TIME,
        drifts=True,
    ),
    "settling": Kind(_SERIES, "time_in_series"),
    "after": Kind("whether the time is before or after {moment}", "time", input=_TIME),
    "warming": Kind("the warming", "temperature_change", "K", lambda row, robot: row.warming, _HEAT),
    "temperature": Kind(
        "the temperature", "temperature", "degC", lambda row, robot: row.warmth + row.warming, _HEAT, drifts=True
    ),
    "warmth": Kind(
        "the temperature of the series' first row", "temperature", "degC", lambda row, robot: row.warmth, _HEAT,
        drifts=True,
    ),
    "slow_temperature": Kind(
        "the temperature, followed with a time constant of {lag} s", "slow_temperature", "degC",
        lambda row, robot: row.lagged, _HEAT, drifts=True,
    ),
    "slow_warmth": Kind(
        "the same at the series' first row", "slow_temperature", "degC",
        lambda row, robot: row.lagged_first, _HEAT, drifts=True,
    ),
    "approach": Kind(
        "the direction of the last move of {actuator}", "approach", "", lambda row, robot: row.approach, Input.HISTORY
    ),
}  # fmt: skip
"""By the names that model files have for them."""


def _effort_words(quantity: Quantity, robot: Robot) -> tuple[str, str, str]:
    """Name, word and unit of the force in an actuator, or of a component of the wrench at the platform or about O."""
    index = quantity.index - len(robot.stiffness)
    if index < 0:
        word, unit = ("moment", "N·m") if _turns(quantity, robot) else ("force", "N")
        return f"the {word} in {robot.actuators[quantity.index]}", word, unit
    part, axis = divmod(index, robot.coordinates.n)
    word = robot.coordinates.wrench[axis]
    return word + ("" if part == 0 else " about the origin of O"), word, "N·m" if axis >= len(robot.gravity) else "N"


def _turns(quantity: Quantity, robot: Robot) -> bool:
    """Whether the actuator of a quantity turns; False where it is of none."""
    return quantity.index < len(robot.stiffness) and robot.units[quantity.index] == "rad"


def _component(quantity: Quantity, robot: Robot) -> tuple[str, str, str]:
    """A component of the load: `force` or `moment`, the word before its axis, and the axis."""
    d = len(robot.gravity)
    force = quantity.index < d
    return ("force", "along", "xyz"[quantity.index]) if force else ("moment", "about", "xyz"[quantity.index - d])


def _place_name(quantity: Quantity, robot: Robot) -> str:
    return "angle" if _turns(quantity, robot) else "length"


def _length_name(quantity: Quantity, robot: Robot) -> str:
    place = _place_name(quantity, robot)
    return f"the {place} of {robot.actuators[quantity.index]}" if quantity.index < len(robot.stiffness) else place


_PARTS: dict[str, Callable[[Quantity, Robot], str]] = {
    "effort": lambda q, robot: _effort_words(q, robot)[0],
    "force": lambda q, robot: _effort_words(q, robot)[1],
    "effort_unit": lambda q, robot: _effort_words(q, robot)[2],
    "pair": lambda q, robot: (
        f"the force in {robot.actuators[q.index]} and {robot.actuators[int(q.setting[0])]} together"
    ),
    "load": lambda q, robot: "the {} {} {}".format(*_component(q, robot)),
    "component": lambda q, robot: "{0}_{2}".format(*_component(q, robot)),
    "load_unit": lambda q, robot: "N·m" if q.index >= len(robot.gravity) else "N",
    "wrench": lambda q, robot: robot.coordinates.wrench[q.index % robot.coordinates.n],
    "axis": lambda q, robot: "xyz"[q.index % 3],
    "joint": lambda q, robot: str(q.index // 3 + 1),
    "length": _length_name,
    "place": _place_name,
    "length_unit": lambda q, robot: robot.units[q.index] if q.index < len(robot.stiffness) else "m",
    "coordinate": lambda q, robot: robot.configuration[q.index % max(len(robot.configuration), 1)],
    "pose_unit": lambda q, robot: "m" if q.index < len(robot.gravity) else "rad",
    "deflection": lambda q, robot: robot.coordinates.deflection[q.index % robot.coordinates.n],
    "actuator": lambda q, robot: robot.actuators[q.index],
    "lag": lambda q, robot: f"{LAGS[q.index]:.0f}",
    "point": lambda q, robot: ", ".join(f"{v:.3g}" for v in q.setting),
    "moment": lambda q, robot: "".join(f"{v:.4g} s" for v in q.setting),
}
"""What templates of names and units may hold."""


@dataclass(frozen=True)
class _Parts:
    """The parts of one quantity's names, as templates ask for them."""

    quantity: Quantity
    robot: Robot

    def __getitem__(self, part: str) -> str:
        return _PARTS[part](self.quantity, self.robot)


@lru_cache(maxsize=256)
def _seen(kind: str, row: Row, robot: Robot) -> ca.SX:
    """All quantities of a kind without memory: one expression for all laws that use them."""
    value = KINDS[kind].value
    assert value is not None
    return value(row, robot)


def seen_in(
    quantities: Sequence[Quantity], row: Row, robot: Robot, state: ca.SX
) -> tuple[dict[Quantity, ca.SX], ca.SX]:
    """Quantities in one row, and the states after it of those that remember, in their order."""
    found, following, offset = {}, [ca.SX.zeros(0)], 0
    for quantity in quantities:
        # An empty slice of a CasADi scalar is a row.
        own = state[offset : offset + quantity.states] if quantity.states else ca.SX.zeros(0)
        found[quantity], after = quantity.expression(row, robot, own)
        following.append(after)
        offset += quantity.states
    return found, ca.vertcat(*following)


def evaluate(quantities: Sequence[Quantity], rows: RowData, row: Row, robot: Robot) -> FloatArray:
    """Quantities of all rows, shape (N, Q); those with memory follow the rows of every series in order."""
    state = ca.SX.sym("state", sum(quantity.states for quantity in quantities))
    seen, following = seen_in(quantities, row, robot, state)
    step = BatchFunction("quantities", [state, row.flat()], [following, ca.vertcat(*(seen[q] for q in quantities))])
    found, states = np.empty((len(rows), len(quantities))), np.zeros((int(rows.series.max()) + 1, state.shape[0]))
    # Without memory all rows are taken at once.
    positions = rows.position if state.numel() else np.zeros(len(rows), dtype=np.int64)
    for position in range(int(positions.max()) + 1):
        chosen = np.flatnonzero(positions == position)
        states[rows.series[chosen]], found[chosen] = step(states[rows.series[chosen]], rows.values[chosen])
    return found

"""Physics of machines that no list holds, for practice: formulas of a textbook on linear maps, in numpy alone.

Every kind is what one part does beyond its spring: an elongation of legs, a twist of the platform's mount or of the
base, a wrench, or a change of the reading. Its size is set afterwards (`practice`), so that only shapes matter here.
The kinds were chosen from what machines do, none from the generator of the proof, and serve to develop and to
calibrate; no rate of a report comes from them.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd
from benchmarks.concealed.experiments import Experiment, Wishes
from benchmarks.concealed.linear_model import Array, maps_of, pose_columns, wrenches

Generator = np.random.Generator


class Rows:
    """All rows of an experiment, those of the judge included, in the order of time.

    Attributes:
        wrench, force, pose: per row (N × n, N × legs, N × n); `position` (N × d) of P in O, `turn` (N × d × d).
        series: number of the series; `place` in it; `time`, `elapsed` (s; rows count as 60 s apart without clock).
        warming: K since the series' first row.
    """

    def __init__(self, experiment: Experiment) -> None:
        robot = self.robot = experiment.machine.robot
        frame = pd.concat([experiment.rows, experiment.later]).sort_values("sequence", ignore_index=True)
        self.reach, self.compliance = experiment.machine.reach, 1.0 / experiment.machine.true_stiffness
        maps = maps_of(robot, frame)
        self.forward, self.map = np.array([m.forward for m in maps]), np.array([m.pose for m in maps])
        self.rates = self.map @ np.linalg.inv(self.forward)
        self.pose = frame[pose_columns(robot)].to_numpy(dtype=float)
        self.wrench = wrenches(robot, frame)
        self.force = np.einsum("rij,ri->rj", self.forward, self.wrench)
        d = self.d = 2 if robot.planar else 3
        at = [robot.pose(pose) for pose in self.pose]
        self.position, self.turn = np.array([p.position[:d] for p in at]), np.array([p.rotation for p in at])
        self.series = frame["series"].to_numpy(dtype=int)
        self.loaded = np.abs(self.wrench).max(axis=1) > 0.0
        self.time = frame["time_s"].to_numpy(dtype=float) if "time_s" in frame else 60.0 * np.arange(len(frame))
        first = np.array([np.flatnonzero(self.series == s)[0] for s in self.series])
        self.first, self.elapsed = first, self.time - self.time[first]
        degrees = frame["temperature_degC"].to_numpy(dtype=float) if "temperature_degC" in frame else 0.0 * self.time
        self.warming = degrees - degrees[first]
        arms = 0.0 if robot.planar else robot.platform_joints @ np.swapaxes(self.turn, 1, 2)
        self.length = np.linalg.norm(self.position[:, None, :] + arms - robot.base_joints[:, :d], axis=2)

    def legs(self, elongation: Array) -> Array:
        """What elongations of the legs (N × legs) make of the deflections."""
        return np.asarray(np.einsum("rij,rj->ri", self.map, elongation))

    def one_leg(self, leg: int, elongation: Array) -> Array:
        """What an elongation (N,) of one leg makes of them."""
        return np.asarray(self.map[:, :, leg] * elongation[:, None])

    def platform(self, twist: Array) -> Array:
        """What a twist of the mount (N × n, along the platform's axes) makes of them."""
        d = self.d
        parts = [
            np.einsum("rij,rj->ri", self.turn[:, :d, :d], part) for part in np.split(twist, twist.shape[1] // d, 1)
        ]
        return np.asarray(np.einsum("rij,rj->ri", self.rates, np.hstack(parts)))

    def base(self, twist: Array) -> Array:
        """What a twist of the base about the origin of O (N × n) makes of them."""
        moved = twist.copy()
        if self.d == 3:
            moved[:, :3] += np.cross(twist[:, 3:], self.position)
        return np.asarray(np.einsum("rij,rj->ri", self.rates, moved))

    def load(self, wrench: Array) -> Array:
        """What a further wrench (N × n) on the platform makes of them."""
        force = np.einsum("rij,ri->rj", self.forward, wrench)
        return self.legs(force * self.compliance)

    @property
    def own(self) -> Array:
        """What the springs make: the deflections without anything else."""
        return self.legs(self.force * self.compliance)

    @property
    def carried(self) -> Array:
        """The wrench along the platform's axes."""
        d = self.d
        parts = np.split(self.wrench, self.wrench.shape[1] // d, 1)
        return np.hstack([np.einsum("rji,rj->ri", self.turn[:, :d, :d], part) for part in parts])

    @property
    def ground(self) -> Array:
        """The wrench about the origin of O."""
        if self.d == 2:
            return self.wrench
        turned = self.wrench[:, 3:] + np.cross(self.position, self.wrench[:, :3])
        return np.hstack([self.wrench[:, :3], turned])

    def remembered(self, values: Array, step: Callable[[Array, Array, int], Array]) -> Array:
        """States (N, k) of a memory: `step(state, change, row)` from the rest at every series' start."""
        found = np.zeros_like(values)
        state: Array = np.zeros(values.shape[1])
        for row in range(len(values)):
            if self.first[row] == row:
                state, before = np.zeros(values.shape[1]), np.zeros(values.shape[1])
            state = step(state, values[row] - before, row)
            before, found[row] = values[row], state
        return found


@dataclass(frozen=True)
class Kind:
    """One kind of physics.

    Attributes:
        name: of the kind.
        wishes: what it needs of an experiment.
        make: rows and draws to accepted components and what it adds to the deflections (N × n).
        names: listed physics that would not be a wrong name.
        planar: whether a bipod can have it.
    """

    name: str
    wishes: Wishes
    make: Callable[[Rows, Generator], tuple[tuple[str, ...], Array]]
    names: tuple[str, ...] = ()
    planar: bool = True


def _busy(rows: Rows, rng: Generator) -> int:
    typical = np.abs(rows.force).mean(axis=0)
    return int(rng.choice(np.flatnonzero(typical > 0.5 * typical.max())))


def _of_leg(law: Callable[[Rows, int, Generator], Array]) -> Callable[[Rows, Generator], tuple[tuple[str, ...], Array]]:
    """A law of one leg."""

    def make(rows: Rows, rng: Generator) -> tuple[tuple[str, ...], Array]:
        leg = _busy(rows, rng)
        return (f"leg {leg + 1}",), rows.one_leg(leg, law(rows, leg, rng))

    return make


def _of_all(law: Callable[[Rows, int, Generator], Array]) -> Callable[[Rows, Generator], tuple[tuple[str, ...], Array]]:
    """The same law in all legs."""

    def make(rows: Rows, rng: Generator) -> tuple[tuple[str, ...], Array]:
        seed = int(rng.integers(2**31))
        each = [law(rows, leg, np.random.default_rng(seed)) for leg in range(rows.force.shape[1])]
        return ("all legs",), rows.legs(np.column_stack(each))

    return make


def _scaled(values: Array) -> Array:
    return np.asarray(values / max(float(np.abs(values).max()), 1e-300))


def _worn_in_the_middle(rows: Rows, leg: int, rng: Generator) -> Array:
    q = rows.length[:, leg]
    middle, width = rng.uniform(*np.quantile(q, [0.25, 0.75])), rng.uniform(0.5, 1.2) * q.std()
    return np.asarray(rows.force[:, leg] / (1.0 + ((q - middle) / width) ** 2))


def _longer_is_softer(rows: Rows, leg: int, rng: Generator) -> Array:
    q = rows.length[:, leg]
    return np.asarray(rows.force[:, leg] * (q / q.mean()) ** rng.integers(2, 5))


def _preloaded_bearing(rows: Rows, leg: int, rng: Generator) -> Array:
    force = _scaled(rows.force[:, leg])
    width = rng.uniform(0.05, 0.3)
    return np.asarray(width * np.logaddexp(0.0, force / width) - width * np.log(2.0))


def _hertz(rows: Rows, leg: int, rng: Generator) -> Array:
    force = _scaled(rows.force[:, leg])
    return np.asarray(np.sign(force) * np.abs(force) ** rng.uniform(0.4, 0.7))


def _soft_then_stiff(rows: Rows, leg: int, rng: Generator) -> Array:
    return np.asarray(np.tanh(_scaled(rows.force[:, leg]) / rng.uniform(0.08, 0.35)))


def _hardening(rows: Rows, leg: int, rng: Generator) -> Array:
    force = _scaled(rows.force[:, leg])
    return np.asarray(force**2 * (np.sign(force) if rng.random() < 0.5 else 1.0))


def _bouc_wen(rows: Rows, leg: int, rng: Generator) -> Array:
    force, width = _scaled(rows.force[:, leg])[:, None], rng.uniform(0.15, 0.5)

    def step(state: Array, change: Array, row: int) -> Array:
        for _ in range(20):
            state = state + change / 20 * (1.0 - np.sign(change * state) * np.minimum(np.abs(state) / width, 1.0))
        return state

    return rows.remembered(force, step)[:, 0]


def _logarithmic_creep(rows: Rows, leg: int, rng: Generator) -> Array:
    force, scale = rows.force[:, leg], rng.uniform(10.0, 120.0)
    found = np.zeros(len(force))
    for row in range(len(force)):
        before, past = 0.0, 0.0
        for earlier in range(rows.first[row], row + 1):
            since = rows.time[row] - rows.time[earlier]
            past += (force[earlier] - before) * np.log1p(since / scale)
            before = force[earlier]
        found[row] = past
    return found


def _wear_with_time(rows: Rows, leg: int, rng: Generator) -> Array:
    share = rows.time / rows.time[-1]
    when, width = rng.uniform(0.3, 0.7), rng.uniform(0.05, 0.25)
    return np.asarray(rows.force[:, leg] / (1.0 + np.exp(-(share - when) / width)))


def _motor_warms(rows: Rows, leg: int, rng: Generator) -> Array:
    lag = rng.uniform(0.3, 1.5) * float(rows.elapsed.max())
    return np.asarray(rows.length[:, leg] * (1.0 - np.exp(-rows.elapsed / lag)))


def _softer_when_warm(rows: Rows, leg: int, rng: Generator) -> Array:
    return np.asarray(rows.force[:, leg] * rows.warming)


def _axes(rows: Rows, rng: Generator, wrench: Array) -> Array:
    """Wrench components weighted alike, N × n, each scaled to 1, with twists of comparable effect."""
    lever = np.array([1.0] * rows.d + [0.6 * rows.reach] * (wrench.shape[1] - rows.d))
    return np.asarray(wrench / lever / max(float(np.abs(wrench / lever).max()), 1e-300))


def _twisted(values: Array, rows: Rows) -> Array:
    lever = np.array([1.0] * rows.d + [0.6 * rows.reach] * (values.shape[1] - rows.d))
    return np.asarray(values / lever)


def _lifting_plate(rows: Rows, rng: Generator) -> tuple[tuple[str, ...], Array]:
    wrench = _axes(rows, rng, rows.carried)
    normal = rng.normal(size=wrench.shape[1])
    through = wrench @ normal
    opened = np.maximum(through - rng.uniform(0.1, 0.5) * through.std(), 0.0)
    return ("platform", "payload"), rows.platform(_twisted(opened[:, None] * rng.normal(size=wrench.shape[1]), rows))


def _bent_plate(rows: Rows, rng: Generator) -> tuple[tuple[str, ...], Array]:
    wrench = _axes(rows, rng, rows.carried)
    yielded = wrench * np.abs(wrench) ** rng.uniform(0.5, 1.0) * rng.uniform(0.3, 1.0, wrench.shape[1])
    return ("platform", "payload"), rows.platform(_twisted(yielded, rows))


def _slipping_clamp(rows: Rows, rng: Generator) -> tuple[tuple[str, ...], Array]:
    wrench, width = _axes(rows, rng, rows.carried), rng.uniform(0.1, 0.4)
    slipped = rows.remembered(wrench, lambda s, c, row: np.asarray(np.clip(s + c, -width, width)))
    return ("platform", "payload"), rows.platform(_twisted(slipped, rows))


def _soft_soil(rows: Rows, rng: Generator) -> tuple[tuple[str, ...], Array]:
    wrench = _axes(rows, rng, rows.ground)
    yielded = np.tanh(wrench / rng.uniform(0.2, 0.6)) * rng.uniform(0.3, 1.0, wrench.shape[1])
    return ("base",), rows.base(_twisted(yielded, rows))


def _loose_anchor(rows: Rows, rng: Generator) -> tuple[tuple[str, ...], Array]:
    wrench = _axes(rows, rng, rows.ground)
    angle = rng.uniform(0.0, 2.0 * np.pi)
    moment = wrench[:, 3] * np.cos(angle) + wrench[:, 4] * np.sin(angle)
    opened = np.maximum(moment - rng.uniform(0.0, 0.3) * np.abs(moment).max(), 0.0)
    twist = np.zeros_like(wrench)
    twist[:, 3], twist[:, 4] = opened * np.cos(angle), opened * np.sin(angle)
    return ("base",), rows.base(_twisted(twist, rows))


def _creeping_ground(rows: Rows, rng: Generator) -> tuple[tuple[str, ...], Array]:
    wrench, lag = _axes(rows, rng, rows.ground), rng.uniform(60.0, 600.0)
    steps = np.diff(rows.time, prepend=rows.time[0])

    def step(state: Array, change: Array, row: int) -> Array:
        return np.asarray(state + (wrench[row] - change - state) * (1.0 - np.exp(-steps[row] / lag)))

    return ("base",), rows.base(_twisted(rows.remembered(wrench, step) * rng.uniform(0.3, 1.0, 6), rows))


def _walking_floor(rows: Rows, rng: Generator) -> tuple[tuple[str, ...], Array]:
    phase, turns = rng.uniform(0.0, 6.0), rng.uniform(1.0, 3.0)
    moved = np.sin(2.0 * np.pi * turns * rows.time / rows.time[-1] + phase)
    twist = (moved - moved[rows.first])[:, None] * rng.normal(size=rows.wrench.shape[1])
    return ("base", "environment"), rows.base(_twisted(twist, rows))


def _hanging_cable(rows: Rows, rng: Generator) -> tuple[tuple[str, ...], Array]:
    anchor = rows.position.mean(axis=0) + rng.uniform(0.3, 1.0) * rows.reach * 2.0 * _unit(rng, rows.d)
    away = anchor - rows.position
    far = np.linalg.norm(away, axis=1)
    pull = np.maximum(far - rng.uniform(0.0, 0.9) * far.min(), 0.0) ** rng.uniform(1.0, 2.0)
    return _pushed(rows, away / far[:, None] * pull[:, None])


def _rubber_stop(rows: Rows, rng: Generator) -> tuple[tuple[str, ...], Array]:
    normal = _unit(rng, rows.d)
    depth = rows.position @ normal
    pressed = np.maximum(depth - np.quantile(depth, rng.uniform(0.2, 0.6)), 0.0)
    return _pushed(rows, pressed[:, None] ** rng.uniform(1.0, 1.6) * -normal)


def _hose_that_sags(rows: Rows, rng: Generator) -> tuple[tuple[str, ...], Array]:
    along = _unit(rng, rows.d)
    way = _scaled((rows.position - rows.position.mean(axis=0)) @ along)
    down = np.zeros(rows.d)
    down[-1] = -1.0
    return _pushed(rows, (1.0 + way + 0.7 * way**2)[:, None] * (0.4 * along + down))


def _swinging_payload(rows: Rows, rng: Generator) -> tuple[tuple[str, ...], Array]:
    shift = rng.normal(size=(3, 3)) * np.array([1.0, 1.0, 0.3])
    tilt = rows.turn[:, 2, :] - np.array([0.0, 0.0, 1.0])
    lever = np.einsum("rij,rj->ri", rows.turn, tilt @ shift.T)
    wrench = np.zeros_like(rows.wrench)
    wrench[:, 3:] = np.cross(lever, rows.wrench[:, :3])
    return ("payload",), rows.load(wrench)


def _draught(rows: Rows, rng: Generator) -> tuple[tuple[str, ...], Array]:
    turns, phase = rng.uniform(2.0, 6.0), rng.uniform(0.0, 6.0)
    gust = np.sin(2.0 * np.pi * turns * rows.time / rows.time[-1] + phase)
    wrench = np.zeros_like(rows.wrench)
    wrench[:, : rows.d] = (gust - gust[rows.first])[:, None] * _unit(rng, rows.d)
    return ("environment",), rows.load(wrench)


def _pushed(rows: Rows, force: Array) -> tuple[tuple[str, ...], Array]:
    wrench = np.zeros_like(rows.wrench)
    wrench[:, : rows.d] = np.where(rows.loaded[:, None], force, 0.0)
    return ("environment", "payload", "platform"), rows.load(wrench)


def _unit(rng: Generator, size: int) -> Array:
    drawn = rng.normal(size=size)
    return np.asarray(drawn / np.linalg.norm(drawn))


def _of_reading(
    law: Callable[[Rows, Array, Generator], Array],
) -> Callable[[Rows, Generator], tuple[tuple[str, ...], Array]]:
    """A change of the reading that depends on what is read."""

    def make(rows: Rows, rng: Generator) -> tuple[tuple[str, ...], Array]:
        scale = np.abs(rows.own).max(axis=0)
        return ("instrument",), law(rows, rows.own / scale, rng) * scale

    return make


def _saturating(rows: Rows, read: Array, rng: Generator) -> Array:
    return np.asarray(read * np.abs(read) * rng.uniform(0.3, 1.0, read.shape[1]) * rng.choice([-1, 1], read.shape[1]))


def _dead_zone(rows: Rows, read: Array, rng: Generator) -> Array:
    axis = int(rng.integers(rows.d))
    found = np.zeros_like(read)
    width = rng.uniform(0.1, 0.4) * np.abs(read[:, axis]).max()
    found[:, axis] = -np.clip(read[:, axis], -width, width)
    return found


def _cross_talk(rows: Rows, read: Array, rng: Generator) -> Array:
    to, fro = rng.choice(read.shape[1], 2, replace=False)
    found = np.zeros_like(read)
    found[:, to] = read[:, fro] * (1.0 + rng.uniform(0.5, 2.0) * read[:, fro])
    return found


def _scale_of_place(rows: Rows, read: Array, rng: Generator) -> Array:
    way = _scaled((rows.position - rows.position.mean(axis=0)) @ _unit(rng, rows.d))
    return np.asarray(read * (way + way**2)[:, None])


def _scale_of_heat(rows: Rows, read: Array, rng: Generator) -> Array:
    return np.asarray(
        np.sign(rng.normal(size=read.shape[1])) * rows.warming[:, None] * rng.uniform(0.3, 1, read.shape[1])
    )


def _wandering_zero(rows: Rows, read: Array, rng: Generator) -> Array:
    turns = rng.uniform(1.0, 5.0, read.shape[1])
    wave = np.sin(2.0 * np.pi * rows.time[:, None] / rows.time[-1] * turns + rng.uniform(0.0, 6.0, read.shape[1]))
    return np.asarray(wave - wave[rows.first])


def _also(
    make: Callable[[Rows, Generator], tuple[tuple[str, ...], Array]], *more: str
) -> Callable[[Rows, Generator], tuple[tuple[str, ...], Array]]:
    def with_more(rows: Rows, rng: Generator) -> tuple[tuple[str, ...], Array]:
        components, change = make(rows, rng)
        return (*components, *more), change

    return with_more


_FORCE = ("leg_nonlinear_stiffness", "leg_backlash")
_PLACE = ("passive_joint_compliance", "joint_position_error")
KINDS = (
    Kind("worn in the middle", Wishes(wide=True), _of_leg(_worn_in_the_middle)),
    Kind("longer is softer", Wishes(wide=True), _of_leg(_longer_is_softer), _PLACE),
    Kind("all longer softer", Wishes(wide=True), _of_all(_longer_is_softer)),
    Kind("preloaded bearing", Wishes(reversals=True), _of_leg(_preloaded_bearing), _FORCE),
    Kind("hertz contact", Wishes(reversals=True), _of_leg(_hertz), _FORCE),
    Kind("all hertz contacts", Wishes(reversals=True), _of_all(_hertz), _FORCE),
    Kind("soft then stiff", Wishes(reversals=True), _of_leg(_soft_then_stiff), _FORCE),
    Kind("hardening", Wishes(reversals=True), _of_leg(_hardening), _FORCE),
    Kind("bouc-wen", Wishes(path="stairs", reversals=True), _of_leg(_bouc_wen), ("friction_hysteresis",)),
    Kind("all bouc-wen", Wishes(path="stairs", reversals=True), _of_all(_bouc_wen), ("friction_hysteresis",)),
    Kind("logarithmic creep", Wishes(path="hold", time=True), _of_leg(_logarithmic_creep), ("creep",)),
    Kind("wear with time", Wishes(time=True), _of_leg(_wear_with_time)),
    Kind("motor warms", Wishes(time=True), _of_leg(_motor_warms), ("thermal_drift",)),
    Kind("all motors warm", Wishes(time=True), _of_all(_motor_warms), ("thermal_drift",)),
    Kind("softer when warm", Wishes(temperature=True), _of_leg(_softer_when_warm)),
    Kind("lifting plate", Wishes(), _lifting_plate, (), False),
    Kind("bent plate", Wishes(), _bent_plate, (), False),
    Kind("slipping clamp", Wishes(path="stairs"), _slipping_clamp, (), False),
    Kind("soft soil", Wishes(), _soft_soil, (), False),
    Kind("loose anchor", Wishes(), _loose_anchor, (), False),
    Kind("creeping ground", Wishes(path="hold", time=True), _creeping_ground, (), False),
    Kind("walking floor", Wishes(time=True), _walking_floor, (), False),
    Kind("hanging cable", Wishes(wide=True), _hanging_cable),
    Kind("rubber stop", Wishes(wide=True), _rubber_stop),
    Kind("sagging hose", Wishes(wide=True), _hose_that_sags),
    Kind("swinging payload", Wishes(load="payload", wide=True), _swinging_payload, (), False),
    Kind("draught", Wishes(time=True), _draught),
    Kind("saturating gauge", Wishes(), _of_reading(_saturating)),
    Kind("dead zone", Wishes(), _of_reading(_dead_zone)),
    Kind("cross talk", Wishes(), _of_reading(_cross_talk), ("instrument_misalignment",), False),
    Kind("scale of place", Wishes(wide=True), _of_reading(_scale_of_place), ("instrument_scale",)),
    Kind(
        "zero of heat", Wishes(temperature=True), _also(_of_reading(_scale_of_heat), "environment"), ("thermal_drift",)
    ),
    Kind("wandering zero", Wishes(time=True), _also(_of_reading(_wandering_zero), "environment"), ("thermal_drift",)),
)

"""Every identifier that a bipod or a hexapod can have, as somebody else would simulate it (see `foreign.py`)."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pandas as pd

from tests.diagnosis.foreign import (
    Array,
    Machine,
    Physics,
    bipod,
    centre_of,
    experiment,
    hexapod,
    pose_names,
    reading_names,
    rotation,
    wrench_of,
)
from tests.oracle import skew

UP_DOWN = (0.0, 0.5, 1.0, 0.5)
STAIRS = (0.0, 0.3, 0.6, 1.0, 0.6, 0.3)
BOTH_WAYS = (0.0, 0.6, 1.0, -0.6, -1.0)
HOLD = (0.0, 1.0, 1.0, 1.0, 1.0, 0.0)


@dataclass(frozen=True)
class Case:
    """What is done, what is there, and what has to be found: physics, one of the components, parameters."""

    name: str
    physics: str
    components: tuple[str, ...]
    make: Callable[[Machine], Physics]
    planar: bool = False
    truth: dict[str, float] = field(default_factory=dict)
    load: str = "payload"
    path: tuple[float, ...] = UP_DOWN
    series: int = 16
    size: float = 1.0
    reach: float = 1.0
    softness: float = 1.0
    noise: float = 1.0
    change: Callable[[pd.DataFrame], pd.DataFrame] = lambda rows: rows

    @property
    def machine(self) -> Machine:
        """The robot."""
        return bipod(self.softness) if self.planar else hexapod(self.softness)

    @property
    def rows(self) -> pd.DataFrame:
        """The experiment."""
        drawn = experiment(self.machine, self.load, self.series, self.path, self.size, self.reach, seed=5)
        return self.change(drawn)


def on_leg(leg: int, law: Callable[[Array, Array], Array]) -> Callable[..., Array]:
    """A leg's own elongation as a function of its force and its linear elongation."""

    def legs(row: pd.Series, force: Array, stretch: Array, memory: dict[str, Any]) -> Array:
        changed = stretch.copy()
        changed[leg] = law(force, stretch)[leg]
        return changed

    return legs


def everywhere(law: Callable[[Array, Array], Array]) -> Callable[..., Array]:
    """Likewise for all legs."""
    return lambda row, force, stretch, memory: law(force, stretch)


def longer(
    legs_: Sequence[int], by: Callable[[Machine, pd.Series, Array, dict[str, Any]], Array | float]
) -> Callable[[Machine], Physics]:
    """Some legs are longer by what machine, row, forces and memory say."""

    def make(machine: Machine) -> Physics:
        def legs(row: pd.Series, force: Array, stretch: Array, memory: dict[str, Any]) -> Array:
            changed, extra = stretch.copy(), np.broadcast_to(by(machine, row, force, memory), stretch.shape)
            changed[list(legs_)] += extra[list(legs_)]
            return changed

        return Physics(legs=legs)

    return make


# --- the load -----------------------------------------------------------------------------------------------------


def centre_off(machine: Machine) -> Physics:
    offset = np.array([0.006, -0.004, 0.003])

    def load(row: pd.Series, wrench: Array) -> Array:
        turn = rotation(row[["rx_rad", "ry_rad", "rz_rad"]].to_numpy(dtype=float))
        return np.concatenate([wrench[:3], wrench[3:] + np.cross(turn @ offset, wrench[:3])])

    return Physics(load=load)


def as_wrench(rows: pd.DataFrame) -> pd.DataFrame:
    """The same loads written down as wrenches."""
    machine = hexapod()
    wrenches = np.array([wrench_of(machine, row) for _, row in rows.iterrows()])
    bare = rows.drop(columns=["mass_kg", "com_x_m", "com_y_m", "com_z_m"])
    bare[["fx_N", "fy_N", "fz_N", "mx_Nm", "my_Nm", "mz_Nm"]] = wrenches
    return bare


def heavier(share: float, when: Callable[[float], bool]) -> Callable[[Machine], Physics]:
    """Loads of some masses are heavier by a share."""

    def make(machine: Machine) -> Physics:
        return Physics(load=lambda row, wrench: wrench * (1.0 + share * when(row["mass_kg"])))

    return make


def added(mass: float, when: Callable[[float], bool]) -> Callable[[Machine], Physics]:
    """A mass is added to some loads, at the same place."""

    def make(machine: Machine) -> Physics:
        def load(row: pd.Series, wrench: Array) -> Array:
            return wrench * (1.0 + (mass / row["mass_kg"] if when(row["mass_kg"]) else 0.0))

        return Physics(load=load)

    return make


def tilted(machine: Machine) -> Physics:
    """Gravity is 12 mrad off the vertical."""
    if machine.planar:
        c, s = np.cos(0.012), np.sin(0.012)
        return Physics(load=lambda row, wrench: np.array([[c, -s], [s, c]]) @ wrench)
    turn = rotation(np.array([0.012, -0.008, 0.0]))

    def load(row: pd.Series, wrench: Array) -> Array:
        if "mass_kg" not in row.index:
            return np.concatenate([turn @ wrench[:3], turn @ wrench[3:]])
        arm = rotation(row[["rx_rad", "ry_rad", "rz_rad"]].to_numpy(dtype=float)) @ centre_of(row)
        force = turn @ wrench[:3]
        return np.concatenate([force, np.cross(arm, force)])

    return Physics(load=load)


# --- the structure ------------------------------------------------------------------------------------------------


def soft_platform(machine: Machine) -> Physics:
    if machine.planar:
        return Physics(platform=lambda pose, wrench: np.diag([4e-8, 1e-8]) @ wrench)
    compliance = np.diag([3e-8, 3e-8, 2e-8, 2e-6, 1e-6, 1e-6])

    def platform(pose: Array, wrench: Array) -> Array:
        turn = np.kron(np.eye(2), rotation(pose[3:]))
        moved: Array = turn @ compliance @ turn.T @ wrench
        return moved

    return Physics(platform=platform)


def soft_base(machine: Machine) -> Physics:
    if machine.planar:
        return Physics(platform=lambda pose, wrench: np.diag([4e-8, 1e-8]) @ wrench)
    compliance = np.diag([2e-8, 2e-8, 1e-8, 4e-7, 3e-7, 3e-7])

    def platform(pose: Array, wrench: Array) -> Array:
        position = machine.home + pose[:3]
        at_base = compliance @ np.concatenate([wrench[:3], wrench[3:] + np.cross(position, wrench[:3])])
        return np.concatenate([at_base[:3] + np.cross(at_base[3:], position), at_base[3:]])

    return Physics(platform=platform)


def soft_joint(leg: int, end: str) -> Callable[[Machine], Physics]:
    """A joint that is soft along x of the frame it stands in."""

    def by(machine: Machine, row: pd.Series, force: Array, memory: dict[str, Any]) -> float:
        compliance = np.diag([3e-7, 2e-8, 2e-8][: len(machine.home)]) * (0.5 if machine.planar else 1.0)
        pose = row[pose_names(machine)].to_numpy(dtype=float)
        vector = machine.vectors(pose)[0][leg]
        u = vector / np.linalg.norm(vector)
        if end == "platform":
            u = rotation(pose[3:]).T @ u
        return float(force[leg] * (u @ compliance @ u))

    return longer((leg,), by)


def stiff_joints(both: bool, spin: bool) -> Callable[[Machine], Physics]:
    """Joints of all legs resist bending (and twisting) with 2000 N·m/rad, at one or at both ends."""

    def make(machine: Machine) -> Physics:
        stiffness = 4e5 if machine.planar else 2000.0

        def matrix(pose: Array, force: Array) -> Array:
            vectors, arms = machine.vectors(pose)
            total = np.zeros((len(machine.rates(pose)),) * 2)
            for vector, arm in zip(vectors, arms, strict=True):
                length = float(np.linalg.norm(vector))
                u = vector / length
                if machine.planar:
                    turning = np.array([[-u[1], u[0]]]) / length
                    total += stiffness * turning.T @ turning
                    continue
                leg_turn = skew(u) @ np.hstack([np.eye(3), -skew(arm)]) / length
                spinning = np.hstack([np.zeros((3, 3)), np.eye(3)])
                total += stiffness * leg_turn.T @ leg_turn
                if both:
                    relative = spinning - leg_turn
                    if not spin:
                        relative = (np.eye(3) - np.outer(u, u)) @ relative
                    total += stiffness * relative.T @ relative
            return total

        return Physics(stiffness=matrix)

    return make


def moved_joint(leg: int, end: str) -> Callable[[Machine], Physics]:
    def make(machine: Machine) -> Physics:
        offset = np.array([0.02, -0.015] if machine.planar else [0.006, -0.0045, 0.003])
        base, platform = machine.base.copy(), machine.platform.copy()
        (base if end == "base" else platform)[leg] += offset
        return Physics(geometry=replace(machine, base=base, platform=platform))

    return make


def mapping(machine: Machine) -> Physics:
    """(K_C + K_G)·ΔX = ΔF with K_G by differences of the wrench at constant leg forces."""

    def geometric(pose: Array, force: Array) -> Array:
        rates, step = machine.rates(pose), 1e-6
        columns = []
        for twist in np.eye(len(rates)):
            ahead = machine.inverse_jacobian(pose + step * rates @ twist).T @ force
            behind = machine.inverse_jacobian(pose - step * rates @ twist).T @ force
            columns.append((ahead - behind) / (2.0 * step))
        return np.array(columns).T

    return Physics(stiffness=geometric)


# --- the legs -----------------------------------------------------------------------------------------------------


def play(leg: int, gap: float, rest: str, width: float = 0.0) -> Callable[[Machine], Physics]:
    """A jump where the force changes sign; over a width of some newtons if given."""
    ends = {"middle": (0.5, -0.5), "short": (1.0, 0.0), "long": (0.0, -1.0)}[rest]

    def law(force: Array, stretch: Array) -> Array:
        side = np.tanh(force / width) if width else np.sign(np.where(np.abs(force) < 1e-6, 0.0, force))
        place = np.where(side > 0, ends[0] * side, -ends[1] * side)
        return np.asarray(stretch + gap * place)

    return lambda machine: Physics(legs=on_leg(leg, law))


def lag(legs_: tuple[int, ...], friction: float) -> Callable[[Machine], Physics]:
    """The force that reaches the spring lags behind by the friction, against the sense of its last change."""

    def by(machine: Machine, row: pd.Series, force: Array, memory: dict[str, Any]) -> Array:
        nothing = np.zeros_like(force)
        change = force - memory.get("force", nothing)
        sense = np.where(np.abs(change) < 1e-9, memory.get("sense", nothing), np.sign(change))
        memory["force"], memory["sense"] = force, sense
        return np.asarray(-sense * friction / machine.stiffness)

    return longer(legs_, by)


def jenkins(legs_: tuple[int, ...], friction: float, ratio: float) -> Callable[[Machine], Physics]:
    """A slider behind a spring of `ratio` times the leg's stiffness, beside the leg, stepped finely."""

    def make(machine: Machine) -> Physics:
        def legs(row: pd.Series, force: Array, stretch: Array, memory: dict[str, Any]) -> Array:
            start, slider = memory.get("force", np.zeros_like(force)), memory.get("slider", np.zeros_like(force))
            slider, changed = slider.copy(), stretch.copy()
            for leg in legs_:
                k, elongation = machine.stiffness[leg], 0.0
                for applied in np.linspace(start[leg], force[leg], 200):
                    elongation = (applied + ratio * k * slider[leg]) / (k * (1.0 + ratio))
                    held = ratio * k * (elongation - slider[leg])
                    if abs(held) > friction:
                        elongation = (applied - np.sign(held) * friction) / k
                        slider[leg] = elongation - np.sign(held) * friction / (ratio * k)
                changed[leg] = elongation
            memory["force"], memory["slider"] = force, slider
            return changed

        return Physics(legs=legs)

    return make


def creeping(legs_: tuple[int, ...], ratio: float, tau: float, late: bool) -> Callable[[Machine], Physics]:
    """Each step of the force creeps on its own from when it was applied: at the row before, or half-way."""

    def by(machine: Machine, row: pd.Series, force: Array, memory: dict[str, Any]) -> Array:
        steps, before = memory.setdefault("steps", []), memory.get("force", np.zeros_like(force))
        then = memory.get("time", row["time_s"])
        steps.append((0.5 * (then + row["time_s"]) if late else then, force - before))
        memory["force"], memory["time"] = force, row["time_s"]
        crept = np.sum([s * (1.0 - np.exp(-(row["time_s"] - t) / tau)) for t, s in steps], axis=0)
        return np.asarray(ratio * crept / machine.stiffness)

    return longer(legs_, by)


def warm(legs_: tuple[int, ...], alpha: float, sensors: bool = False) -> Callable[[Machine], Physics]:
    def by(machine: Machine, row: pd.Series, force: Array, memory: dict[str, Any]) -> Array:
        columns = [f"leg{i + 1}_degC" if sensors else "temperature_degC" for i in range(len(force))]
        now = row[columns].to_numpy(dtype=float)
        lengths = machine.lengths(row[pose_names(machine)].to_numpy(dtype=float))
        return np.asarray(alpha * lengths * (now - memory.setdefault("first", now)))

    return longer(legs_, by)


def with_sensors(rows: pd.DataFrame) -> pd.DataFrame:
    generator = np.random.default_rng(8)
    own = 0.4 * generator.standard_normal((len(rows), 6))
    return rows.assign(**{f"leg{i + 1}_degC": rows["temperature_degC"] + own[:, i] for i in range(6)})


def drifting(column: str, rate: Array) -> Callable[[Machine], Physics]:
    """The instrument's reading follows time or temperature."""

    def make(machine: Machine) -> Physics:
        def after(rows: pd.DataFrame, readings: Array) -> Array:
            first = rows.groupby("series")[column].transform("first")
            return np.asarray(readings + np.outer(rows[column] - first, rate[: readings.shape[1]]))

        return Physics(after=after)

    return make


def coupled(leg: int, other: int, both: bool) -> Callable[[Machine], Physics]:
    def by(machine: Machine, row: pd.Series, force: Array, memory: dict[str, Any]) -> Array:
        exchanged = force.copy()
        exchanged[[leg, other]] = force[[other, leg]]
        return 4e-8 * exchanged

    return longer((leg, other) if both else (leg,), by)


def screw(leg: int, amplitude: float, pitch: float, phase: float) -> Callable[[Machine], Physics]:
    def by(machine: Machine, row: pd.Series, force: Array, memory: dict[str, Any]) -> Array:
        lengths = machine.lengths(row[pose_names(machine)].to_numpy(dtype=float))
        return np.asarray(amplitude * np.sin(2.0 * np.pi * lengths / pitch + phase))

    return longer((leg,), by)


# --- the instrument -----------------------------------------------------------------------------------------------


def misaligned(angles: tuple[float, float, float]) -> Callable[[Machine], Physics]:
    """Differences of positions and of angles are seen in turned axes."""

    def make(machine: Machine) -> Physics:
        turn = rotation(np.array(angles))
        if machine.planar:
            return Physics(reading=lambda row, d: turn[:2, :2].T @ d)
        return Physics(reading=lambda row, d: np.concatenate([turn.T @ d[:3], turn.T @ d[3:]]))

    return make


def scaled(factors: Array) -> Callable[[Machine], Physics]:
    return lambda machine: Physics(reading=lambda row, d: d * (1.0 + factors[: len(d)]))


def blunders(rows_: tuple[int, ...], size: float) -> Callable[[Machine], Physics]:
    """One component of some rows is off."""

    def make(machine: Machine) -> Physics:
        def after(rows: pd.DataFrame, readings: Array) -> Array:
            spoilt = readings.copy()
            for index, row in enumerate(rows_):
                spoilt[row, index % 2] += size * (-1) ** index
            return spoilt

        return Physics(after=after)

    return make


def only(*axes: str) -> Callable[[pd.DataFrame], pd.DataFrame]:
    """Recordings in which nothing else was measured."""

    def drop(frame: pd.DataFrame) -> pd.DataFrame:
        names = [n for n in reading_names(hexapod()) if n not in axes and n in frame]
        return frame.drop(columns=[*names, *("s" + n[1:] for n in names)])

    return drop


LEG4, ALL = ("leg 4",), ("all legs",)
CASES = [
    Case("com", "payload_com_offset", ("payload",), centre_off, noise=0.5,
         truth={"com_dx_m": 0.006, "com_dy_m": -0.004, "com_dz_m": 0.003}),
    Case("com, wrench", "payload_com_offset", ("payload",), centre_off, change=as_wrench, noise=0.5,
         truth={"com_dx_m": 0.006, "com_dy_m": -0.004}),
    Case("one weight of three", "payload_mass_error", ("payload",), heavier(0.04, lambda m: 12 < m < 14), noise=0.5,
         path=(0.0, 0.2, 0.5, 1.0), truth={"relative_mass_error": 0.04}),
    Case("forgotten adapter", "payload_mass_error", ("payload",), added(0.4, lambda m: m > 0), noise=0.3),
    Case("one disc of a stack", "payload_mass_error", ("payload",), added(-0.5, lambda m: m > 12),
         path=(0.0, 0.25, 0.5, 0.75, 1.0), noise=0.3),
    Case("one weight", "payload_mass_error", ("payload",), heavier(-0.03, lambda m: 40 < m < 60), True,
         path=(0.0, 0.2, 0.5, 1.0), truth={"relative_mass_error": -0.03}),
    Case("tilt", "load_direction_tilt", ("payload", "environment"), tilted, noise=0.5,
         truth={"tilt_x_rad": 0.012, "tilt_y_rad": -0.008}),
    Case("tilt, wrench", "load_direction_tilt", ("payload", "environment"), tilted, load="wrench", noise=0.5,
         truth={"tilt_x_rad": 0.012, "tilt_y_rad": -0.008}),
    Case("tilt", "load_direction_tilt", ("payload", "environment"), tilted, True, load="wrench"),
    Case("platform", "platform_compliance", ("platform",), soft_platform, load="wrench",
         truth={"compliance_rx_rx_rad_per_Nm": 2e-6}),
    Case("platform, payload", "platform_compliance", ("platform",), soft_platform, size=2.0),
    Case("platform", "platform_compliance", ("platform", "base"), soft_platform, True, load="wrench"),
    Case("base", "base_compliance", ("base",), soft_base, load="wrench",
         truth={"compliance_rx_rx_rad_per_Nm": 4e-7}),
    Case("base", "base_compliance", ("platform", "base"), soft_base, True, load="wrench"),
    Case("base joint", "passive_joint_compliance", LEG4, soft_joint(3, "base"), size=2.0, reach=1.6),
    Case("platform joint", "passive_joint_compliance", LEG4, soft_joint(3, "platform"), size=2.0, reach=1.6),
    Case("base joint", "passive_joint_compliance", ("leg 2",), soft_joint(1, "base"), True, load="wrench"),
    Case("flexures", "passive_joint_stiffness", ALL, stiff_joints(True, False), size=2.0, noise=0.5,
         truth={"joint_Nm_per_rad": 2000.0}),
    Case("flexures that resist twisting", "passive_joint_stiffness", ALL, stiff_joints(True, True), size=2.0,
         noise=0.5),
    Case("flexures at one end", "passive_joint_stiffness", ALL, stiff_joints(False, False), size=2.0, noise=0.2),
    Case("flexures", "passive_joint_stiffness", ALL, stiff_joints(False, False), True, load="wrench"),
    Case("hardening with the force", "leg_nonlinear_stiffness", LEG4,
         lambda m: Physics(legs=on_leg(3, lambda f, x: x / (1.0 + 0.4 * np.abs(f) / 300.0))), load="wrench"),
    Case("hardening in compression", "leg_nonlinear_stiffness", LEG4,
         lambda m: Physics(legs=on_leg(3, lambda f, x: x / (1.0 - 0.2 * f / 300.0))), load="wrench"),
    Case("contact of all legs", "leg_nonlinear_stiffness", ALL,
         lambda m: Physics(legs=everywhere(lambda f, x: x + 2e-7 * np.sign(f) * np.abs(f) ** (2 / 3)))),
    Case("softer in tension", "leg_nonlinear_stiffness", ("leg 1",),
         lambda m: Physics(legs=on_leg(0, lambda f, x: x * np.where(f > 0, 1.1, 1.0))), True, load="wrench"),
    Case("cubic softening", "leg_nonlinear_stiffness", ("leg 1",),
         lambda m: Physics(legs=on_leg(0, lambda f, x: x + 1e-5 * (f / 500.0) ** 3)), True, load="wrench"),
    *(Case(f"play, rests {rest}", "leg_backlash", LEG4, play(3, 5e-6, rest), load="wrench", path=BOTH_WAYS,
           truth={"gap_m": 5e-6}) for rest in ("middle", "short", "long")),
    Case("play with a soft edge", "leg_backlash", LEG4, play(3, 5e-6, "middle", 3.0), load="wrench", path=BOTH_WAYS),
    Case("play", "leg_backlash", ("leg 1",), play(0, 4e-6, "middle"), True, load="wrench", path=BOTH_WAYS,
         truth={"gap_m": 4e-6}),
    Case("friction of a leg", "friction_hysteresis", LEG4, lag((3,), 8.0), path=STAIRS, truth={"friction_N": 8.0}),
    Case("friction of all legs", "friction_hysteresis", ALL, lag(tuple(range(6)), 3.0), path=STAIRS, size=2.0),
    Case("slider behind a spring", "friction_hysteresis", LEG4, jenkins((3,), 15.0, 3.0), path=STAIRS, size=2.0),
    Case("friction", "friction_hysteresis", ("leg 2",), lag((1,), 25.0), True, path=STAIRS, load="wrench"),
    Case("creep", "creep", LEG4, creeping((3,), 0.15, 120.0, False), path=HOLD, noise=0.5,
         truth={"creep_ratio": 0.15, "tau_s": 120.0}),
    Case("creep, loads put on half-way", "creep", ALL, creeping(tuple(range(6)), 0.12, 60.0, True), path=HOLD),
    Case("creep", "creep", ("leg 2",), creeping((1,), 0.12, 120.0, False), True, path=HOLD),
    Case("warm leg", "thermal_drift", LEG4, warm((3,), 1.5e-5), truth={"alpha_per_K": 1.5e-5}),
    Case("warm legs with sensors", "thermal_drift", ALL, warm(tuple(range(6)), 1.2e-5, True), change=with_sensors,
         truth={"alpha_per_K": 1.2e-5}),
    Case("warm leg", "thermal_drift", ("leg 1",), warm((0,), 1.2e-5), True, truth={"alpha_per_K": 1.2e-5}),
    Case("drift of the reading with time", "thermal_drift", ("environment", "instrument"),
         drifting("time_s", np.array([0.0, 1e-8, 2e-8, 0.0, 0.0, 0.0]))),
    Case("drift of the reading with time", "thermal_drift", ("environment", "instrument"),
         drifting("time_s", np.array([1e-8, 1e-8])), True),
    Case("a force deflects another leg", "leg_coupling", ("leg 2", "leg 3"), coupled(1, 2, False)),
    Case("two legs on one mount", "leg_coupling", ("leg 2", "leg 3"), coupled(1, 2, True)),
    Case("a force deflects another leg", "leg_coupling", ("leg 1", "leg 2"), coupled(0, 1, False), True,
         load="wrench"),
    Case("stiffness mapping", "geometric_stiffness", ("geometry",), mapping, softness=60.0, size=2.0),
    Case("stiffness mapping", "geometric_stiffness", ("geometry",), mapping, True, load="wrench", softness=60.0),
    Case("base joint", "joint_position_error", LEG4, moved_joint(3, "base"), size=2.0, noise=0.4,
         truth={"joint_dx_m": 0.006, "joint_dy_m": -0.0045, "joint_dz_m": 0.003}),
    Case("platform joint", "joint_position_error", LEG4, moved_joint(3, "platform"), size=2.0, noise=0.4),
    Case("base joint", "joint_position_error", ("leg 2",), moved_joint(1, "base"), True, load="wrench"),
    Case("misaligned", "instrument_misalignment", ("instrument",), misaligned((0.01, -0.02, 0.015)), noise=0.4,
         truth={"rot_x_rad": 0.01, "rot_y_rad": -0.02, "rot_z_rad": 0.015}),
    Case("misaligned", "instrument_misalignment", ("instrument",), misaligned((0.0, 0.0, 0.02)), True, load="wrench",
         truth={"rot_z_rad": 0.02}),
    Case("scale of one axis", "instrument_scale", ("instrument",), scaled(np.array([0, 0, 0.03, 0, 0, 0])), size=2.0,
         truth={"scale_z": 0.03}),
    Case("scale of one axis", "instrument_scale", ("instrument",), scaled(np.array([0.03, 0.0])), True, load="wrench"),
    Case("screw", "encoder_periodic_error", LEG4, screw(3, 3e-6, 2e-3, 0.7), series=20,
         truth={"amplitude_m": 3e-6, "pitch_m": 2e-3}),
    Case("screw", "encoder_periodic_error", ("leg 1",), screw(0, 3e-6, 2e-3, 0.7), True, series=20,
         truth={"amplitude_m": 3e-6, "pitch_m": 2e-3}),
    Case("blunders", "outlier", ("instrument", "environment"), blunders((5, 22, 41), 2e-5)),
    Case("blunders", "outlier", ("instrument", "environment"), blunders((9, 30), 1e-5), True),
]  # fmt: skip

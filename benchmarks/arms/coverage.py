"""Whether intervals hold and predictions are as good as they can be: four arms with pinocchio as the machine.

    python -m benchmarks.arms.coverage [--experiments N] [--poses N] [--results FOLDER]

In every experiment zeros, frames and stiffnesses of an arm of the kind of a UR10, an IRB 120, a seven-axis arm or a
torso with two arms are drawn anew (1 mrad; 0.3 mm and 0.5 mrad; 20 %). Its joints yield under its links' weight. An
instrument at an unknown place reads markers at unknown places with 30 µm of noise, and `identify` fits geometry,
compliances, instrument and markers together from the drawing.

Stated are the share of 95 % intervals that hold the truth, of every parameter of the minimal set (the truth of those
that were dropped counts with the combination in which they stand), the share of held-out readings within their
intervals, and the RMS error of held-out positions without noise over that of the best estimator: the posterior mean
with the very distributions from which the arms were drawn, by Gauss-Newton with finite differences of pinocchio alone.
Partial results are kept.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pandas as pd
import pinocchio as pin
from tests.robots import torso
from tests.robots.test_trees import joint_text, link_text

import expdesign as xd
from expdesign.chain.row import row_data
from expdesign.estimation.arm import ArmCalibration
from expdesign.mechanics.robots.kinematic_tree import FRAME_AXES

Array = npt.NDArray[np.float64]
Whole = npt.NDArray[np.int64]
ZERO, LENGTH, ANGLE, SOFTNESS, NOISE = 1e-3, 3e-4, 5e-4, 0.2, 3e-5
NORMAL_95 = 1.959964
GRAVITY = np.array([0.0, 0.0, -9.80665])
STAND = pin.SE3(pin.rpy.rpyToMatrix(0.01, -0.02, 2.4), np.array([2.3, 1.6, 0.4]))
PLACES = np.array([[0.08, 0.02, 0.12], [-0.07, 0.09, 0.10], [0.01, -0.11, 0.15]])
_ITERATIONS, _TURNS, _STEP = 6, 3, 1e-6
_UNKNOWN = 1.0
"""m, rad; deviation of instrument and markers before anything is measured."""


@dataclass(frozen=True)
class Kind:
    """A kind of arm: its URDF, tips, joints' stiffness (N·m/rad) and ranges (rad)."""

    urdf: str
    base: str
    tips: tuple[str, ...]
    joints: tuple[str, ...]
    stiffness: Array
    low: Array
    high: Array


def _arm(rows: list[tuple[str, str, float, float]], flange: str, low: list[float], high: list[float]) -> Kind:
    """From origin, axis, mass and stiffness of every joint; the centre of mass lies halfway to the next joint."""
    ends = [*(row[0] for row in rows[1:]), flange]
    text = '<robot name="arm"><link name="base"/>'
    for number, ((origin, axis, mass, _), end) in enumerate(zip(rows, ends, strict=True), start=1):
        centre = " ".join(f"{0.5 * float(each):g}" for each in end.split())
        above = "base" if number == 1 else f"l{number - 1}"
        text += link_text(f"l{number}", mass, centre)
        text += joint_text(f"j{number}", above, f"l{number}", origin, axis)
    text += f'<link name="flange"/><joint name="end" type="fixed"><origin xyz="{flange}"/>'
    text += f'<parent link="l{len(rows)}"/><child link="flange"/></joint></robot>'
    names = tuple(f"j{number}" for number in range(1, len(rows) + 1))
    return Kind(text, "base", ("flange",), names, np.array([r[3] for r in rows]), np.array(low), np.array(high))


KINDS = {
    "UR10": _arm(
        [
            ("0 0 0.1273", "0 0 1", 7.778, 45000.0), ("0 0.220941 0", "0 1 0", 12.93, 45000.0),
            ("0.612 -0.1719 0", "0 1 0", 3.87, 22000.0), ("0.5723 0 0", "0 1 0", 1.96, 7000.0),
            ("0 0.1149 0", "0 0 -1", 1.96, 7000.0), ("0 0 -0.1157", "0 1 0", 0.202, 7000.0),
        ], "0 0.0922 0", [-2.5, -2.4, -2.0, -2.5, -2.5, -2.8], [2.5, -0.7, 2.0, 2.5, 2.5, 2.8],
    ),
    "IRB 120": _arm(
        [
            ("0 0 0.19", "0 0 1", 6.2, 20000.0), ("0 0 0.1", "0 1 0", 4.0, 20000.0),
            ("0 0 0.27", "0 1 0", 4.0, 12000.0),
            ("0.15 0 0.07", "1 0 0", 1.5, 4000.0), ("0.152 0 0", "0 1 0", 1.2, 4000.0),
            ("0.072 0 0", "1 0 0", 0.3, 3000.0),
        ], "0.02 0 0", [-2.6, -1.2, -1.2, -2.5, -1.8, -2.8], [2.6, 1.4, 0.9, 2.5, 1.8, 2.8],
    ),
    "seven axes": _arm(
        [
            ("0 0 0.1575", "0 0 1", 4.0, 12000.0), ("0 0 0.2025", "0 1 0", 4.0, 12000.0),
            ("0 0 0.2045", "0 0 1", 3.0, 10000.0), ("0 0 0.2155", "0 -1 0", 2.7, 10000.0),
            ("0 0 0.1845", "0 0 1", 1.7, 8000.0), ("0 0 0.2155", "0 1 0", 1.8, 6000.0),
            ("0 0 0.081", "0 0 1", 0.3, 6000.0),
        ], "0 0 0.045", [-2.5, -1.8, -2.5, -1.8, -2.5, -1.8, -2.5], [2.5, 1.8, 2.5, 1.8, 2.5, 1.8, 2.5],
    ),
    "two-armed torso": Kind(
        torso.URDF, "ground", torso.HANDS, torso.JOINTS, torso.STIFFNESS, np.full(8, -0.9), np.full(8, 0.9)
    ),
}  # fmt: skip


@dataclass(frozen=True)
class Truth:
    """What is not as drawn: zeros (n,), frames (n, 6), compliances over the drawn ones (n,), instrument and markers."""

    zeros: Array
    frames: Array
    softness: Array
    stand: pin.SE3
    places: Array

    def moved(self, by: Array) -> Truth:
        """Another truth, by a vector of zeros, frames, logarithms of compliances, instrument and places."""
        n = len(self.zeros)
        parts = np.split(by, np.cumsum([n, 6 * n, n, 6]))
        return Truth(
            self.zeros + parts[0], self.frames + parts[1].reshape(n, 6), self.softness * np.exp(parts[2]),
            self.stand * pin.SE3(pin.exp3(parts[3][3:]), parts[3][:3]), self.places + parts[4].reshape(-1, 3),
        )  # fmt: skip


class Machine:
    """An arm in pinocchio."""

    def __init__(self, kind: Kind) -> None:
        self.kind = kind
        model = pin.buildModelFromXML(kind.urdf)
        model.gravity.linear = GRAVITY
        self.model, self.data = model, model.createData()
        self.numbers = [model.getJointId(name) for name in kind.joints]
        self.columns = [model.joints[number].idx_q for number in self.numbers]
        self.drawn = [model.jointPlacements[number].copy() for number in self.numbers]
        self.frames = [model.getFrameId(tip, pin.FrameType.BODY) for tip in kind.tips]

    def readings(self, truth: Truth, commands: Array, tips: Whole) -> Array:
        """Positions of every marker of the tip at commands (N, n) in the instrument's axes, (N, markers, 3)."""
        for number, drawn, error in zip(self.numbers, self.drawn, truth.frames, strict=True):
            self.model.jointPlacements[number] = drawn * pin.SE3(pin.rpy.rpyToMatrix(error[3:]), error[:3])
        compliance, found = truth.softness / self.kind.stiffness, []
        for command, tip in zip(commands, tips, strict=True):
            standing, q = np.zeros(self.model.nq), np.zeros(self.model.nq)
            standing[self.columns] = command + truth.zeros
            q[:] = standing
            for _ in range(_ITERATIONS):
                torque = -pin.computeGeneralizedGravity(self.model, self.data, q)
                q[self.columns] = standing[self.columns] + compliance * torque[self.columns]
            pin.framesForwardKinematics(self.model, self.data, q)
            pose = truth.stand.actInv(self.data.oMf[self.frames[tip]])
            own = truth.places.reshape(len(self.frames), -1, 3)[tip]
            found.append(own @ pose.rotation.T + pose.translation)
        return np.array(found)


def best_estimate(machine: Machine, begin: Truth, commands: Array, tips: Whole, read: Array) -> Truth:
    """The posterior mean with the distributions that arms are drawn from, by Gauss-Newton."""
    n, markers = len(begin.zeros), begin.places.size
    spreads = np.concatenate(
        [np.full(n, ZERO), np.tile([LENGTH] * 3 + [ANGLE] * 3, n), np.full(n, SOFTNESS), np.full(6 + markers, _UNKNOWN)]
    )
    value = np.zeros(len(spreads))

    def residuals(at: Array) -> Array:
        left = (read - machine.readings(begin.moved(at), commands, tips)).ravel() / NOISE
        return np.concatenate([left, -at / spreads])

    left = residuals(value)
    for _ in range(_TURNS):
        slopes = np.array([(left - residuals(value + _STEP * one)) / _STEP for one in np.eye(len(spreads))]).T
        step = np.linalg.lstsq(slopes * spreads, left, rcond=None)[0] * spreads
        trial = residuals(value + step)
        if not trial @ trial < left @ left:
            break
        value, left = value + step, trial
    return begin.moved(value)


def table(kind: Kind, commands: Array, tips: Whole, read: Array, held: npt.NDArray[np.bool_]) -> pd.DataFrame:
    """Readings (N, markers, 3) as recordings, a row for each marker."""
    rows: list[dict[str, object]] = []
    for command, tip, markers, test in zip(commands, tips, read, held, strict=True):
        for number, position in enumerate(markers):
            row: dict[str, object] = {"sequence": len(rows) + 1, "series": len(rows) + 1}
            row["marker"] = f"{kind.tips[tip]} {number}"
            row |= {f"{name}_rad": value for name, value in zip(kind.joints, command, strict=True)}
            row |= dict(zip(("px_m", "py_m", "pz_m"), position, strict=True))
            row |= dict.fromkeys(("spx_m", "spy_m", "spz_m"), NOISE) | {"split": "test" if test else "train"}
            rows.append(row | ({"tip": kind.tips[tip]} if len(kind.tips) > 1 else {}))
    return pd.DataFrame(rows)


def true_values(kind: Kind, found: ArmCalibration, truth: Truth) -> Array:
    """Truth of every parameter of the minimal set, with the share of what was dropped in it."""
    chain = found.fit.chain
    tree = chain.robot.links.tree
    order = [kind.joints.index(each.joint) for each in tree.coordinates]
    frames = [truth.frames[kind.joints.index(e.name)] if e.name in kind.joints else np.zeros(6) for e in tree.ends]
    geometry = np.concatenate([truth.zeros[order], *(np.asarray(frame) for frame in frames)])
    assert len(FRAME_AXES) == 6
    names = [parameter.name for parameter in chain.parameters]
    values = np.zeros(len(names))
    values[: chain.compliances] = truth.softness[order]
    stand = np.concatenate([truth.stand.translation, pin.rpy.matrixToRpy(truth.stand.rotation)])
    places = {
        f"marker {tip} {number}": place
        for tip, own in zip(kind.tips, truth.places.reshape(len(kind.tips), -1, 3), strict=True)
        for number, place in enumerate(own)
    }
    for index in range(chain.compliances, chain.base):
        whose, _, axis = names[index].rpartition(" ")
        axis = axis.rpartition("_")[0]
        values[index] = stand[FRAME_AXES.index(axis)] if whose == "instrument" else places[whose]["xyz".index(axis)]
    for effect, part in zip(chain.effects, chain.slices, strict=True):
        values[part] = geometry[list(effect.indices)]  # type: ignore[attr-defined]
    minimal = found.minimal
    kept = values[minimal.kept] + minimal.combinations.T @ values[minimal.dropped]
    values[minimal.kept] = kept
    return values


def experiment(name: str, seed: int, poses: int) -> dict[str, float]:
    """One experiment: counts of intervals that hold, and errors of held-out positions (m)."""
    kind, random = KINDS[name], np.random.default_rng(seed)
    machine, n = Machine(kind), len(kind.joints)
    places = random.normal(0.0, 0.02, (3 * len(kind.tips), 3)) + np.tile(PLACES, (len(kind.tips), 1))
    begin = Truth(np.zeros(n), np.zeros((n, 6)), np.ones(n), STAND, places)
    sizes = np.concatenate([np.full(n, ZERO), np.tile([LENGTH] * 3 + [ANGLE] * 3, n), np.full(n, SOFTNESS)])
    sizes[n : n + 6] = 0.0  # where the first joint stands is where the instrument does
    truth = begin.moved(np.concatenate([sizes * random.standard_normal(len(sizes)), np.zeros(6 + places.size)]))
    held = np.arange(poses * 3 // 2) >= poses
    commands = random.uniform(kind.low, kind.high, (len(held), n))
    tips = np.arange(len(held)) % len(kind.tips)
    exact = machine.readings(truth, commands, tips)
    read = exact + NOISE * random.standard_normal(exact.shape)
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "arm.urdf").write_text(kind.urdf, encoding="utf-8")
        tip = kind.tips[0] if len(kind.tips) == 1 else list(kind.tips)
        robot = {"name": name, "kind": "serial", "urdf": f"{folder}/arm.urdf", "base_link": kind.base, "tip_link": tip}
        result = xd.identify(
            robot | {"actuator_stiffness": kind.stiffness.tolist()}, table(kind, commands, tips, read, held)
        ).result
    found = result.arm
    assert found is not None
    chain, fit, kept = found.fit.chain, found.fit, found.minimal.kept
    away = np.abs(fit.values - true_values(kind, found, truth))[kept]
    holds = away <= NORMAL_95 * np.sqrt(np.diag(fit.covariance)[kept])
    groups = {"compliances": kept < chain.compliances, "frames": kept < chain.base, "geometry": kept >= chain.base}
    groups["frames"] &= ~groups["compliances"]
    test = result.recordings.rows(result.recordings.test)
    predicted, slopes = chain.predict_with_sensitivities(row_data(test, chain.robot), fit.values)
    spread = np.sqrt(NOISE**2 + np.einsum("nap,pq,naq->na", slopes, fit.covariance, slopes))
    best = best_estimate(machine, begin, commands[~held], tips[~held], read[~held])
    ideal = machine.readings(best, commands[held], tips[held]) - exact[held]
    own = predicted - exact[held].reshape(-1, 3)
    return {
        **{f"{group} {what}": float(value) for group, mine in groups.items()
           for what, value in (("inside", holds[mine].sum()), ("of", mine.sum()))},
        "held out inside": float((np.abs(test.deflections - predicted) <= NORMAL_95 * spread).sum()),
        "held out of": float(predicted.size),
        "error": float(np.sqrt((own**2).sum(axis=1).mean())),
        "best error": float(np.sqrt((ideal**2).sum(axis=-1).mean())),
    }  # fmt: skip


def summary(done: list[dict[str, float]]) -> dict[str, object]:
    """Shares with standard errors over experiments, and the ratio of the errors."""
    frame = pd.DataFrame(done)
    figures: dict[str, object] = {"experiments": len(done)}
    for group in ("compliances", "frames", "geometry", "held out"):
        shares = frame[f"{group} inside"] / frame[f"{group} of"]
        whole = frame[f"{group} inside"].sum() / frame[f"{group} of"].sum()
        figures[group] = [round(float(whole), 4), round(float(shares.std() / np.sqrt(len(done))), 4)]
    ratio = np.sqrt((frame["error"] ** 2).mean() / (frame["best error"] ** 2).mean())
    noisy = np.sqrt(((frame["error"] ** 2).mean() + 3 * NOISE**2) / ((frame["best error"] ** 2).mean() + 3 * NOISE**2))
    figures |= {"error over best": round(float(ratio), 4), "with noise": round(float(noisy), 4)}
    return figures


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--experiments", type=int, default=100, help="of each kind")
    parser.add_argument("--poses", type=int, default=40, help="fitted; half as many are held out")
    parser.add_argument("--first", type=int, default=0, help="seed of the first one")
    parser.add_argument("--results", type=Path, default=Path("results/arms"))
    given = parser.parse_args()
    given.results.mkdir(parents=True, exist_ok=True)
    done: dict[str, list[dict[str, float]]] = {name: [] for name in KINDS}
    for seed in range(given.first, given.first + given.experiments):
        for name, list_of in done.items():
            list_of.append(experiment(name, seed, given.poses))
        figures = {name: summary(each) for name, each in done.items() if len(each) > 1}
        every = [each for list_of in done.values() for each in list_of]
        text = json.dumps({"poses": given.poses, **figures, "all": summary(every)}, indent=1)
        (given.results / "coverage.json").write_text(text + "\n", encoding="utf-8")
        print(seed, figures.get("UR10"), summary(every), flush=True)


if __name__ == "__main__":
    main()

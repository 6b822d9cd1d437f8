"""Whether U contains the error of an arm's tip, by what is known of the markers on it.

    python -m research.benchmarks.arm_tips [--arms N] [--first SEED] [--out FILE]

Simulated UR10e (`arms_positions/machine.py`, pinocchio) of which everything is wrong; the markers hang on a flange that
is off by as much as other frames are, so that no marker tells where it is. Eighty positions of every marker are read by
an instrument of unknown pose. `identify` writes a model file, `compensate` takes it to twenty poses of the flange in
the instrument's frame, away from singular ones, and the arm goes there.
"""

import argparse
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd
import pinocchio as pin
from scipy.spatial.transform import Rotation

import expdesign as xd
from expdesign.arrays import rms
from research.benchmarks.arms_positions.machine import ANGLE, KINDS, LENGTH, NOISE, Machine
from research.benchmarks.arms_positions.rows import ENDS

POSES, TARGETS = 80, 20
KNOWN = {
    "one marker, its place unknown": (1, False),
    "three markers, their places unknown": (3, False),
    "one marker, its place on the flange stated": (1, True),
    "three markers, their places stated": (3, True),
}
WELL = 20.0
"""Condition number below which a pose is far from singular ones."""
JOINTS = [f"q{k}_rad" for k in range(1, 7)]
POSE = ["x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad"]


def condition(machine: Machine, command: np.ndarray) -> float:
    """Of the flange's motions (m, rad) by those of the joints (rad) about a command (6,)."""
    one, *others = machine.tips(command + 1e-6 * np.vstack([np.zeros(6), np.eye(6)]))
    return float(np.linalg.cond([pin.log6(one.actInv(other)).vector * 1e6 for other in others]))


def arrived(seed: int, markers: int, known: bool, folder: Path) -> tuple[np.ndarray, np.ndarray]:
    """Errors of the flange at the commands, and U, shape (TARGETS, 6) each."""
    arm, random = KINDS["UR10e"], np.random.default_rng([seed, markers, 11])
    machine = Machine(arm, markers, random)
    error = random.standard_normal(6) * ([LENGTH] * 3 + [ANGLE] * 3)
    flange = pin.SE3(pin.rpy.rpyToMatrix(error[3:]), error[:3])  # the drawn flange to the real one
    commands = random.uniform(arm.low, arm.high, (POSES, 6))
    drawn = random.uniform(arm.low, arm.high, (10 * TARGETS, 6))
    there = drawn[[condition(machine, command) < WELL for command in drawn]][:TARGETS]
    exact = machine.readings(commands)
    read = (exact + NOISE * random.standard_normal(exact.shape)).reshape(-1, 3)
    file = folder / "arm.urdf"
    file.write_text(arm.urdf, encoding="utf-8")
    robot: dict[str, object] = {
        "name": "UR10e",
        "kind": "serial",
        "urdf": str(file),
        "base_link": ENDS[0],
        "tip_link": ENDS[1],
    }
    robot |= {"actuator_stiffness": arm.stiffness.tolist()}
    names = [f"m{number}" for number in range(markers)]
    if known:  # measured on the real flange
        places = [flange.actInv(place).tolist() for place in machine.places]
        robot |= {"markers": dict(zip(names, places, strict=True))}
    table = pd.DataFrame(np.repeat(commands, markers, axis=0), columns=JOINTS)
    table[["px_m", "py_m", "pz_m"]] = read
    table = table.assign(spx_m=NOISE, spy_m=NOISE, spz_m=NOISE, marker=np.tile(names, POSES))
    table = table.assign(sequence=range(1, 1 + len(table)), series=range(1, 1 + len(table)))
    wanted = [pose * flange for pose in machine.tips(there)]
    poses = [np.r_[pose.translation, Rotation.from_matrix(pose.rotation).as_euler("xyz")] for pose in wanted]
    targets = pd.DataFrame(np.hstack([poses, there]), columns=[*POSE, *JOINTS])
    targets = targets.assign(sequence=range(1, 1 + TARGETS), series=range(1, 1 + TARGETS))
    xd.identify(robot, table).save(folder / "identified", force=True)
    found = xd.compensate(folder / "identified" / "model.yaml", targets, frame="instrument").frame
    reached = [pose * flange for pose in machine.tips(found[JOINTS].to_numpy(dtype=float))]
    errors = [
        np.r_[one.translation - other.translation, Rotation.from_matrix(one.rotation @ other.rotation.T).as_rotvec()]
        for one, other in zip(reached, wanted, strict=True)
    ]
    return np.array(errors), found[[f"U_{name}" for name in POSE]].to_numpy(dtype=float)


def main() -> None:
    """A table, on standard output and in `--out`."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--arms", type=int, default=40)
    parser.add_argument("--first", type=int, default=0, help="seed of the first arm")
    parser.add_argument("--out", type=Path, default=Path("results/runs/arm-tips.csv"))
    given = parser.parse_args()
    rows = []
    with tempfile.TemporaryDirectory() as scratch:
        for way, (markers, known) in KNOWN.items():
            for seed in range(given.first, given.first + given.arms):
                errors, stated = arrived(seed, markers, known, Path(scratch))
                row = {"way": way, "inside": (np.abs(errors) <= stated).mean()}
                for name, axes in (("place_um", slice(3)), ("turn_urad", slice(3, 6))):
                    row[name], row[f"U_{name}"] = (1e6 * rms(each[:, axes]) for each in (errors, stated))
                rows.append(row)
                print(*rows[-1].values(), sep=", ", flush=True)
    table = pd.DataFrame(rows).groupby("way", sort=False).agg(["mean", "sem"])
    print(table.round(3).to_string())
    given.out.parent.mkdir(parents=True, exist_ok=True)
    table.to_csv(given.out, float_format="%.4g")


if __name__ == "__main__":
    main()

"""FIGAROH's own example data in five folds: `identify`, `diagnose`, its own levels and a script on the same rows.

    python -m benchmarks.arms_positions.examples FOLDER [--figaroh PYTHON] [--only SET ...] [--ways PATTERN]
        [--stiffness N] [--out FILE.csv]

`FOLDER` has a table and a URDF file for each set, which are no part of this project: `ur10.csv`, `tiago.csv` and
`talos.csv` as FIGAROH keeps them (a row for each pose; columns `x1`, `y1`, `z1` of the first marker, and so on, and one
for each joint by its name in the URDF), and `ur10.urdf`, `tiago.urdf`, `talos.urdf`, all under the Apache licence 2.0:

- `examples/ur10/data/calibration.csv`, `examples/talos/data/talos_left_arm_02_10_contact.csv` in figaroh-plus;
- `examples/tiago/data/calibration/mocap/qualysis_base_hand_calibration.csv` in figaroh-examples: its fourth marker is
  the third once more, and is left out;
- `examples/ur10/urdf/ur10_robot.urdf` in figaroh-examples (a UR10e: the UR10 of `example-robot-data` is 10.9 mm
  off), `tiago_no_hand.urdf` and `talos_full_v2.urdf` of the package `example-robot-data`.

Every fifth pose, from the first, second, … on, is held out. Stated are the 3D RMS of held-out positions over all poses,
noise of the readings included, and the processor time of a fit. No standard deviation is stated. Without `--stiffness`
(N·m/rad, N/m of a prismatic joint, for all joints alike) `identify` and `diagnose` have joints that do not yield.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import re
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pandas as pd
from benchmarks.arms_positions.rows import Rows
from benchmarks.arms_positions.ways import Outcome, UnavailableError, ways

import expdesign as xd

FOLDS = 5
ENDS = {
    "ur10": ("base_link", "wrist_3_link"),
    "tiago": ("torso_fixed_link", "arm_7_link"),
    "talos": ("base_link", "gripper_left_base_link"),
}
"""Links of base and tip."""


def folds(name: str, folder: Path, stiffness: float | None) -> Iterator[Rows]:
    """The rows of a set with one fold after the other held out."""
    frame = pd.read_csv(folder / f"{name}.csv")
    tree = ET.fromstring((folder / f"{name}.urdf").read_text(encoding="utf-8"))
    for link in tree.findall("link"):
        for shape in (*link.findall("visual"), *link.findall("collision")):
            link.remove(shape)  # names meshes that are not here
    urdf = ET.tostring(tree, encoding="unicode")
    kinds = {str(joint.get("name")): joint.get("type") for joint in tree.findall("joint")}
    joints = tuple(column for column in frame.columns if column.endswith("_joint"))
    columns = [f"{joint}_m" if kinds[joint] == "prismatic" else f"{joint}_rad" for joint in joints]
    commands = frame[list(joints)].to_numpy(float)
    axes = [column for column in frame.columns if re.fullmatch(r"[xyz]\d+", column)]
    read = frame[axes].to_numpy(float).reshape(len(frame), -1, 3)
    robot = {"name": name, "kind": "serial", "urdf": str((folder / f"{name}.urdf").resolve())}
    robot |= dict(zip(("base_link", "tip_link"), ENDS[name], strict=True))
    for fold in range(FOLDS):
        held = np.arange(len(frame)) % FOLDS == fold
        lines = [
            {"series": 1 + number, "marker": f"marker {1 + marker}", "split": "test" if test else "train"}
            | dict(zip((*columns, "px_m", "py_m", "pz_m"), (*command, *position), strict=True))
            for number, (command, seen, test) in enumerate(zip(commands, read, held, strict=True))
            for marker, position in enumerate(seen)
        ]
        yield Rows(
            name=name, urdf=urdf, ends=ENDS[name], joints=joints, commands=commands, positions=read, truth=read,
            held_out=held, table=pd.DataFrame(lines).assign(sequence=range(1, 1 + len(lines))),
            robot=robot if stiffness is None else robot | {"actuator_stiffness": [stiffness] * len(joints)},
        )  # fmt: skip


def by_diagnosis(rows: Rows) -> Outcome:
    """`diagnose`, whose model file predicts."""
    start = time.process_time()
    found = xd.diagnose(rows.robot, rows.table)
    seconds = time.process_time() - start
    with tempfile.TemporaryDirectory() as scratch:
        found.save(Path(scratch) / "found")
        points = rows.table[rows.table["split"] == "test"].drop(columns=["px_m", "py_m", "pz_m"])
        seen = xd.predict(Path(scratch) / "found" / "model.yaml", points).frame
    positions = seen[["px_m", "py_m", "pz_m"]].to_numpy(float)
    return Outcome(positions.reshape(rows.truth[rows.held_out].shape), 0, seconds)


def main() -> None:
    """The table, on standard output and in `--out`."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--figaroh", help="interpreter that has FIGAROH")
    parser.add_argument("--only", nargs="*", default=list(ENDS), choices=ENDS)
    parser.add_argument("--ways", default="as drawn|identify|diagnose|FIGAROH|script$", help="regular expression")
    parser.add_argument("--stiffness", type=float)
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    every = {**ways(given.figaroh, None), "diagnose": by_diagnosis}
    lines: list[dict[str, object]] = []
    for name in given.only:
        for way in (each for each in every if re.search(given.ways, each)):
            errors, seconds, refused = [], [], []
            for rows in folds(name, given.folder, given.stiffness):
                try:
                    found = every[way](rows)
                except (UnavailableError, xd.ExpdesignError) as reason:
                    refused.append(str(reason))
                    continue
                errors.append(1e3 * np.linalg.norm(found.positions - rows.truth[rows.held_out], axis=-1).ravel())
                seconds.append(found.seconds)
            whole = np.concatenate(errors) if errors else np.full(1, np.nan)
            lines.append(
                {
                    "set": name, "way": way, "rms_mm": float(np.sqrt((whole**2).mean())), "max_mm": float(whole.max()),
                    "folds": len(errors), "seconds": float(np.mean(seconds)) if seconds else float("nan"),
                }
            )  # fmt: skip
            print(*lines[-1].values(), *refused, sep=", ", flush=True)
            if given.out:
                pd.DataFrame(lines).to_csv(given.out, index=False, float_format="%.4g")


if __name__ == "__main__":
    main()

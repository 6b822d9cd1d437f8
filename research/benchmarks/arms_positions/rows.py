"""The rows that every way of calibrating gets: commands, positions of markers, which poses are held out."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd
import yaml

from research.benchmarks.arms_positions.machine import KINDS, NOISE, Machine

Array = npt.NDArray[np.float64]
POSES = {"40 poses, three markers": (40, 3), "150 poses, one marker": (150, 1)}
"""Fitted poses, and markers that are read at each."""
ENDS = ("base", "flange")
HELD_OUT = 100
"""Simulated poses that are held out, where the truth is known."""


@dataclass(frozen=True)
class Rows:
    """What was measured of one arm.

    Attributes:
        name: of the set.
        urdf: text of the arm's URDF.
        ends: links of base and tip.
        joints: names of the joints of the chain, in its order.
        commands: (N, n), rad or m.
        positions: of every marker, (N, markers, 3), m.
        truth: the same without noise where it is known, else the readings.
        held_out: (N,), poses that are not fitted.
        robot, table: what `identify` reads: a robot file, or its content, and recordings.
    """

    name: str
    urdf: str
    ends: tuple[str, str]
    joints: tuple[str, ...]
    commands: Array
    positions: Array
    truth: Array
    held_out: npt.NDArray[np.bool_]
    robot: Path | dict[str, Any]
    table: pd.DataFrame


def simulated(kind: str, design: str, seed: int, folder: Path) -> Rows:
    """An arm of a kind of `KINDS` with errors of its own, measured at random; its URDF is put in `folder`."""
    (poses, markers), arm = POSES[design], KINDS[kind]
    random = np.random.default_rng([seed, poses])
    machine = Machine(arm, markers, random)
    held = np.arange(poses + HELD_OUT) >= poses
    commands = random.uniform(arm.low, arm.high, (len(held), len(arm.joints)))
    exact = machine.readings(commands)
    read = exact + NOISE * random.standard_normal(exact.shape)
    file = folder / f"{kind} {seed}.urdf"
    file.write_text(arm.urdf, encoding="utf-8")
    robot = {"name": kind, "kind": "serial", "urdf": str(file), "base_link": ENDS[0], "tip_link": ENDS[1]}
    lines = [
        {"marker": f"{ENDS[1]} {place}", "split": "test" if test else "train"}
        | {f"q{number}_rad": value for number, value in enumerate(command, start=1)}
        | dict(zip(("px_m", "py_m", "pz_m"), position, strict=True))
        | dict.fromkeys(("spx_m", "spy_m", "spz_m"), NOISE)
        for command, seen, test in zip(commands, read, held, strict=True)
        for place, position in enumerate(seen)
    ]
    count = range(1, 1 + len(lines))
    return Rows(
        name=f"{kind}, {design}",
        urdf=arm.urdf,
        ends=ENDS,
        joints=arm.joints,
        commands=commands,
        positions=read,
        truth=exact,
        held_out=held,
        robot=robot | {"actuator_stiffness": arm.stiffness.tolist()},
        table=pd.DataFrame(lines).assign(sequence=count, series=count),
    )


def recorded(robot: Path, recordings: Path, joints: tuple[str, ...]) -> Rows:
    """Recordings of one marker with a column `split`, of a robot file of the kind `serial`."""
    content = yaml.safe_load(robot.read_text(encoding="utf-8"))
    frame = pd.read_csv(recordings)
    if frame["marker"].nunique() != 1:
        raise SystemExit(f"{recordings}: {frame['marker'].nunique()} markers; recordings of one are compared here")
    columns = [name for name in frame.columns if name[0] == "q" and name[1:2].isdigit()]
    positions = frame[["px_m", "py_m", "pz_m"]].to_numpy(float)[:, None]
    return Rows(
        name=f"{robot.parent.name}, {recordings.stem}",
        urdf=(robot.parent / content["urdf"]).read_text(encoding="utf-8"),
        ends=(content["base_link"], content["tip_link"]),
        joints=joints,
        commands=frame[columns].to_numpy(float),
        positions=positions,
        truth=positions,
        held_out=(frame["split"] == "test").to_numpy(),
        robot=robot,
        table=frame,
    )

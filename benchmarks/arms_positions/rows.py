"""The rows that every way of calibrating gets: commands, positions of markers, which poses are held out.

Simulated arms are those of `benchmarks.arms.coverage`: pinocchio is the machine, zeros, frames and stiffnesses are
drawn anew, joints yield under the links' weight, positions have 30 µm of noise. Axes that point backwards are turned
round, since not every tool reads them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd
import yaml
from benchmarks.arms import coverage

Array = npt.NDArray[np.float64]
POSES = {"40 poses, three markers": (40, 3), "150 poses, one marker": (150, 1)}
"""Fitted poses, and markers that are read at each."""
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
    """An arm of a kind of `coverage.KINDS` with errors of its own, measured at random; its URDF is put in `folder`."""
    poses, markers = POSES[design]
    whole = coverage.KINDS[kind]
    arm = replace(whole, urdf=whole.urdf.replace('axis xyz="0 -1 0"', 'axis xyz="0 1 0"'))
    arm = replace(arm, urdf=arm.urdf.replace('axis xyz="0 0 -1"', 'axis xyz="0 0 1"'))
    random, n = np.random.default_rng([seed, poses]), len(arm.joints)
    machine = coverage.Machine(arm)
    places = random.normal(0.0, 0.02, (markers, 3)) + coverage.PLACES[:markers]
    begin = coverage.Truth(np.zeros(n), np.zeros((n, 6)), np.ones(n), coverage.STAND, places)
    sizes = np.concatenate(
        [
            np.full(n, coverage.ZERO),
            np.tile([coverage.LENGTH] * 3 + [coverage.ANGLE] * 3, n),
            np.full(n, coverage.SOFTNESS),
            np.zeros(6 + places.size),
        ]
    )
    truth = begin.moved(sizes * random.standard_normal(len(sizes)))
    held = np.arange(poses + HELD_OUT) >= poses
    commands = random.uniform(arm.low, arm.high, (len(held), n))
    tips = np.zeros(len(held), dtype=np.int64)
    exact = machine.readings(truth, commands, tips)
    read = exact + coverage.NOISE * random.standard_normal(exact.shape)
    file = folder / f"{kind} {seed}.urdf"
    file.write_text(arm.urdf, encoding="utf-8")
    robot = {"name": kind, "kind": "serial", "urdf": str(file), "base_link": arm.base, "tip_link": arm.tips[0]}
    return Rows(
        name=f"{kind}, {design}",
        urdf=arm.urdf,
        ends=(arm.base, arm.tips[0]),
        joints=arm.joints,
        commands=commands,
        positions=read,
        truth=exact,
        held_out=held,
        robot=robot | {"actuator_stiffness": arm.stiffness.tolist()},
        table=coverage.table(arm, commands, tips, read, held),
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

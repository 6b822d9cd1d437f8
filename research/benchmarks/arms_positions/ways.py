"""Ways of calibrating an arm: held-out positions, number of parameters and processor time of each.

FIGAROH and pybotics run in interpreters of their own, which the command line names: neither is a dependency, and
pybotics needs a NumPy below 2.
"""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pandas as pd
import pinocchio as pin

import expdesign as xd
from expdesign.chain.row import row_data
from research.benchmarks.arms_positions.rows import Rows
from research.benchmarks.arms_positions.script import Script, as_drawn, by_script
from research.benchmarks.single_thread import ONE_THREAD

Array = npt.NDArray[np.float64]
LEVELS = ("offsets", "offsets+compliances", "all", "all+compliances", "priors")
_MOST = 600
"""s; a calibration that takes longer is ended."""


class UnavailableError(Exception):
    """A way that cannot be gone here or on these rows, and why."""


@dataclass(frozen=True)
class Outcome:
    """Held-out positions (N, markers, 3), number of parameters, and processor time (s)."""

    positions: Array
    parameters: int
    seconds: float


Way = Callable[[Rows], Outcome]


def ways(figaroh: str | None, pybotics: str | None) -> dict[str, Way]:
    """By name; interpreters that have FIGAROH and pybotics, or None."""
    return {
        "as drawn": partial(_here, as_drawn),
        "scipy script": partial(_here, partial(by_script, compliances=False)),
        "scipy script+compliances": partial(_here, partial(by_script, compliances=True)),
        "identify": by_program,
        **{f"FIGAROH, {level}": partial(by_figaroh, figaroh, level) for level in LEVELS},
        "pybotics": partial(by_pybotics, pybotics),
    }


def _here(fit: Callable[[Rows], tuple[Array, int]], rows: Rows) -> Outcome:
    start = time.process_time()
    positions, parameters = fit(rows)
    return Outcome(positions, parameters, time.process_time() - start)


def by_program(rows: Rows) -> Outcome:
    """`identify` with nothing but the robot file and the rows."""
    start = time.process_time()
    result = xd.identify(rows.robot, rows.table).result
    seconds = time.process_time() - start
    assert result.arm is not None
    test = result.recordings.rows(result.recordings.test)
    chain = result.fit.chain
    predicted: Array = np.asarray(chain.predict(row_data(test, chain.robot), result.fit.values))
    return Outcome(predicted.reshape(rows.truth[rows.held_out].shape), len(result.arm.minimal.kept), seconds)


def by_figaroh(python: str | None, level: str, rows: Rows) -> Outcome:
    """FIGAROH's geometric calibration."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        (folder / "arm.urdf").write_text(rows.urdf, encoding="utf-8")
        task = {"base": rows.ends[0], "tip": rows.ends[1], "joints": rows.joints, "markers": rows.positions.shape[1]}
        (folder / "task.json").write_text(json.dumps(task), encoding="utf-8")
        for name, which in (("train", ~rows.held_out), ("test", rows.held_out)):
            frame = pd.DataFrame(rows.commands[which], columns=rows.joints)
            for marker in range(rows.positions.shape[1]):
                for axis, letter in enumerate("xyz"):
                    frame[f"{letter}{marker + 1}"] = rows.positions[which, marker, axis]
            frame.to_csv(folder / f"{name}.csv", index=False)
        return _elsewhere(python, "figaroh", folder, level)


def by_pybotics(python: str | None, rows: Rows) -> Outcome:
    """pybotics' calibration of a robot in modified Denavit-Hartenberg parameters."""
    if rows.positions.shape[1] != 1:
        raise UnavailableError("has one tool, and so one marker")
    script, train = Script(rows), ~rows.held_out
    start = script.start(rows.commands[train], rows.positions[train])
    stand = start[8 * len(rows.joints) :][:6]
    world = pin.SE3(pin.exp3(stand[3:]), stand[:3])
    drawn = [world * pose for pose in script.drawn_poses(rows.commands[train][:5])]
    script.drawn_poses(np.zeros((1, len(rows.joints))))
    data, model = script.data, script.model
    base = data.oMf[script.base]
    joints = [(base.actInv(data.oMi[number]), model.joints[number]) for number in script.numbers]
    axis_of = {"RX": 0, "RY": 1, "RZ": 2, "PX": 0, "PY": 1, "PZ": 2}
    axes, sliding = [], []
    for pose, joint in joints:
        short = joint.shortname().replace("JointModel", "")
        if short not in axis_of:
            raise UnavailableError(f"a joint {short} has no form in it")
        axes.append(pose.rotation[:, axis_of[short]])
        sliding.append(short.startswith("P"))
    with tempfile.TemporaryDirectory() as scratch:
        np.savez(
            Path(scratch) / "task.npz",
            points=np.array([pose.translation for pose, _ in joints]),
            axes=np.array(axes),
            prismatic=np.array(sliding),
            tip=base.actInv(data.oMf[script.tip]).homogeneous,
            world=world.homogeneous,
            drawn=np.array([pose.translation for pose in drawn]),
            commands=rows.commands[train],
            positions=rows.positions[train, 0],
            held_out=rows.commands[rows.held_out],
        )
        return _elsewhere(python, "pybotics", Path(scratch))


def _elsewhere(python: str | None, package: str, folder: Path, *options: str) -> Outcome:
    if python is None:
        raise UnavailableError(f"name an interpreter that has {package} with --{package}")
    worker = Path(__file__).with_name(f"{package}_worker.py")
    environment = {**os.environ, **ONE_THREAD}
    environment.pop("PYTHONPATH", None)
    try:
        done = subprocess.run(
            [python, str(worker), str(folder), *options],
            capture_output=True, text=True, check=False, env=environment, timeout=_MOST,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        raise UnavailableError(f"was ended after {_MOST} s") from None
    except OSError as error:
        raise UnavailableError(str(error)) from None
    if done.returncode:
        raise UnavailableError(done.stderr.strip().splitlines()[-1] if done.stderr.strip() else "failed without a word")
    found = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    return Outcome(np.array(found["positions"]), found["parameters"], found["seconds"])

"""Campaigns as laboratories make them: full poses, logged joint angles, twelve hours, thousands of rows.

`python -m benchmarks.arms.campaigns [--only NAME ...] [--results FOLDER]`. The arm is a UR5 in pinocchio with the usual
faults (`plant.py`), without tool and runout. A campaign is identified, and diagnosed where that is named, in a process
of its own on one thread; stated are processor times, errors of rows marked `test` against the noise-free arm's
deviation (RMS of components, so that 1 is the noise), and the share of their readings within 95 % intervals.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from benchmarks.arms.plant import campaign, recordings, usual_faults
from benchmarks.single_thread import ONE_THREAD
from scipy.spatial.transform import Rotation

import expdesign as xd

ROBOT = Path("configs/robots/ur5.yaml")
FAULTS = replace(usual_faults(3, tool=0.0), periodic=(0.0, 0.0))
WITHIN, PLACE, TURN = 1.96, 3e-5, 1.5e-4


def _positions(poses: int, markers: int) -> pd.DataFrame:
    table = recordings(FAULTS, poses * markers, 11, markers=markers)
    return table.drop(columns=[name for name in table if re.fullmatch(r"[fm][xyz]_Nm?", str(name))])


CAMPAIGNS: dict[str, tuple[Callable[[], pd.DataFrame], tuple[str, ...], bool]] = {
    "210 full poses": (lambda: campaign(FAULTS, 210, 1, hours=2.0), (), True),
    "687 full poses": (lambda: campaign(FAULTS, 687, 2, hours=4.0), (), True),
    "1,750 full poses, base wanders": (
        lambda: campaign(FAULTS, 1750, 3, hours=12.0, shift=1e-4, turn=5e-5), ("drift",), True,
    ),
    "687 positions": (lambda: _positions(687, 1), (), False),
    "5,000 positions": (lambda: _positions(5000, 1), (), False),
}  # fmt: skip
"""Rows, what is identified beside geometry and compliances, and whether they are diagnosed as well."""


def judged(found: Any, frame: pd.DataFrame) -> dict[str, float]:
    """Errors of the marked rows over the noise, and the share of their coordinates within intervals of readings."""
    places = [f"{'measured_' if 'kind' in frame else 'p'}{axis}_m" for axis in "xyz"]
    turns = [f"measured_r{axis}_rad" for axis in "xyz"] if "kind" in frame else []
    predicted = xd.predict(found, frame.drop(columns=[*places, *turns]), readings=True).frame
    held = (frame["split"] == "test").to_numpy()
    own = places if places[0] in predicted else ["px_m", "py_m", "pz_m"]  # a diagnosis reads positions alone
    away = frame[places].to_numpy()[held] - predicted[own].to_numpy()[held]
    stated = predicted[[f"s{name.removeprefix('measured_')}" for name in own]].to_numpy()[held]
    done = {
        "position": round(float(np.sqrt((away**2).mean())) / PLACE, 3),
        "inside": round(float((np.abs(away) <= WITHIN * stated).mean()), 3),
    }
    if turns and turns[0] in predicted:
        one, other = (Rotation.from_euler("xyz", each[turns].to_numpy()[held]) for each in (frame, predicted))
        done["orientation"] = round(float(np.sqrt(((one * other.inv()).as_rotvec() ** 2).mean())) / TURN, 3)
    return done


def one(name: str) -> list[dict[str, object]]:
    """One campaign in this process."""
    make, further, diagnosed = CAMPAIGNS[name]
    frame, done = make(), []
    ways: dict[str, Callable[[], Any]] = {"identify": lambda: xd.identify(ROBOT, frame)}
    if further:
        ways[f"identify with {further[0]}"] = lambda: xd.identify(ROBOT, frame, further=further)  # type: ignore[arg-type]
    if diagnosed:
        ways["diagnose"] = lambda: xd.diagnose(ROBOT, frame)
    for way, call in ways.items():
        start = time.process_time()
        found = call()
        seconds = time.process_time() - start
        verdict = getattr(found, "verdict", "")
        done.append(
            {"campaign": name, "way": way, "seconds": round(seconds, 1), "verdict": verdict, **judged(found, frame)}
        )
        print(json.dumps(done[-1]), flush=True)
    return done


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", default=list(CAMPAIGNS))
    parser.add_argument("--results", type=Path, default=Path("results/arms"))
    parser.add_argument("--one", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.one:
        one(given.one)
        return
    done: list[dict[str, object]] = []
    for name in given.only:
        command = [sys.executable, "-m", "benchmarks.arms.campaigns", "--one", name]
        run = subprocess.run(command, capture_output=True, text=True, env={**os.environ, **ONE_THREAD}, check=False)
        done += [json.loads(line) for line in run.stdout.splitlines()]
        if run.returncode:
            done.append({"campaign": name, "failed": run.stderr.strip().splitlines()[-1]})
        print(*done[-3:], sep="\n", flush=True)
        given.results.mkdir(parents=True, exist_ok=True)
        (given.results / "campaigns.json").write_text(json.dumps(done, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()

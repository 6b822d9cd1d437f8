"""Reported cases, before and after: each command is run in each state, and what it answers stands beside what is right.

python -m research.benchmarks.reported_cases CASES [--state NAME=SRC ...] [--only FOLDER ...] [--seconds 300]
    [--out FILE.md]

CASES is a folder with one folder a case (inputs made by users, or rows of public recordings that are not part of this
project). A state is the folder `src` of a checkout; without `--state` it is this one. Figures are read from what the
commands wrote: RMS of readings against predictions of the *written* model, in mm or degrees, over all rows.
"""

import argparse
import json
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

ROOT = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class Answers:
    """What the commands of a case did.

    Attributes:
        folder: in which they ran.
        codes: exit statuses; `None` where the time was up.
        texts: standard output and error of each.
        seconds: wall time of each.
    """

    folder: Path
    codes: list[int | None]
    texts: list[str]
    seconds: list[float]


@dataclass(frozen=True)
class Case:
    """A case: its folder, commands, what is right, and how the answer is read."""

    folder: str
    commands: tuple[str, ...]
    right: str
    read: Callable[[Answers], str]


def last_lines(answers: Answers) -> str:
    """The last line that each command printed, shortened."""
    if any("Traceback" in text for text in answers.texts):
        return "traceback"
    ends = (" ".join(text.split())[-170:] for text in answers.texts)
    return " / ".join(end.replace("|", "/") for end in ends)


def named(*words: str) -> Callable[[Answers], str]:
    """Whether what was printed holds one of these words, and the sentence around the first."""

    def read(answers: Answers) -> str:
        text = " ".join(" ".join(answers.texts).split())
        for word in words:
            place = text.lower().find(word.lower())
            if place >= 0:
                return f"named: … {text[max(0, place - 60) : place + 100]} …".replace("|", "/")
        return "traceback" if "Traceback" in text else "not named"

    return read


def written_rms(predicted: str, measured: str) -> Callable[[Answers], str]:
    """RMS of measured positions against the predictions in another table, in mm, and the share inside 95 %."""

    def read(answers: Answers) -> str:
        file = answers.folder / predicted
        if not file.exists():
            return last_lines(answers)
        here, there = pd.read_csv(file), pd.read_csv(answers.folder / measured)
        columns = ["px_m", "py_m", "pz_m"]
        misses = there[columns].to_numpy() - here[columns].to_numpy()
        deviations = here[["spx_m", "spy_m", "spz_m"]].to_numpy()
        rms = 1e3 * np.sqrt((misses**2).sum(axis=1).mean())
        return f"{rms:.3f} mm, {100.0 * (np.abs(misses) <= 1.96 * deviations).mean():.0f} % inside"

    return read


def value_of(file: str, row: int, column: str) -> Callable[[Answers], str]:
    """One value of a table that was written."""

    def read(answers: Answers) -> str:
        path = answers.folder / file
        if not path.exists():
            return last_lines(answers)
        table = pd.read_csv(path)
        return f"{column} {table[column].iloc[row]:.6g}" if column in table else f"columns {', '.join(table.columns)}"

    return read


def accuracy(answers: Answers) -> str:
    """Before and after of an arm, as `identify` prints them."""
    lines = [line.strip() for text in answers.texts for line in text.splitlines() if "RMS" in line or "→" in line]
    return " / ".join(lines[:2]).replace("|", "/") if lines else last_lines(answers)


def plan_total(answers: Answers) -> str:
    """Total of the recommended plan and its minutes."""
    file = answers.folder / "p" / "pareto.csv"
    if not file.exists():
        return last_lines(answers)
    front = pd.read_csv(file)
    total = front.loc[front["recommended"].astype(str).str.lower() == "true", "total"].iloc[0]
    minutes = [line for line in answers.texts[0].splitlines() if "minute" in line]
    return f"total {total:.4f}; {' '.join(' '.join(minutes).split())[:160]}"


def left_at_targets(answers: Answers) -> str:
    """Largest rotation left at the targets by the commands (µrad) with the true robot, and in the U stated there."""
    file = answers.folder / "e.csv"
    if not file.exists():
        return last_lines(answers)
    table, simulated = pd.read_csv(answers.folder / "c.csv"), pd.read_csv(file)
    axes = ("rx_rad", "ry_rad")
    left = np.array([table[axis] + simulated[f"d{axis}"] - table[f"target_{axis}"] for axis in axes])
    within = np.abs(left) / np.array([table[f"U_{axis}"] for axis in axes])
    return f"{1e6 * np.abs(left).max():.2f} µrad left, {within.max():.2f} of the U there"


def took(answers: Answers) -> str:
    """Seconds of each command."""
    return ", ".join(f"{seconds:.0f} s" for seconds in answers.seconds)


CASES = (
    Case(
        "iiwa7",
        ("diagnose robot.yaml positions.csv --out dg", "predict dg/model.yaml mall.csv --readings --out p.csv"),
        "0.30 mm",
        written_rms("p.csv", "positions.csv"),
    ),
    Case(
        "iiwa7",
        ("diagnose robot.yaml loads.csv --out dl", "predict dl/model.yaml loads_points.csv --readings --out q.csv"),
        "0.30 mm",
        written_rms("q.csv", "loads.csv"),
    ),
    Case(
        "order-of-rows",
        ("predict model.yaml one.csv --readings --out p.csv",),
        "0.032458",
        value_of("p.csv", 0, "pz_m"),
    ),
    Case(
        "fanuc",
        ("identify robot_plain.yaml plain.csv --out id",),
        "elbow = J3 + J2 named; 0.30 mm",
        named("couplings", "J3 + J2", "follows"),
    ),
    Case(
        "orientations",
        ("identify robot.yaml rec_rotvec.csv --out id",),
        "rotation vector named",
        named("rotation vector"),
    ),
    Case(
        "orientations",
        ("identify robot.yaml rec_ZYXcols.csv --out id",),
        "convention named",
        named("convention", "A, B, C", "order"),
    ),
    Case("eye-in-hand", ("identify robot.yaml rec.csv --out id",), "invert the poses", named("invert", "inverse")),
    Case("moved-tracker", ("identify robot.yaml rec.csv --out id",), "two stations", named("station")),
    Case("datum-spheres", ("identify robot.yaml rec.csv --out id",), "0.0097 mm", accuracy),
    Case("instrument-scale", ("identify robot.yaml rec.csv --out id",), "scale 1.0080", named("scale")),
    Case("parallel-axes", ("identify calibrated.yaml rec.csv --out id",), "0.055 mm", accuracy),
    Case(
        "empty-load",
        ("check rec.csv --robot robot.yaml",),
        "empty cells accepted",
        lambda a: "refused" if "cell is empty" in a.texts[0] else f"accepted: {last_lines(a)}",
    ),
    Case(
        "discrete-demands/dupcand", ("check config.yaml", "run config.yaml --out r"), "one message, exit 2", last_lines
    ),
    Case(
        "discrete-demands/masses", ("check config.yaml", "run config.yaml --out r"), "one message, exit 2", last_lines
    ),
    Case(
        "discrete-demands/two_cand", ("check config.yaml", "run config.yaml --out r"), "one message, exit 2", last_lines
    ),
    Case(
        "target-load",
        (
            "diagnose h840.yaml rec3.csv --targets h840-run.yaml --out d",
            "compensate d/model.yaml h840-run.yaml --out c.csv",
            'simulate h840-run.yaml c.csv --model truth.yaml --conceal "leg_backlash at leg 4, 4 um" --no-noise '
            "--no-load-errors --out e.csv",
        ),
        "the weights' error stays with the weights; U holds",
        left_at_targets,
    ),
    Case("time-budget", ("run h840-run.yaml --out p",), "<= 0.0180 in <= 240 minutes", plan_total),
    Case("few-measurements", ("check m5.yaml", "run m5.yaml --out r"), "at least 6 measurements, exit 2", last_lines),
    Case(
        "controller-units",
        ("identify ur10e.yaml trackerA.csv --out i", "compensate i/model.yaml targets.csv --out c.csv --units mm,deg"),
        "controller_* in mm and deg",
        value_of("c.csv", 0, "controller_x_mm"),
    ),
    Case("two-limits", ("run h840-meir.yaml --out p --seconds 60",), "60 s", took),
    Case("other-robots-file", ("identify h840.yaml rec.csv --out id",), "named", named("another robot", "other robot")),
    Case("shifted-row", ("identify h840.yaml rec.csv --out id",), "named", named("shift", "row too", "one row")),
    Case("std-in-other-unit", ("identify h840.yaml rec.csv --out id",), "named", named("standard deviation")),
    Case("unreachable-recorded", ("identify h840.yaml rec.csv --out id",), "named", named("reach", "long")),
    Case("half-angle", ("check h840.yaml",), "asked about", named("half_angle", "half angle")),
    Case("crossed-legs", ("check h840.yaml",), "asked about", named(" cross ")),
    Case("decimal-comma-yaml", ("check h840.yaml",), "decimal comma?", named("decimal comma")),
)


def answered(case: Case, cases: Path, source: Path, seconds: float) -> Answers:
    """What the commands of a case do in a copy of its folder."""
    folder = Path(tempfile.mkdtemp()) / "case"
    shutil.copytree(cases / case.folder, folder, copy_function=shutil.copyfile)
    for path in (folder, *folder.rglob("*")):
        path.chmod(0o755 if path.is_dir() else 0o644)
    environment = os.environ | {"PYTHONPATH": str(source), "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    codes: list[int | None] = []
    texts, times = [], []
    for command in case.commands:
        begun = time.monotonic()
        words = [sys.executable, "-m", "expdesign", *shlex.split(command)]
        try:
            done = subprocess.run(
                words, cwd=folder, env=environment, capture_output=True, text=True, timeout=seconds, check=False
            )
            codes.append(done.returncode)
            texts.append(done.stdout + done.stderr)
        except subprocess.TimeoutExpired:
            codes.append(None)
            texts.append(f"not done after {seconds:.0f} s")
        times.append(time.monotonic() - begun)
    return Answers(folder, codes, texts, times)


def rows(cases: Path, states: dict[str, Path], only: list[str], seconds: float) -> Iterator[dict[str, str]]:
    """One row a case, with what each state answers."""
    for case in CASES:
        if only and case.folder.split("/")[0] not in only:
            continue
        row = {"case": case.folder, "command": "; ".join(case.commands), "right": case.right}
        for name, source in states.items():
            answers = answered(case, cases, source, seconds)
            status = ", ".join("time" if code is None else str(code) for code in answers.codes)
            row[name] = f"exit {status}: {case.read(answers)}"
            shutil.rmtree(answers.folder.parent)
        yield row


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", type=Path)
    parser.add_argument("--state", action="append", default=[], metavar="NAME=SRC")
    parser.add_argument("--only", nargs="*", default=[])
    parser.add_argument("--seconds", type=float, default=300.0)
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    states = dict(text.split("=", 1) for text in given.state) or {"now": str(ROOT / "src")}
    table = []
    for row in rows(given.cases, {name: Path(path) for name, path in states.items()}, given.only, given.seconds):
        table.append(row)
        print(json.dumps(row, ensure_ascii=False), flush=True)
    if given.out:
        frame = pd.DataFrame(table)
        lines = ["| " + " | ".join(frame.columns) + " |", "| " + " | ".join("---" for _ in frame.columns) + " |"]
        lines += ["| " + " | ".join(str(value) for value in line) + " |" for line in frame.itertuples(index=False)]
        given.out.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()

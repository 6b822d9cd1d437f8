"""Real sets the way a person goes: `diagnose` writes a model file, which `predict --readings` reads.

    python -m research.benchmarks.real_sets ../shared/recordings --out results/real/sets

Every file is worked on as it was recorded, with every row in a series of its own, and with all rows in one series where
its readings may be (deflections of one series have one command). `predict` sees the table without what was measured.
Judged are the rows that are marked `test`, which nothing was fitted to: the share of their readings within the 95 %
intervals of readings. Each file is a process of its own, whose processor time is limited; nothing of the recordings is
copied.
"""

import argparse
import csv
import os
import re
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict, dataclass, fields
from pathlib import Path

import numpy as np
import pandas as pd

import expdesign as xd
from research.benchmarks.single_thread import ONE_THREAD

VARIABLE = "EXPDESIGN_RECORDINGS"
"""Environment variable that names the folder of the recordings, which are others' and no part of the project."""

SERIES = ("as recorded", "every row its own", "one for all")
WITHIN = 1.96
LIMIT = 400
"""Seconds of processor time for one file."""


@dataclass(frozen=True)
class Case:
    """One file of a set.

    Attributes:
        folder: of the set.
        file: without `.csv`.
        robot: robot file.
        others: files of the same set, recorded under other conditions.
    """

    folder: str
    file: str
    robot: str = "robot.yaml"
    others: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """As it stands in the page."""
        known = "" if self.robot == "robot.yaml" else "-" + self.robot.removeprefix("robot_").removesuffix(".yaml")
        return f"{self.folder}-{self.file}{known}"


def _each(of: str, ending: str = "") -> list[Case]:
    """One set under every condition."""
    files = [f"{condition}{ending}" for condition in ("flat", "pallet", "orthogonal_wood", "wood_left_track")]
    return [Case(of, file, others=tuple(other for other in files if other != file)) for file in files]


CASES = (
    *_each("jaibot-tilt"),
    *_each("jaibot-column"),
    Case("tiago-forceplate", "recordings", others=("recordings_after_stop",)),
    *_each("jaibot-prism", "_by_station"),
    Case("jaibot-prism", "flat"),
    Case("jaibot-prism", "flat", "robot_marker_known.yaml"),
)


def recordings_folder() -> Path:
    """Where the recordings are, whether they are there or not: `../shared/recordings` seen from the project's root."""
    return Path(os.environ.get(VARIABLE, str(Path(__file__).resolve().parents[3] / "shared" / "recordings")))


@dataclass(frozen=True)
class Outcome:
    """One file in one kind of series.

    Attributes:
        rows, held_out: how many there are.
        cpu: seconds of processor time of `diagnose` and of `predict`.
        refused: what a command said instead of a result; empty where the way was gone to its end.
        verdict: of the diagnosis.
        error: RMS of held-out readings, in the standard deviations that the recordings state.
        inside: share of held-out readings within their 95 % intervals.
        endless: share of held-out readings whose standard deviation is infinite.
        widest: median of the predicted standard deviations over the stated ones.
    """

    name: str
    series: str
    rows: int = 0
    held_out: int = 0
    cpu: float = float("nan")
    refused: str = ""
    verdict: str = ""
    error: float = float("nan")
    inside: float = float("nan")
    endless: float = float("nan")
    widest: float = float("nan")


def in_series(frame: pd.DataFrame, series: str) -> pd.DataFrame:
    """The recordings with their series numbered anew."""
    if series == SERIES[0]:
        return frame
    return frame.assign(series=frame["sequence"] if series == SERIES[1] else 1)


def once(case: Case, series: str, folder: Path) -> Outcome:
    """One file, in this process."""
    robot = folder / case.folder / case.robot
    frame = in_series(pd.read_csv(folder / case.folder / f"{case.file}.csv"), series)
    held = (frame["split"] == "test").to_numpy()
    known = {"name": case.name, "series": series, "rows": len(frame), "held_out": int(held.sum())}
    began = time.process_time()
    with tempfile.TemporaryDirectory() as scratch:
        try:
            found = xd.diagnose(robot, frame)
            found.save(Path(scratch) / "diagnosed")
            read = [str(name) for name in frame if re.fullmatch(r"(dr?|p)[xyz]_(m|rad)", str(name))]
            points = frame.drop(columns=read)
            predicted = xd.predict(Path(scratch) / "diagnosed" / "model.yaml", points, readings=True).frame
        except xd.ExpdesignError as error:
            return Outcome(**known, cpu=time.process_time() - began, refused=str(error))  # type: ignore[arg-type]
    cpu = time.process_time() - began
    stated = [f"s{name.removeprefix('d')}" for name in read]
    errors = (frame[read] - predicted[read]).to_numpy()[held]
    deviations, noise = predicted[stated].to_numpy()[held], frame[stated].to_numpy()[held]
    return Outcome(
        **known,  # type: ignore[arg-type]
        cpu=cpu,
        verdict=found.verdict,
        error=float(np.sqrt(((errors / noise) ** 2).mean())),
        inside=float((np.abs(errors) <= WITHIN * deviations).mean()),
        endless=float((~np.isfinite(deviations)).mean()),
        widest=float(np.median(deviations / noise)),
    )


def apart(case: Case, series: str, folder: Path) -> Outcome:
    """One file, in a process of its own."""
    with tempfile.NamedTemporaryFile(suffix=".csv") as answer:
        arguments = [sys.executable, "-m", "research.benchmarks.real_sets", str(folder), "--out", answer.name]
        arguments += ["--only", case.name, "--series", series, "--once"]
        limited = ["prlimit", f"--cpu={LIMIT}", *arguments] if sys.platform == "linux" else arguments
        done = subprocess.run(limited, env={**os.environ, **ONE_THREAD}, capture_output=True, text=True, check=False)
        if done.returncode:
            last = (done.stderr.strip().splitlines() or [""])[-1]
            why = f"ended after {LIMIT} s of processor time" if done.returncode < 0 else last
            return Outcome(case.name, series, refused=why)
        return read_outcomes(Path(answer.name))[0]


def read_outcomes(file: Path) -> list[Outcome]:
    """What `write_outcomes` wrote."""
    kinds = {field.name: field.type for field in fields(Outcome)}
    with file.open(encoding="utf-8", newline="") as stream:
        return [
            Outcome(**{name: kinds[name](text) for name, text in row.items()})  # type: ignore[operator]
            for row in csv.DictReader(stream)
        ]


def write_outcomes(file: Path, outcomes: list[Outcome]) -> None:
    """As a table."""
    with file.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.DictWriter(stream, [field.name for field in fields(Outcome)])
        writer.writeheader()
        writer.writerows(asdict(outcome) for outcome in outcomes)


def page(outcomes: list[Outcome]) -> str:
    """The table as a page."""
    head = (__doc__ or "").strip().split("\n", 1)
    lines = [f"# {head[0].rstrip('.')}", head[1].replace("\n    python", "\n```\npython").replace(
        "sets\n", "sets\n```\n", 1), ""]  # fmt: skip
    gone = [o for o in outcomes if not o.refused]
    good = sum(0.90 <= o.inside <= 0.98 for o in gone)
    lines += [
        f"Gone to the end: {len(gone)} of {len(outcomes)}; "
        f"90 to 98 % of held-out readings inside: {good} of {len(gone)}.",
        "",
        "| recordings | rows | held out | series | CPU, s | verdict | RMS, stated s | inside 95 % | s over stated s |",
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for o in outcomes:
        if o.refused:
            text = o.refused.rsplit("/", 1)[-1].replace("|", "/")
            lines.append(f"| {o.name} | {o.rows} | {o.held_out} | {o.series} | {o.cpu:.0f} | refused: {text} | | | |")
            continue
        endless = f" ({o.endless:.0%} without end)" if o.endless else ""
        lines.append(
            f"| {o.name} | {o.rows} | {o.held_out} | {o.series} | {o.cpu:.0f} | {o.verdict} | {o.error:.3g} | "
            f"{100.0 * o.inside:.0f} %{endless} | {o.widest:.3g} |"
        )
    return "\n".join([*lines, ""])


def main(arguments: list[str] | None = None) -> int:
    """Work on all files, or on some, and write the table as CSV and as a page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--out", type=Path, required=True, help="table and page, without ending")
    parser.add_argument("--only", nargs="*", default=[], help="names of files as in the page")
    parser.add_argument("--series", nargs="*", default=list(SERIES), choices=SERIES)
    parser.add_argument("--once", action="store_true", help="one file in this process")
    options = parser.parse_args(arguments)
    if not options.folder.is_dir():
        print(f"{options.folder}: there is no such folder", file=sys.stderr)
        return 2
    cases = [case for case in CASES if not options.only or case.name in options.only]
    if options.once:
        write_outcomes(options.out, [once(cases[0], options.series[0], options.folder)])
        return 0
    outcomes: list[Outcome] = []
    for case in cases:
        for series in options.series:
            outcomes.append(apart(case, series, options.folder))
            print(outcomes[-1], flush=True)
            write_outcomes(options.out.with_suffix(".csv"), outcomes)
            options.out.with_suffix(".md").write_text(page(outcomes), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""Real sets the way a person goes: a command writes a model file, which `predict --readings` reads.

    python -m research.benchmarks.real_sets ../shared/recordings --out results/runs/sets

The command is `diagnose`, or `identify` with `--by identify`. Every file is worked on as it was recorded, with every
row in a series of its own, and with all rows in one series where its readings may be (deflections of one series have
one command). `predict` sees the table without what was measured. Judged are the rows that are marked `test`, which
nothing was fitted to: the share of their readings within the 95 % intervals of readings. What the file predicts of
the fitted rows is compared with what the report says of them. Each file is a process of its own, whose processor time
is limited; nothing of the recordings is copied, which others own and license.
"""

import argparse
import csv
import itertools
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, fields
from pathlib import Path

import numpy as np
import pandas as pd
import yaml
from scipy.spatial.transform import Rotation

import expdesign as xd
from expdesign.app.api.inputs import RobotInput
from expdesign.arrays import BoolArray
from research.benchmarks.single_thread import ONE_THREAD

VARIABLE = "EXPDESIGN_RECORDINGS"
"""Environment variable that names the folder of the recordings, which are others' and no part of the project."""

SERIES = ("as recorded", "every row its own", "one for all")
WITHIN = 1.96
SAME = 0.02
"""Share by which the RMS of the fitted rows from the written file may differ from the report's."""
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

REPORTED = (
    Case("iiwa7", "positions"),
    Case("iiwa7", "loads"),
    Case("fanuc", "coupled"),
    Case("orientations", "rec"),
    Case("datum-spheres", "rec"),
    Case("datum-spheres", "rec_bar"),
    Case("instrument-scale", "rec"),
    Case("parallel-axes", "rec", "nominal.yaml"),
    Case("parallel-axes", "rec", "calibrated.yaml"),
    Case("target-load", "rec3", "h840.yaml"),
    Case("controller-units", "trackerA", "ur10e.yaml"),
)
"""Sets of public reports (`research.benchmarks.reported_cases`), in a folder of their own."""

COMMANDS: dict[str, Callable[..., xd.IdentificationResult | xd.DiagnosisResult]] = {
    "identify": xd.identify,
    "diagnose": xd.diagnose,
}
MEASURED = r"(d[rxyz]?[xyz]?|p[xyz]|measured_r?[xyz]|gauge|distance)_(m|rad)"


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
        by: the command that wrote the model.
        written: RMS of the fitted rows as the written file predicts them, over that of the report.
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
    by: str = "diagnose"
    written: float = float("nan")


def in_series(frame: pd.DataFrame, series: str) -> pd.DataFrame:
    """The recordings with their series numbered anew."""
    if series == SERIES[0]:
        return frame
    return frame.assign(series=frame["sequence"] if series == SERIES[1] else 1)


def in_si(frame: pd.DataFrame) -> pd.DataFrame:
    """The recordings with millimetres and degrees in m and rad."""
    factors = {"mm": ("m", 1e-3), "deg": ("rad", np.pi / 180.0)}
    for name in [name for name in frame if str(name).rpartition("_")[2] in factors]:
        stem, _, unit = str(name).rpartition("_")
        frame = frame.assign(**{f"{stem}_{factors[unit][0]}": frame[name] * factors[unit][1]}).drop(columns=name)
    return frame


def of_deviations(columns: list[str]) -> list[str]:
    """Columns of the standard deviations of readings, as tables name them."""
    return [f"s{re.sub('^(d(?=r?[xyz]_)|measured_)', '', name)}" for name in columns]


def answered(frame: pd.DataFrame, read: list[str], predicted: pd.DataFrame) -> tuple[pd.DataFrame, list[str]]:
    """Recordings and their readings by the names of the prediction, without what the model leaves out.

    A diagnosis of positions leaves orientations of targets out, and its model calls the positions of the target those
    of a point.
    """
    points = {f"measured_{axis}_m": f"p{axis}_m" for axis in "xyz"}
    names = {name: points[name] for name in read if name not in predicted and points.get(name) in predicted}
    return frame.rename(columns=names), [names.get(name, name) for name in read if names.get(name, name) in predicted]


def differences(measured: pd.DataFrame, predicted: pd.DataFrame) -> pd.DataFrame:
    """Measured minus predicted readings; of orientations, which are angles about fixed x, y, z, the rotation vector."""
    left = measured - predicted
    turns = [f"measured_r{axis}_rad" for axis in "xyz"]
    if set(turns) <= set(measured):
        there, here = (Rotation.from_euler("xyz", frame[turns].to_numpy()) for frame in (measured, predicted))
        left[turns] = (there * here.inv()).as_rotvec()
    return left


def decorrelated(left: pd.DataFrame, groups: pd.Series) -> pd.DataFrame:
    """Readings in their standard deviations whose rows share half of their variance in groups, made independent.

    Of n rows V = ½I + ½·11ᵀ has the inverse root √2·(I − (1 − 1/√(1 + n))·11ᵀ/n).
    """
    count = groups.map(groups.value_counts())
    return np.sqrt(2.0) * left.sub(left.groupby(groups).transform("mean").mul(1.0 - 1.0 / np.sqrt(1.0 + count), axis=0))


def reported_over(
    found: xd.IdentificationResult | xd.DiagnosisResult,
    left: pd.DataFrame,
    noise: pd.DataFrame,
    fitted: BoolArray,
    shared: pd.Series | None,
) -> float:
    """RMS of fitted rows by the written file over that of the report.

    Args:
        found: what the command found.
        left: readings minus what the file predicts.
        noise: the stated standard deviations, NaN where none are.
        fitted: rows that were fitted, shape (N,).
        shared: what names the unloaded reading that rows share; None where each has its own.
    """
    record = found.record
    accuracy = [one for one in (record.get("arm") or {}).get("accuracy", []) if one["rows"] == "fitted"]
    if accuracy:
        columns = [name for name in map(str, left) if not name.endswith("_rad")]
        squares = (left.loc[fitted, columns].dropna(how="all") ** 2).sum(axis=1)
        return float(np.sqrt(squares.mean())) / accuracy[0]["after"]["rms"]
    says = record["fit"]["train_after"] if "train_after" in record["fit"] else record["fit"]["rms"]
    aside = [line - 2 for effect in record.get("effects", []) for line in effect.get("rows", [])]
    counts = fitted & ~np.isin(np.arange(len(left)), aside)
    whitened = (left / noise)[counts]
    if shared is not None:
        whitened = decorrelated(whitened, shared[counts])
    return float(np.sqrt(np.nanmean(whitened.to_numpy() ** 2))) / says


def once(case: Case, series: str, folder: Path, by: str) -> Outcome:
    """One file, in this process."""
    frame = in_si(in_series(pd.read_csv(folder / case.folder / f"{case.file}.csv"), series))
    return gone_through(folder / case.folder / case.robot, frame, case.name, series, by)


def gone_through(robot: RobotInput, frame: pd.DataFrame, name: str, series: str, by: str) -> Outcome:
    """Recordings in SI units through a command, its file and `predict`."""
    held = (frame["split"] == "test").to_numpy() if "split" in frame else np.zeros(len(frame), dtype=bool)
    known = {"name": name, "series": series, "rows": len(frame), "held_out": int(held.sum()), "by": by}
    began = time.process_time()
    with tempfile.TemporaryDirectory() as scratch:
        try:
            found = COMMANDS[by](robot, frame)
            found.save(Path(scratch) / "found")
            read = [str(name) for name in frame if re.fullmatch(MEASURED, str(name))]
            model = Path(scratch) / "found" / "model.yaml"
            predicted = xd.predict(model, frame.drop(columns=read), readings=True).frame
            stds = yaml.safe_load(model.read_text(encoding="utf-8")).get("reading_std", {})
        except xd.ExpdesignError as error:
            return Outcome(**known, cpu=time.process_time() - began, refused=str(error))  # type: ignore[arg-type]
    cpu = time.process_time() - began
    frame, read = answered(frame, read, predicted)
    columns = of_deviations(read)
    left, deviations = differences(frame[read], predicted[read]), predicted[columns].to_numpy()
    noise = pd.DataFrame({name: frame.get(own, stds.get(own, np.nan)) for name, own in zip(read, columns, strict=True)},
                         index=frame.index)  # fmt: skip
    judged = np.abs(left.to_numpy()[held])
    return Outcome(
        **known,  # type: ignore[arg-type]
        cpu=cpu,
        verdict=found.record["verdict"] if by == "diagnose" else found.record["statement"]["verdict"],
        error=float(np.sqrt(np.nanmean((judged / noise.to_numpy()[held]) ** 2))),
        inside=float((judged <= WITHIN * deviations[held])[np.isfinite(judged)].mean()) if held.any() else float("nan"),
        endless=float((~np.isfinite(deviations[held])).mean()),
        widest=float(np.nanmedian(deviations[held] / noise.to_numpy()[held])),
        written=reported_over(found, left, noise, ~held, frame.get("reference")),
    )


def apart(case: Case, series: str, folder: Path, by: str) -> Outcome:
    """One file, in a process of its own."""
    with tempfile.NamedTemporaryFile(suffix=".csv") as answer:
        arguments = [sys.executable, "-m", "research.benchmarks.real_sets", str(folder), "--out", answer.name]
        arguments += ["--only", case.name, "--series", series, "--by", by, "--once"]
        limited = ["prlimit", f"--cpu={LIMIT}", *arguments] if sys.platform == "linux" else arguments
        done = subprocess.run(limited, env={**os.environ, **ONE_THREAD}, capture_output=True, text=True, check=False)
        if done.returncode:
            last = (done.stderr.strip().splitlines() or [""])[-1]
            why = f"ended after {LIMIT} s of processor time" if done.returncode < 0 else last
            return Outcome(case.name, series, refused=why, by=by)
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
    judged = [o for o in gone if o.held_out]
    good = sum(0.90 <= o.inside <= 0.98 for o in judged)
    same = sum(abs(o.written - 1.0) <= SAME for o in gone)
    lines += [
        f"Gone to the end: {len(gone)} of {len(outcomes)}; "
        f"90 to 98 % of held-out readings inside: {good} of {len(judged)}; "
        f"fitted rows by the written file as the report says, to {SAME:.0%}: {same} of {len(gone)}.",
        "",
        "| recordings | rows | held out | series | by | CPU, s | verdict | RMS, stated s | inside 95 % | s over stated "
        "| file over report |",
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for o in outcomes:
        begins = f"| {o.name} | {o.rows} | {o.held_out} | {o.series} | {o.by} | {o.cpu:.0f} |"
        if o.refused:
            lines.append(f"{begins} refused: {o.refused.rsplit('/', 1)[-1].replace('|', '/')} | | | | |")
            continue
        endless = f" ({o.endless:.0%} without end)" if o.endless else ""
        inside = f"{100.0 * o.inside:.0f} %{endless}" if o.held_out else "–"
        lines.append(f"{begins} {o.verdict} | {o.error:.3g} | {inside} | {o.widest:.3g} | {o.written:.3f} |")
    return "\n".join([*lines, ""])


def main(arguments: list[str] | None = None) -> int:
    """Work on all files, or on some, and write the table as CSV and as a page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--out", type=Path, required=True, help="table and page, without ending")
    parser.add_argument("--only", nargs="*", default=[], help="names of files as in the page")
    parser.add_argument("--by", nargs="*", default=["diagnose"], choices=list(COMMANDS))
    parser.add_argument("--series", nargs="*", default=list(SERIES), choices=SERIES)
    parser.add_argument("--once", action="store_true", help="one file in this process")
    options = parser.parse_args(arguments)
    if not options.folder.is_dir():
        print(f"{options.folder}: there is no such folder", file=sys.stderr)
        return 2
    here = [case for case in (*CASES, *REPORTED) if (options.folder / case.folder).is_dir()]
    cases = [case for case in here if not options.only or case.name in options.only]
    if options.once:
        write_outcomes(options.out, [once(cases[0], options.series[0], options.folder, options.by[0])])
        return 0
    outcomes: list[Outcome] = []
    for case, by, series in itertools.product(cases, options.by, options.series):
        outcomes.append(apart(case, series, options.folder, by))
        print(outcomes[-1], flush=True)
        write_outcomes(options.out.with_suffix(".csv"), outcomes)
        options.out.with_suffix(".md").write_text(page(outcomes), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())

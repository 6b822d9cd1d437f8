"""Five folds over poses: the nominal robot, a plain least-squares script, and `identify`, on the same rows.

    python -m benchmarks.arms_positions [--out FILE] [ROBOT.yaml RECORDINGS.csv]...

Without files a simulated six-axis arm is used (pinocchio, elastic joints) with 30, 120 and 700 positions of three
markers. The script is what a laboratory writes with scipy: zeros and frames of all joints, instrument and markers by
`least_squares` with forward differences and a step tolerance, without compliance, weights or priors; redundant
parameters are left to the trust region.
"""

import argparse
import time
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pandas as pd
from benchmarks.arms.plant import recordings, usual_faults
from scipy.optimize import least_squares

import expdesign as xd
from expdesign.app.api.inputs import RobotFile, robot_of, table_of
from expdesign.chain.chain import Chain
from expdesign.chain.component import GEOMETRY
from expdesign.chain.effects.joints.geometry import CalibratedGeometryError
from expdesign.chain.readings.choice import reading_of
from expdesign.chain.recordings.reader import recordings_from_table
from expdesign.chain.row import row_data
from expdesign.errors import ExpdesignError
from expdesign.estimation.accuracy import nominal_readings, pose_folds

Array = npt.NDArray[np.float64]
FOLDS = 5


def by_script(machine: RobotFile, frame: pd.DataFrame) -> Array:
    """Errors (N, 3) of the rows marked `test` by the script."""
    robot = machine.robot
    rows = recordings_from_table(table_of(frame, "rows"), robot)
    chain = Chain(robot, (CalibratedGeometryError(robot, GEOMETRY),), reading=reading_of(robot, rows))
    start = chain.start()
    start[: chain.compliances] = 0.0
    train = row_data(rows.rows(~rows.test), robot)

    def residuals(values: Array) -> Array:
        whole = np.concatenate([start[: chain.compliances], values])
        return 1e3 * (rows.deflections[~rows.test] - chain.predict(train, whole)).ravel()

    found = least_squares(residuals, start[chain.compliances :], x_scale="jac", xtol=1e-10)
    values = np.concatenate([start[: chain.compliances], found.x])
    test = rows.rows(rows.test)
    return test.deflections - chain.predict(row_data(test, robot), values)


def by_program(machine: RobotFile, frame: pd.DataFrame) -> Array:
    """Errors (N, 3) of the rows marked `test` by `identify`."""
    found = xd.identify(machine, frame)
    rows = found.result.recordings
    test = rows.rows(rows.test)
    return test.deflections - found.result.fit.chain.predict(row_data(test, machine.robot), found.result.fit.values)


def compared(name: str, file: Path, frame: pd.DataFrame) -> list[dict[str, object]]:
    """A line for each way: RMS, mean and largest distance over all folds (mm), and processor time of a fit (s)."""
    machine = robot_of(file)
    rows = recordings_from_table(table_of(frame, "rows"), machine.robot)
    folds = pose_folds(rows, FOLDS)[np.argsort(rows.lines, kind="stable")]
    errors: dict[str, list[Array]] = {"nominal": [], "script": [], "identify": []}
    seconds = dict.fromkeys(errors, 0.0)
    for fold in range(FOLDS):
        marked = frame.assign(split=np.where(folds == fold, "test", "train"))
        read = recordings_from_table(table_of(marked, "rows"), machine.robot)
        chain = Chain(machine.robot, (), reading=reading_of(machine.robot, read))
        for way, parts in errors.items():
            begun = time.process_time()
            try:
                if way == "nominal":
                    parts.append((read.deflections - nominal_readings(chain, read))[read.test])
                else:
                    parts.append((by_script if way == "script" else by_program)(machine, marked))
            except ExpdesignError as error:
                print(name, way, error)
            seconds[way] += time.process_time() - begun
    lines: list[dict[str, object]] = []
    for way, parts in errors.items():
        if not parts:
            continue
        sizes = 1e3 * np.linalg.norm(np.concatenate(parts), axis=1)
        figures = {"rms_mm": np.sqrt((sizes**2).mean()), "mean_mm": sizes.mean(), "max_mm": sizes.max()}
        lines.append({"set": name, "rows": len(frame), "way": way, **figures, "seconds": seconds[way] / FOLDS})
    return lines


def main() -> None:
    """The table, on standard output and where `--out` says."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    lines = []
    if given.files:
        for robot, table in zip(given.files[::2], given.files[1::2], strict=True):
            lines += compared(table.stem, robot, pd.read_csv(table))
    else:
        for count in (30, 120, 700):
            frame = recordings(usual_faults(3, tool=0.0), count, 5)
            lines += compared(f"UR5, {count} positions", Path("configs/robots/ur5.yaml"), frame)
    text = pd.DataFrame(lines).to_csv(index=False, float_format="%.4g")
    print(text)
    if given.out is not None:
        given.out.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()

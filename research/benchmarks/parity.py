"""Whether two states of the program say the same: criteria, identifications, and what each command loads.

python -m research.benchmarks.parity OLD_SRC [--json FILE]

OLD_SRC is the folder `src` of another checkout. Of every shipped configuration a plan is drawn at random and recorded
by this state; both states then evaluate that plan (`evaluate --json`) and identify the robot from those recordings
(`identify`), each in a process of its own that imports its own package. The table gives the largest relative
difference of any number; what only one of the states says is counted beside it. A second table counts the modules of
the package that each command has loaded.
"""

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from expdesign.io.yaml_reader import read_yaml
from expdesign.planning.problem_file import read_problem
from expdesign.planning.result import plan_of

ROOT = Path(__file__).resolve().parents[2]
SAME = 1e-9
"""Relative difference within which two figures are the same."""
TINY = 1e-30
"""Below this, numbers of any unit are zero."""

WORKER = """
import contextlib, io, json, sys
try:
    from expdesign.app.commands.main import main
except ImportError:  # before the nine rooms
    from expdesign.commands.main import main
for line in sys.stdin:
    out = io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(io.StringIO()) as err:
        try:
            main(json.loads(line))
            code = 0
        except SystemExit as end:
            code = end.code or 0
    loaded = sum(name.split('.')[0] == 'expdesign' for name in sys.modules)
    sys.__stdout__.write(json.dumps([code, out.getvalue(), err.getvalue(), loaded]) + '\\n')
    sys.__stdout__.flush()
"""


class State:
    """One state of the program, which runs commands in one process.

    Args:
        source: its folder `src`.
    """

    def __init__(self, source: Path) -> None:
        environment = {**os.environ, "PYTHONPATH": str(source), "OPENBLAS_NUM_THREADS": "1"}
        self._process = subprocess.Popen(
            [sys.executable, "-c", WORKER], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment
        )

    def run(self, *arguments: str | Path) -> tuple[str, int]:
        """Standard output of a command, and how many modules of the package are loaded then.

        Raises:
            RuntimeError: the command failed, with its message.
        """
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(json.dumps([str(argument) for argument in arguments]) + "\n")
        self._process.stdin.flush()
        code, out, said, loaded = json.loads(self._process.stdout.readline())
        if code:
            raise RuntimeError(said.strip().splitlines()[-1])
        return out, loaded

    def close(self) -> None:
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait()


def numbers(content: Any, key: str = "") -> Iterator[tuple[str, float]]:
    """The numbers in a JSON document, each with its path."""
    if isinstance(content, dict):
        for name, value in content.items():
            if name == "hidden":
                continue
            yield from numbers(value, f"{key}/{name}")
    elif isinstance(content, list):
        for index, value in enumerate(content):
            yield from numbers(value, f"{key}/{index}")
    elif isinstance(content, int | float) and not isinstance(content, bool):
        yield key, float(content)


def difference(old: Any, new: Any) -> tuple[float, str, int]:
    """Largest difference of two JSON documents' numbers, its path, and how many paths only one of them has.

    What MEIR found worst (`hidden`) is left out: it ends where its search ends.

    A difference is relative to the larger of the two numbers, or, within a list, to the largest of the list: an entry
    of a matrix that is zero but for rounding has no digits of its own.
    """
    before, after = dict(numbers(old)), dict(numbers(new))
    scale: dict[str, float] = {}
    for key, value in before.items():
        if math.isfinite(value):
            scale[_table(key)] = max(scale.get(_table(key), TINY), abs(value))
    worst, where = 0.0, ""
    for key in before.keys() & after.keys():
        one, other = before[key], after[key]
        if one == other or (math.isnan(one) and math.isnan(other)):
            continue
        apart = abs(one - other) / scale.get(_table(key), TINY)
        if not apart <= worst:
            worst, where = apart, key
    return worst, where, len(before.keys() ^ after.keys())


def _table(key: str) -> str:
    """The path of the list of lists in which a number stands, or its own."""
    return "/".join(part for part in key.split("/") if not part.isdigit())


def drawn_plan(config: Path, file: Path) -> None:
    """A plan of random usable measurements of a configuration, written to a file; the seed is fixed."""
    problem = read_problem(config)
    drawn = problem.space.sample(4000, np.random.default_rng(0))
    poses, _ = problem.space.decode(drawn)
    usable = drawn[problem.loaded.robot.usable(poses)][: problem.space.measurements]
    plan_of(problem, usable).to_csv(file, index=False)


def figures(state: State, config: Path, robot: Path, plan: Path, recordings: Path, folder: Path) -> dict[str, Any]:
    """What one state says of a configuration's plan, and of its recordings; a failure is said in words."""
    said: dict[str, Any] = {}
    try:
        said["criteria"] = json.loads(state.run("evaluate", config, plan, "--json")[0])
    except RuntimeError as error:
        said["criteria"] = {"failed": str(error)}
    try:
        state.run("identify", robot, recordings, "--out", folder)
        said["identification"] = json.loads((folder / "identification.json").read_text())
    except RuntimeError as error:
        said["identification"] = {"failed": str(error)}
    return said


def configurations() -> list[Path]:
    """The shipped run configurations."""
    files = [*sorted((ROOT / "configs").glob("*.yaml")), *sorted((ROOT / "configs/studies").glob("*.yaml"))]
    return [file for file in files if "\nrobot:" in file.read_text() and "\ntargets:" in file.read_text()]


def robot_file(config: Path, folder: Path) -> Path:
    """The robot's file that a configuration names, or one with the mapping that it holds."""
    document = read_yaml(config)
    robot = document.content["robot"]
    if isinstance(robot, str):
        return (config.parent / robot).resolve()
    if "urdf" in robot:
        robot = {**robot, "urdf": str((config.parent / robot["urdf"]).resolve())}
    file = folder / "robot.yaml"
    file.write_text(json.dumps(robot))
    return file


def compared(old: Path, folder: Path) -> list[dict[str, Any]]:
    """One row for each configuration: the largest differences, and whether both say the same."""
    states = {"old": State(old), "new": State(ROOT / "src")}
    rows: list[dict[str, Any]] = []
    for config in configurations():
        work = folder / config.stem
        work.mkdir()
        plan, recordings = work / "plan.csv", work / "recordings.csv"
        row: dict[str, Any] = {"configuration": str(config.relative_to(ROOT))}
        try:
            drawn_plan(config, plan)
            states["new"].run("simulate", config, plan, "--out", recordings)
        except (RuntimeError, ValueError) as error:
            rows.append({**row, "failed": str(error)})
            continue
        said = {
            name: figures(state, config, robot_file(config, work), plan, recordings, work / name)
            for name, state in states.items()
        }
        for part in ("criteria", "identification"):
            one, other = said["old"][part], said["new"][part]
            row[part], row[f"{part}_at"], row[f"{part}_only"] = difference(one, other)
            if "failed" in one or "failed" in other:
                row[part] = 0.0 if one == other else math.inf
                row[f"{part}_at"] = one.get("failed", other.get("failed"))
        rows.append(row)
        print(_line(row), flush=True)
    for state in states.values():
        state.close()
    return rows


def _line(row: dict[str, Any]) -> str:
    if "failed" in row:
        return f"{row['configuration']:45s} {row['failed']}"
    parts = [f"{row[part]:8.1e} {row[f'{part}_only']:4d} {row[f'{part}_at'][:42]:42s}"
             for part in ("criteria", "identification")]  # fmt: skip
    return f"{row['configuration']:45s} {'  '.join(parts)}"


def modules(source: Path) -> dict[str, int]:
    """How many modules of the package each command has loaded at the end of a short job."""
    configs, found = ROOT / "configs", {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        plan, recordings, model = folder / "plan.csv", folder / "recordings.csv", folder / "identified/model.yaml"
        drawn_plan(configs / "bipod.yaml", plan)
        robot, config = configs / "robots/bipod.yaml", configs / "bipod.yaml"
        jobs: dict[str, tuple[str | Path, ...]] = {
            "--version": (),
            "simulate": (config, plan, "--out", recordings),
            "check": (config,),
            "evaluate": (config, plan, "--json"),
            "identify": (robot, recordings, "--out", folder / "identified"),
            "predict": (model, recordings, "--out", folder / "predicted.csv"),
            "compensate": (model, plan, "--out", folder / "commands.csv"),
            "diagnose": (robot, recordings, "--out", folder / "diagnosed"),
            "next": (config, recordings, "--out", folder / "next.csv"),
            "physics": (robot,),
        }
        for command, arguments in jobs.items():
            state = State(source)
            try:
                found[command] = state.run(command, *arguments)[1]
            except RuntimeError as error:
                print(f"{command}: {error}", file=sys.stderr)
            state.close()
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old", type=Path, help="folder `src` of the other state")
    parser.add_argument("--json", type=Path, help="file for the tables")
    asked = parser.parse_args()
    print("configuration; of criteria and of identifications: largest relative difference, numbers of one only, where")
    with tempfile.TemporaryDirectory() as folder:
        rows = compared(asked.old.resolve(), Path(folder))
    loaded = {name: modules(source) for name, source in (("old", asked.old.resolve()), ("new", ROOT / "src"))}
    print("\ncommand: modules of the package loaded, old and new")
    for command in loaded["new"]:
        print(f"{command:12s} {loaded['old'].get(command, 0):5d} {loaded['new'][command]:5d}")
    if asked.json is not None:
        asked.json.write_text(json.dumps({"same": SAME, "rows": rows, "modules": loaded}, indent=1))
    same = [row for row in rows if all(row.get(part, math.inf) <= SAME for part in ("criteria", "identification"))]
    print(f"\n{len(same)} of {len(rows)} configurations agree to {SAME:g}")


if __name__ == "__main__":
    main()

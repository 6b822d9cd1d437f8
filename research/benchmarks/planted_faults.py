"""Which fast tests catch faults that are planted in a copy of the sources: signs, factors, swapped axes.

    python -m research.benchmarks.planted_faults

Every fault is one changed line. It is planted in a copy of the package, the fast tests are run on it until one fails,
and the first test that fails is printed; a fault that no test notices makes the script end with status 1. Tests of the
room in which the fault lies are run first.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
FOLDERS = ("configs", "docs", "research", "results", "src", "tests")
FILES = ("conftest.py", "pyproject.toml")


@dataclass(frozen=True)
class Fault:
    """One changed line.

    Attributes:
        what: is wrong.
        file: below `src/expdesign`.
        right: the text that is replaced, which stands there once.
        wrong: what is planted.
        tests: folders below `tests` that are run, those of the room first.
    """

    what: str
    file: str
    right: str
    wrong: str
    tests: tuple[str, ...]


FAULTS = (
    Fault(
        "the moment of a payload has the wrong sign",
        "mechanics/loads/load.py",
        "moment(rotation @ parameters[1 : 1 + lever], force)",
        "-moment(rotation @ parameters[1 : 1 + lever], force)",
        ("loads", "elastostatics", "criteria"),
    ),
    Fault(
        "rotations about fixed axes are composed the other way round",
        "mechanics/robots/orientation.py",
        "return about_z @ about_y @ about_x",
        "return about_x @ about_y @ about_z",
        ("robots", "elastostatics"),
    ),
    Fault(
        "forces in the actuators come from the pose Jacobian",
        "mechanics/elastostatics/maps.py",
        "@ jacobians.forward)[..., 0, :]",
        "@ jacobians.pose)[..., 0, :]",
        ("elastostatics", "robots", "identification"),
    ),
    Fault(
        "gravity is tilted about y and x instead of x and y",
        "mechanics/loads/load.py",
        "ca.cross(ca.vertcat(angles[0], angles[1], 0.0), vector)",
        "ca.cross(ca.vertcat(angles[1], angles[0], 0.0), vector)",
        ("loads", "elastostatics", "criteria"),
    ),
    Fault(
        "a shared reference carries all of the noise instead of half",
        "planning/deflection_noise.py",
        "np.linalg.cholesky(0.5 * (np.eye(series.shape[-1]) + same))",
        "np.linalg.cholesky(1.0 * (np.eye(series.shape[-1]) + same))",
        ("instrument", "criteria", "elastostatics"),
    ),
    Fault(
        "total adds noise and load errors without their squares' sum: load errors count twice",
        "planning/criteria/accuracy.py",
        "variance = assessment.noise_variance + assessment.force_variance",
        "variance = assessment.noise_variance + 2.0 * assessment.force_variance",
        ("criteria", "comparison", "commands"),
    ),
    Fault(
        "a leg gets shorter when it is warmed",
        "chain/effects/environment/thermal_drift.py",
        "return _shifts(at, theta * at.place, time=time)",
        "return _shifts(at, -theta * at.place, time=time)",
        ("chain", "diagnosis"),
    ),
    Fault(
        "compensation adds the deflection instead of taking it off",
        "estimation/compensation/compensate.py",
        "commands = wanted - deflections",
        "commands = wanted + deflections",
        ("compensation", "commands"),
    ),
    Fault(
        "units are divided by their factor when a file is read",
        "io/units.py",
        "return float(_decimal(number) * self.factor + self.offset)",
        "return float(_decimal(number) / self.factor + self.offset)",
        ("files", "commands"),
    ),
    Fault(
        "the rows of a file are sorted the wrong way when results are written",
        "estimation/compensation/prediction.py",
        'order = np.argsort(points.lines, kind="stable")',
        'order = np.argsort(-points.lines, kind="stable")',
        ("compensation", "commands", "api"),
    ),
)


def caught_by(fault: Fault, folder: Path) -> str:
    """The first test that fails with the fault in a copy of the project; empty where none does."""
    for name in FOLDERS:
        if (ROOT / name).exists():
            shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in FILES:
        shutil.copy(ROOT / name, folder)
    path = folder / "src" / "expdesign" / fault.file
    text = path.read_text(encoding="utf-8")
    if text.count(fault.right) != 1:
        raise SystemExit(f"{fault.file} does not have `{fault.right}` once: the list of faults is out of date")
    path.write_text(text.replace(fault.right, fault.wrong), encoding="utf-8")
    tests = [f"tests/{name}" for name in fault.tests]
    options = ["-x", "-q", "-m", "not slow", "-p", "no:cacheprovider", "-n", "0"]
    environment = os.environ | {"PYTHONPATH": str(folder / "src"), "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(
        [sys.executable, "-m", "pytest", *options, *tests],
        cwd=folder, env=environment, capture_output=True, text=True, check=False,
    )  # fmt: skip
    failed = [line for line in done.stdout.splitlines() if line.startswith(("FAILED ", "ERROR "))]
    return failed[0].split(" - ")[0] if failed else ""


def main() -> None:
    """Plant every fault and print what catches it."""
    missed = 0
    for fault in FAULTS:
        with tempfile.TemporaryDirectory() as folder:
            test = caught_by(fault, Path(folder))
        missed += not test
        print(f"{fault.what} ({fault.file}): {test or 'NOT CAUGHT'}", flush=True)
    print(f"{len(FAULTS) - missed} of {len(FAULTS)} caught")
    sys.exit(1 if missed else 0)


if __name__ == "__main__":
    main()

"""Sweeps that take a second, and executors in this process."""

import pickle
from collections.abc import Callable
from concurrent.futures import Executor, Future
from pathlib import Path
from typing import Any

import yaml

from expdesign.app.sweeps.store import TIMES
from expdesign.io.written import RECORD

CONFIGS = Path(__file__).parents[2] / "configs"

SMALL: dict[str, Any] = yaml.safe_load((CONFIGS / "bipod.yaml").read_text(encoding="utf-8")) | {
    "robot": str(CONFIGS / "robots/bipod.yaml"),
    "optimiser": {"population": 8, "generations": 2, "seed": 1, "polish": False},
}
SMALL["model_error"] = {"physics": ["leg_backlash"]}  # which is enough to have a file of what a plan hides
SMALL["experiment"] = SMALL["experiment"] | {"poses": {"grid": {"x_m": [-0.3, 0.3, 5], "y_m": [-0.3, 0.3, 5]}}}


def sweep_file(folder: Path, **content: object) -> Path:
    """A sweep of the bipod over a small grid of poses."""
    path = folder / "sweep.yaml"
    path.write_text(yaml.safe_dump({"schema_version": 1, "config": SMALL} | content, sort_keys=False))
    return path


class Sent(Executor):
    """Does what it is given at once, sent to and fro as to a worker; counts what it was given."""

    given = 0

    def submit(self, work: Callable[..., Any], /, *arguments: Any, **options: Any) -> "Future[Any]":
        type(self).given += 1
        found: Future[Any] = Future()
        there, sent = pickle.loads(pickle.dumps((work, arguments)))
        found.set_result(pickle.loads(pickle.dumps(there(*sent))))
        return found


def contents(folder: Path) -> dict[str, bytes]:
    """Every file below a folder but the times, and the record that names the sweep's file."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.name not in (TIMES, RECORD)
    }

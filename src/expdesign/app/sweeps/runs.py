"""The runs of a sweep, each with the resolved configuration that makes it what it is.

A sweep stands in YAML: a configuration, and which of its keys take which values.

    schema_version: 1
    config: hexapod-h1.yaml
    vary:                                    # every combination of these (a grid)
      experiment.measurements: [4, 6, 8]
      optimiser.seed: {from: 1, to: 5}
    cases:                                   # and of these, each a set of values that belong together
      - {robot: robots/hexapod-h1.yaml, experiment.load.mass_kg: 26.5}
      - {robot: robots/other.yaml, experiment.load.mass_kg: 40}

A run is also what computes it: the rooms that its numbers come from, and the libraries. The number of a version says
neither what a checkout with changes computed, nor that two versions compute the same.
"""

import copy
import hashlib
import itertools
import json
import re
import sys
from dataclasses import dataclass
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Discriminator, Field, Tag, model_validator

from expdesign.errors import InputError
from expdesign.io.kinds import require_kind
from expdesign.io.schema import LARGEST_COUNT, Count, Section, invalid, validate
from expdesign.io.yaml_reader import YamlDocument
from expdesign.mechanics.robots.robot import Robot
from expdesign.planning.found_robot import robot_of
from expdesign.planning.problem_file import problem_from_document, resolved_config
from expdesign.plugins import extensions

LIBRARIES = ("autograd", "casadi", "moocore", "numpy", "pandas", "pymoo", "scipy")
"""On whose versions the numbers depend."""
ROOT = Path(__file__).parents[2]
_DECIDE = (
    "*.py", "io/**/*.py", "mechanics/**/*.py", "chain/**/*.py", "estimation/**/*.py", "planning/**/*.py",
    "assurance/acceptance/*.py", "assurance/model_error/*.py", "app/api/run.py",
)  # fmt: skip
"""Modules whose code decides about the numbers of a run; others say, draw, judge recordings or carry them."""


@lru_cache(maxsize=1)
def computed_by() -> dict[str, str]:
    """Digest of the code (`code`), and versions of Python, the libraries and installed extensions, by their names."""
    found = {"code": code_digest(), "python": ".".join(map(str, sys.version_info[:2]))}
    return found | {name: version(name) for name in LIBRARIES} | extensions()


def code_digest(root: Path = ROOT) -> str:
    """Digest of the modules below `root` (the package's folder) from which the numbers of a run come."""
    digest = hashlib.sha256()
    for name in modules(root):
        digest.update(name.encode() + (root / name).read_bytes())
    return digest.hexdigest()[:16]


def modules(root: Path = ROOT) -> list[str]:
    """Paths of these modules below `root`; the package's own file has no more than its version and names."""
    files = {file.relative_to(root).as_posix() for pattern in _DECIDE for file in root.glob(pattern)}
    return sorted(files - {"__init__.py", "__main__.py"})


class RangeSection(Section):
    """`vary.KEY` as a range of whole numbers, both ends included."""

    first: int = Field(alias="from", strict=True, description="First number.")
    last: int = Field(alias="to", strict=True, description="Last number, if a step meets it.")
    step: Count = Field(default=1, description="Step from one number to the next.")

    @model_validator(mode="after")
    def _not_empty(self) -> Self:
        if self.last < self.first:
            raise invalid(f"the range from {self.first} to {self.last} is empty", remedy="Swap them.")
        if (self.last - self.first) // self.step >= LARGEST_COUNT:
            raise invalid("the range has too many values", remedy=f"At most {LARGEST_COUNT}.")
        return self

    def values(self) -> list[int]:
        """The numbers."""
        return list(range(self.first, self.last + 1, self.step))


Values = Annotated[
    Annotated[list[Any], Tag("list")] | Annotated[RangeSection, Tag("range")],
    Discriminator(lambda value: "range" if isinstance(value, dict | RangeSection) else "list"),
]
"""Values as a list or as a range, distinguished by their brackets, so that messages fit the form that was meant."""


class SweepSection(Section):
    """A sweep."""

    schema_version: Literal[1] = Field(description="Version of this format.")
    config: str | dict[str, Any] = Field(description="The run configuration, or its content.")
    vary: dict[str, Values] = Field(
        default_factory=dict,
        description="Keys with dots (`experiment.measurements`) and their values: a list, or a range `{from: 1, to: "
        "5, step: 1}`. Every combination is run. Default: nothing varies.",
    )
    cases: list[dict[str, Any]] = Field(
        default_factory=list,
        description="Sets of values, each a mapping of keys with dots; each is run with every combination of `vary`. "
        "Default: one case, the configuration as it is.",
    )

    @model_validator(mode="after")
    def _something(self) -> Self:
        for key, values in self.vary.items():
            if isinstance(values, list) and not values:
                raise invalid("there is no value", f"vary.{key}", "Name at least one.")
        if not self.vary and not self.cases:
            raise invalid("nothing varies", remedy="Name a key under `vary`, or a case under `cases`.")
        return self


_KEY = re.compile(r"[^.\[\]]+|\[\d+\]")
MOST_RUNS = 100_000
"""Of one sweep; more are a slip in its ranges."""


@dataclass(frozen=True)
class SweepRun:
    """One run.

    Attributes:
        number: from 1, in the order of the sweep.
        values: what is varied, by its dotted key, as the sweep names it.
        config: the configuration as resolved; beside it only the program and its libraries decide.
        identity: digest of `config` and of what computes it (`computed_by`).
    """

    number: int
    values: dict[str, Any]
    config: dict[str, Any]
    identity: str


def sweep_runs(document: YamlDocument) -> list[SweepRun]:
    """The runs of a sweep file: every case with every combination of the varied values, the last key fastest.

    Each value of each key is tried in a whole problem, so that what is wrong is said before the first run starts.

    Raises:
        InputError: the sweep, its configuration, or a value is wrong.
        SingularConfigurationError: the robot is singular at a target.
    """
    require_kind(document, "sweep")
    sweep = validate(SweepSection, document)
    runs, robots, tried = [], _Robots(), set[str]()
    base = _base(sweep, robots)
    for number, values in enumerate(_combinations(sweep), start=1):
        described = ", ".join(f"{key} = {text_of(value)}" for key, value in values.items())
        source = f"{document.source}, run {number} ({described})"
        content = copy.deepcopy(base)
        for key, value in values.items():
            _put(content, key, _here(key, value, document.folder, robots, source), source)
        part = YamlDocument(source, Path(), content)
        config = resolved_config(part, robots.robot(content["robot"], source))
        fresh = {f"{key} = {text_of(value)}" for key, value in values.items()} - tried
        if fresh:
            tried |= fresh
            problem_from_document(part)
        runs.append(SweepRun(number, values, config, identity(config)))
    return runs


def identity(config: dict[str, Any]) -> str:
    """Identity of a run: the digest of its resolved configuration and of what computes it.

    Of a robot in a file of its own (URDF) the content counts, and not where it lies.
    """
    robot = config["robot"]
    if isinstance(robot.get("urdf"), str):
        digest = hashlib.sha256(Path(robot["urdf"]).read_bytes()).hexdigest()
        config = config | {"robot": robot | {"urdf": digest}}
    text = json.dumps({"config": config, "computed_by": computed_by()}, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def text_of(value: Any) -> str:
    """A value as `sweep.csv` and messages show it."""
    return value if isinstance(value, str) else json.dumps(value)


def _base(sweep: SweepSection, robots: "_Robots") -> dict[str, Any]:
    """The configuration that is varied, its robot read in and its paths made independent of where it lies."""
    found = sweep.where("config").written_out
    require_kind(found, "run configuration")
    if not isinstance(found.content, dict):
        raise found.where().fault("a run configuration is needed here", "See `expdesign new`.")
    content = copy.deepcopy(found.content)
    for key in ("robot", "experiment.poses.candidates"):
        value = _get(content, key)
        if value is not None:
            _put(content, key, _here(key, value, found.folder, robots, found.source), found.source)
    return content


def _combinations(sweep: SweepSection) -> list[dict[str, Any]]:
    lists = [v.values() if isinstance(v, RangeSection) else v for v in sweep.vary.values()]
    count = max(len(sweep.cases), 1)
    for values in lists:
        count *= len(values)
    if count > MOST_RUNS:
        raise sweep.where().fault(f"these are {count} runs", f"At most {MOST_RUNS}.")
    for index, case in enumerate(sweep.cases):
        for key in case:
            if key in sweep.vary:
                raise sweep.where("cases", index, key).fault("this key is also under `vary`", "Keep one of them.")
    grid = [dict(zip(sweep.vary, values, strict=True)) for values in itertools.product(*lists)]
    return [case | values for case in (sweep.cases or [{}]) for values in grid]


class _Robots:
    """Robots by their files and by their content, each read once."""

    def __init__(self) -> None:
        self._contents: dict[Path, Any] = {}
        self._robots: dict[str, Robot] = {}

    def content(self, path: Path, source: str) -> Any:
        """The mapping in the file of a robot."""
        if path not in self._contents:
            document = YamlDocument(source, path.parent, path.name, prefix=("robot",)).written_out
            content = document.content
            if isinstance(content, dict) and isinstance(content.get("urdf"), str):
                content = content | {"urdf": str((document.folder / content["urdf"]).resolve())}
            self._contents[path] = content
        return self._contents[path]

    def robot(self, content: Any, source: str) -> Robot:
        """The robot that a mapping describes."""
        key = json.dumps(content, sort_keys=True, default=str)
        if key not in self._robots:
            self._robots[key] = robot_of(YamlDocument(source, Path(), {"robot": content}).where("robot"))[0]
        return self._robots[key]


def _here(key: str, value: Any, folder: Path, robots: _Robots, source: str) -> Any:
    """A value of a file in a folder: a robot is read in, and another path is the same from everywhere."""
    if key == "robot" and isinstance(value, str):
        return robots.content(folder / value, source)
    return str(folder / value) if key == "experiment.poses.candidates" and isinstance(value, str) else value


def _keys(key: str) -> list[str | int]:
    """`targets[0].tolerance.dz_m` (or `targets.0…`) as the keys on the way."""
    return [
        int(part.strip("[]")) if part.startswith("[") or part.isdecimal() else part for part in _KEY.findall(key)
    ] or [key]


def _get(content: Any, key: str) -> Any:
    for part in _keys(key):
        if not isinstance(content, dict) or part not in content:
            return None
        content = content[part]
    return content


def _put(content: dict[str, Any], key: str, value: Any, source: str) -> None:
    """Set what stands at a dotted key; mappings on the way that are missing are made."""
    *way, last = _keys(key)
    place: Any = content
    for depth, part in enumerate([*way, last]):
        if isinstance(place, list):
            if not isinstance(part, int) or part >= len(place):
                remedy = f"There are {len(place)} entries, counted from 0."
                raise InputError(f"`{key}` is not in the configuration", where=source, remedy=remedy)
        elif not isinstance(place, dict):
            at = ".".join(str(part) for part in [*way, last][:depth])
            raise InputError(f"`{key}` is not in the configuration: `{at}` has no keys", where=source, remedy="Check.")
        if depth == len(way):
            place[part] = copy.deepcopy(value)
            return
        place = place[part] if isinstance(place, list) and isinstance(part, int) else place.setdefault(part, {})

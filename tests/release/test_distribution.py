"""The wheel, the source archive and `CITATION.cff`; the wheel alone, where nothing else is, plans a calibration."""

import datetime
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml

import expdesign as xd
from expdesign.app.templates import kinds
from expdesign.planning.result import versions
from tests.release.distribution import CODE, ROOT, Distribution, built


@pytest.fixture(scope="module")
def distribution(tmp_path_factory: pytest.TempPathFactory) -> Distribution:
    return built(tmp_path_factory.mktemp("distribution"))


def of_the_project(*folders: str) -> set[str]:
    """Files of folders but for what tools and runs left there."""
    made = re.compile(r"__pycache__|\.egg-info|results/runs/|results/[^/]*-run-|_cache/")
    files = (file for folder in folders for file in (ROOT / folder).rglob("*") if file.is_file())
    return {name for name in (str(file.relative_to(ROOT)) for file in files) if not made.search(name)}


def test_every_file_that_the_package_reads_is_in_the_wheel(distribution: Distribution) -> None:
    package = {name.removeprefix("src/") for name in of_the_project("src/expdesign")}
    assert package <= distribution.in_wheel
    templates = {str(file.relative_to(CODE)) for files in kinds().values() for file in files}
    assert templates <= package


def test_nothing_else_is_in_the_wheel(distribution: Distribution) -> None:
    folders = {name.split("/")[0] for name in distribution.in_wheel}
    assert {name for name in folders if not name.endswith(".dist-info")} == {"expdesign"}
    assert not [name for name in distribution.in_wheel if "__pycache__" in name]


def test_the_source_archive_is_the_project(distribution: Distribution) -> None:
    wanted = of_the_project("configs", "docs", "research", "results", "src", "tests")
    wanted |= {"CITATION.cff", "CHANGELOG.md", "Makefile", "constraints.txt", "pyproject.toml", ".ci/run"}
    assert wanted <= distribution.in_archive
    assert not [name for name in distribution.in_archive if re.search(r"__pycache__|-run-\d", name)]


def test_the_version_is_stated_once(distribution: Distribution) -> None:
    """In `src/expdesign/__init__.py`; the metadata, the names of the files and the records follow."""
    stated = [
        str(file.relative_to(ROOT))
        for file in [ROOT / "pyproject.toml", *CODE.rglob("*.py")]
        if re.search(rf'version\S* *= *"{re.escape(xd.__version__)}"', file.read_text(encoding="utf-8"))
    ]
    assert stated == ["src/expdesign/__init__.py"]
    assert f"\nVersion: {xd.__version__}\n" in distribution.metadata
    assert distribution.wheel.name.startswith(f"expdesign-{xd.__version__}-")
    assert distribution.archive.name == f"expdesign-{xd.__version__}.tar.gz"
    assert versions()["expdesign"] == xd.__version__


def test_running_needs_no_tool_of_development(distribution: Distribution) -> None:
    required = re.findall(r"^Requires-Dist: ([\w.-]+)(.*)$", distribution.metadata, flags=re.MULTILINE)
    running = {name.lower() for name, rest in required if "extra" not in rest}
    assert {"numpy", "scipy", "casadi", "pymoo", "plotly"} <= running
    assert not running & {"pytest", "mypy", "ruff", "exudyn", "matplotlib", "dask", "distributed", "selenium"}


@pytest.mark.slow
def test_the_wheel_plans_a_calibration_in_an_empty_environment(distribution: Distribution, tmp_path: Path) -> None:
    """Runtime dependencies alone, and no checkout in reach."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    place = tmp_path / "elsewhere"
    place.mkdir()

    def said(*command: object) -> str:
        words = [str(word) for word in command]
        done = subprocess.run(words, capture_output=True, text=True, cwd=place, env=environment, check=False)
        assert done.returncode == 0, f"{words}\n{done.stdout}{done.stderr}"
        return done.stdout

    said(sys.executable, "-m", "venv", tmp_path / "venv")
    binaries = tmp_path / "venv" / "bin"
    constraints = ROOT / "constraints.txt"
    said(binaries / "python", "-m", "pip", "install", "--quiet", "-c", constraints, distribution.wheel)
    assert said(binaries / "expdesign", "--version") == f"expdesign {xd.__version__}\n"
    origin = said(binaries / "python", "-c", "import expdesign; print(expdesign.__file__)")
    assert Path(origin.strip()).is_relative_to(tmp_path / "venv")
    for kind, files in kinds().items():
        said(binaries / "expdesign", "new", kind, "--out", place / kind)
        assert {file.name for file in (place / kind).iterdir()} >= {file.name for file in files}
    said(binaries / "expdesign", "run", "hexapod/config.yaml", "--out", "mine")
    names = {".expdesign.json", "pareto.csv", "plan.csv", "plan-checked.csv", "plans.csv", "report.html", "run.json"}
    assert {file.name for file in (place / "mine").iterdir()} == names
    said(binaries / "expdesign", "simulate", "hexapod/config.yaml", "mine/plan.csv", "--out", "recordings.csv")
    said(binaries / "expdesign", "identify", "hexapod/robot.yaml", "recordings.csv", "--out", "identified")
    said(binaries / "expdesign", "diagnose", "hexapod/robot.yaml", "recordings.csv", "--out", "diagnosed")
    shutil.rmtree(tmp_path / "venv")


FILE = Path(__file__).parents[2] / "CITATION.cff"


REQUIRED = {"authors", "cff-version", "message", "title"}


KNOWN = REQUIRED | {
    "abstract", "commit", "contact", "date-released", "doi", "identifiers", "keywords", "license", "license-url",
    "preferred-citation", "references", "repository", "repository-artifact", "repository-code", "type", "url",
    "version",
}  # fmt: skip


def people_of(work: dict[str, Any]) -> bool:
    """Whether a work has authors, each a person or an entity."""
    return bool(work["authors"]) and all({"name", "family-names"} & set(author) for author in work["authors"])


def test_the_file_has_the_keys_of_the_format() -> None:
    content = yaml.safe_load(FILE.read_text(encoding="utf-8"))
    assert REQUIRED <= set(content) <= KNOWN
    assert content["cff-version"] == "1.2.0"
    assert content["version"] == xd.__version__
    assert people_of(content)
    for work in content.get("references", []):
        assert {"authors", "title", "type"} <= set(work)
        assert people_of(work)
    if released := content.get("date-released"):
        datetime.date.fromisoformat(str(released))

"""The wheel and the source archive, built from a copy of what the project consists of."""

import os
import shutil
import subprocess
import sys
import tarfile
import zipfile
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
CODE = ROOT / "src"
_OF_THE_PROJECT = [
    "CHANGELOG.md",
    "CITATION.cff",
    "CONTRIBUTING.md",
    "MANIFEST.in",
    "Makefile",
    "README.md",
    "constraints.txt",
    "mkdocs.yml",
    "pyproject.toml",
    ".ci",
    "conftest.py",
    "research",
    "configs",
    "docs",
    "results",
    "src",
    "tests",
]
_BY_TOOLS = shutil.ignore_patterns("__pycache__", "*.egg-info", "*-run-*", "runs", ".*_cache")


@dataclass(frozen=True)
class Distribution:
    """What `python -m build` made."""

    wheel: Path
    archive: Path

    @property
    def in_wheel(self) -> set[str]:
        with zipfile.ZipFile(self.wheel) as file:
            return set(file.namelist())

    @property
    def in_archive(self) -> set[str]:
        """Files below the archive's only folder."""
        with tarfile.open(self.archive) as file:
            return {member.name.split("/", 1)[1] for member in file.getmembers() if member.isfile()}

    @property
    def metadata(self) -> str:
        with zipfile.ZipFile(self.wheel) as file:
            return file.read(next(name for name in file.namelist() if name.endswith("/METADATA"))).decode()


def built(folder: Path) -> Distribution:
    """The distribution, without a network: the backend is the one that is installed."""
    source, out = folder / "source", folder / "dist"
    source.mkdir()
    for name in _OF_THE_PROJECT:
        if (ROOT / name).is_dir():
            shutil.copytree(ROOT / name, source / name, ignore=_BY_TOOLS)
        else:
            shutil.copy(ROOT / name, source / name)
    command = [sys.executable, "-m", "build", "--no-isolation", "--outdir", str(out), str(source)]
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(command, capture_output=True, text=True, cwd=folder, env=environment, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    (wheel,), (archive,) = out.glob("*.whl"), out.glob("*.tar.gz")
    return Distribution(wheel, archive)

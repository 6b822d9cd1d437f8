"""Files that `expdesign new` writes: one folder per kind, found by its place."""

from pathlib import Path

_FOLDER = Path(__file__).parent
_POINTS_TO = {"sweep": "bipod"}
"""Kinds whose files point to `config.yaml`, and the kind that is written along where there is none."""


def kinds() -> dict[str, list[Path]]:
    """The files of every kind."""
    folders = sorted(path for path in _FOLDER.iterdir() if path.is_dir() and not path.name.startswith("_"))
    return {folder.name: sorted(file for file in folder.iterdir() if file.is_file()) for folder in folders}


def needed(kind: str, folder: Path) -> list[Path]:
    """The files of a kind, and those that they point to where the folder has none."""
    files = kinds()
    further = [] if kind not in _POINTS_TO or (folder / "config.yaml").exists() else files[_POINTS_TO[kind]]
    return [*files[kind], *further]

"""Files that `expdesign new` writes: one folder per kind, found by its place."""

from pathlib import Path

_FOLDER = Path(__file__).parent


def kinds() -> dict[str, list[Path]]:
    """The files of every kind."""
    folders = sorted(path for path in _FOLDER.iterdir() if path.is_dir() and not path.name.startswith("_"))
    return {folder.name: sorted(file for file in folder.iterdir() if file.is_file()) for folder in folders}

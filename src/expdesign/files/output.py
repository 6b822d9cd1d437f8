"""Writing results so that nobody ever meets a half-written one: write beside, then rename."""

import json
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from expdesign.errors import InputError


@contextmanager
def output_folder(folder: Path) -> Iterator[Path]:
    """A scratch folder beside `folder`; its files take their place in `folder` when the block ends well.

    Files that `folder` already holds under other names stay. If the block raises, `folder` is as it was.

    Raises:
        InputError: the folder cannot be made or written.
    """
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        if folder.exists() and not folder.is_dir():
            raise InputError("is a file, not a folder", where=str(folder), remedy="Name another folder.")
        scratch = Path(tempfile.mkdtemp(prefix=f".{folder.name}-", dir=folder.parent))
    except OSError as error:
        raise _cannot_write(folder, error) from None
    try:
        yield scratch
        if folder.exists():
            for file in sorted(scratch.iterdir()):
                os.replace(file, folder / file.name)
        else:
            scratch.chmod(0o755)
            os.replace(scratch, folder)
    except OSError as error:
        raise _cannot_write(folder, error) from None
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


def new_folder(name: str) -> Path:
    """A folder under `results/` that does not exist yet."""
    number = 1
    while (folder := Path("results") / f"{name}-run-{number}").exists():
        number += 1
    return folder


def require_writable(folder: Path) -> None:
    """Raise an `InputError` where a folder plainly cannot be made or written: before the work instead of after it."""
    try:
        above = folder
        while not above.exists():
            above = above.parent
    except OSError as error:
        raise _cannot_write(folder, error) from None
    if not above.is_dir():
        what = "is a file, not a folder" if above == folder else f"cannot be made, because {above} is a file"
        raise InputError(what, where=str(folder), remedy="Name another folder.")
    try:
        Path(tempfile.mkdtemp(prefix=f".{folder.name}-", dir=above)).rmdir()  # rights alone do not tell
    except OSError as error:
        what = f"cannot be written ({error.strerror or error} in {above})"
        raise InputError(what, where=str(folder), remedy="Name a place that is writable.") from None


def write_file(path: Path, text: str) -> None:
    """Write `text` to `path` in one step, making its folder where it is missing.

    Raises:
        InputError: the file cannot be written.
    """
    write_bytes(path, text.encode("utf-8"))


def write_bytes(path: Path, content: bytes) -> None:
    """Write `content` to `path` in one step; see `write_file`."""
    if path.is_dir():
        raise InputError("this is a folder, not a file", where=str(path), remedy="Name a file in it.")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, scratch = tempfile.mkstemp(prefix=f".{path.name}-", dir=path.parent)
        try:
            with os.fdopen(handle, "wb") as stream:
                stream.write(content)
            os.chmod(scratch, 0o644)
            os.replace(scratch, path)
        finally:
            Path(scratch).unlink(missing_ok=True)
    except OSError as error:
        raise _cannot_write(path, error) from None


def json_text(content: Any) -> str:
    """`content` as JSON; a NaN or an infinity in it is a defect and raises `ValueError`."""
    return json.dumps(content, indent=2, allow_nan=False) + "\n"


def _cannot_write(path: Path, error: OSError) -> InputError:
    remedy = "Name a place that exists and is writable, with room on the disk."
    return InputError(f"cannot be written ({error.strerror or error})", where=str(path), remedy=remedy)

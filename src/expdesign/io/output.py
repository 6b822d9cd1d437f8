"""Writing results so that nobody ever meets a half-written one: write beside, then rename.

Only regular files are renamed onto; devices and pipes are written to. Whether a file may be replaced is in `written`.

CSV text of a table, reproducible to the byte.
"""

import csv
import glob
import io
import json
import logging
import math
import os
import shutil
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from expdesign.errors import InputError
from expdesign.io.written import (
    Purpose,
    is_stream,
    note_written,
    require_free,
    require_free_names,
    require_regular,
)


def csv_text(frame: pd.DataFrame) -> str:
    """CSV text of a frame: shortest decimal numbers that read back as the same floats, line feeds."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(frame.columns)
    # Column by column: a table of numbers goes to Python's own types at once.
    columns = [[_cell(value) for value in frame.iloc[:, place].tolist()] for place in range(frame.shape[1])]
    writer.writerows(zip(*columns, strict=True))
    return stream.getvalue()


def _cell(value: object) -> str:
    if isinstance(value, bool | np.bool_):
        return "true" if value else "false"
    if isinstance(value, float | np.floating):
        return repr(float(value) + 0.0)
    return "" if value is None else str(value)


_SCRATCH = ".expdesign"
"""How the names of scratch folders end: `.NAME-xxxxxxxx.expdesign`."""
_OLD = 86400.0
"""s; a scratch folder as old was left behind by a process that was killed."""
_LOG = logging.getLogger(__name__)
"""Says on level DEBUG what has been written completely."""


@contextmanager
def output_folder(folder: Path, purpose: Purpose | None = None, *, force: bool = False) -> Iterator[Path]:
    """A scratch folder beside `folder`; its files take their place in `folder` when the block ends well.

    Files that `folder` already holds under other names stay. If the block raises, `folder` is as it was.

    Args:
        folder: for the files.
        purpose: for which they are written; without it whatever has their names is replaced.
        force: whether files that were written for another purpose are replaced as well.

    Raises:
        InputError: the folder cannot be made or written, or a file in it must not be replaced.
    """
    place = _resolved(folder)
    if place.exists() and not place.is_dir():
        raise InputError("is a file, not a folder", where=str(folder), remedy="Name another folder.")
    with _scratch(place, folder) as scratch:
        yield scratch
        names = sorted(file.name for file in scratch.iterdir())
        if purpose is not None:
            require_free_names(folder, names, purpose, force=force)
        if place.exists():
            for name in names:
                os.replace(scratch / name, (place / name).resolve())
            if purpose is not None:
                note_written(place, names, purpose)
        else:  # whoever is stopped leaves a whole folder, or none
            if purpose is not None:
                note_written(scratch, names, purpose, seen_from=place)
            scratch.chmod(0o755)
            os.replace(scratch, place)
        _LOG.debug("%s (%s)", folder, ", ".join(names))


def _resolved(path: Path) -> Path:
    """The place itself, where a path is a link; an `InputError` where links lead to themselves."""
    try:
        place = path.resolve()
    except (OSError, RuntimeError):
        place = path
    if place.is_symlink():  # none is left otherwise
        raise InputError("is a link that leads to itself", where=str(path), remedy="Name another place.")
    return place


@contextmanager
def _scratch(place: Path, shown: Path) -> Iterator[Path]:
    """A folder beside `place` for what is to take its place; it is removed when the block ends.

    Args:
        place: what is written.
        shown: the same in messages, also of what is written into the scratch folder.

    Raises:
        InputError: the scratch folder or something in it cannot be written.
    """
    with _refused(shown):
        place.parent.mkdir(parents=True, exist_ok=True)
        for left in place.parent.glob(f".{glob.escape(place.name)}-*{_SCRATCH}"):
            if time.time() - left.stat().st_mtime > _OLD:
                shutil.rmtree(left, ignore_errors=True)
        scratch = Path(tempfile.mkdtemp(prefix=f".{place.name}-", suffix=_SCRATCH, dir=place.parent))
        try:
            yield scratch
        except InputError as error:
            where = error.where.replace(str(scratch), str(shown))
            raise InputError(error.what, where=where, remedy=error.remedy) from None
        finally:
            shutil.rmtree(scratch, ignore_errors=True)


def output_file(path: Path, content: str | bytes, purpose: Purpose, *, force: bool = False) -> None:
    """Write a file in one step and enter it into the record of its folder.

    Raises:
        InputError: the file cannot be written, or must not be replaced.
    """
    require_free(path, purpose, force=force)
    write_file(path, content)
    if not is_stream(path):
        place = path.resolve()
        note_written(place.parent, [place.name], purpose)
    _LOG.debug("%s", path)


def new_folder(name: str) -> Path:
    """A folder under `results/` that does not exist yet."""
    number = 1
    while (folder := Path("results") / f"{name}-run-{number}").exists():
        number += 1
    return folder


def require_writable(folder: Path) -> None:
    """Raise an `InputError` where a folder plainly cannot be made or written: before the work instead of after it."""
    with _refused(folder):
        above = next(each for each in (folder, *folder.parents) if each.exists())
    if not above.is_dir():
        what = "is a file, not a folder" if above == folder else f"cannot be made, because {above} is a file"
        raise InputError(what, where=str(folder), remedy="Name another folder.")
    with _scratch(above / _resolved(folder).name, folder):  # rights alone do not tell
        pass


def write_file(path: Path, content: str | bytes) -> None:
    """Write a content to `path` in one step, making its folder where it is missing.

    Texts become UTF-8; what stands for bytes of a file's name that are none becomes `?`.

    Raises:
        InputError: the file cannot be written.
    """
    require_regular(path)
    data = content.encode("utf-8", "replace") if isinstance(content, str) else content
    if is_stream(path):
        with _refused(path):
            path.write_bytes(data)
        return
    place = _resolved(path)  # what a link points to is replaced, and not the link
    with _scratch(place, path) as scratch:
        (scratch / place.name).write_bytes(data)
        os.replace(scratch / place.name, place)


def json_text(content: Any) -> str:
    """`content` as JSON; a NaN or an infinity in it is a defect and raises `ValueError`."""
    return json.dumps(content, indent=2, allow_nan=False) + "\n"


def plain(value: Any) -> Any:
    """A value for JSON: arrays become lists, and what is not finite null."""
    kind = type(value)
    if kind is str or kind is int:  # nearly all that a page has
        return value
    if kind is float:
        return value if math.isfinite(value) else None
    if isinstance(value, list | tuple):
        return [plain(entry) for entry in value]
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    return value


@contextmanager
def _refused(path: Path) -> Iterator[None]:
    """Errors of the system where something is written, as an `InputError` about a path."""
    try:
        yield
    except OSError as error:
        remedy = "Name a place that exists and is writable, with room on the disk."
        raise InputError(f"cannot be written ({error.strerror or error})", where=str(path), remedy=remedy) from None

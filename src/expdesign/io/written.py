"""What this program wrote where, and for what, so that nothing else is ever replaced.

A folder in which files were written holds one record, `.expdesign.json`: for each of them the command, its main inputs
and the digest of the content. The record is apart from the files because a CSV file has no room for it (a comment would
be a row to other programs), and because the content alone cannot tell simulated recordings from measured ones. The
digest shows where somebody has written readings into a plan. The record moves with its folder; a file without an entry
counts as somebody else's.
"""

import hashlib
import json
import os
import stat
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from expdesign.errors import InputError
from expdesign.io.excel import is_excel_name, sheet_rows
from expdesign.io.table_text import Rows, decoded, separated

RECORD = ".expdesign.json"
"""Name of the record in a folder."""
_OF_A_SHEET = ("do", "plan_row")
"""Columns that only a laboratory sheet has."""
_READINGS = ("reading_", "measured_")
"""How the columns of a laboratory sheet begin that are filled in by hand."""
_HINT = "or give argument `force=True` to replace it."


@dataclass(frozen=True)
class Purpose:
    """What files are written for. The same command with the same main inputs may replace what it wrote.

    Attributes:
        command: that writes them.
        inputs: paths of its main inputs, whose content may change, or names of what was in memory.
    """

    command: str
    inputs: tuple[str, ...] = ()

    def seen_from(self, folder: Path) -> dict[str, Any]:
        """As a record in `folder` has it: the inputs relative to the folder, so that both can be moved together."""
        return {"command": self.command, "inputs": [_relative(each, folder) for each in self.inputs]}


def is_stream(path: Path) -> bool:
    """Whether a path is a character device or a pipe, which is written to and never replaced."""
    try:
        mode = path.stat().st_mode
    except OSError:
        return False
    return stat.S_ISCHR(mode) or stat.S_ISFIFO(mode)


def require_regular(path: Path) -> None:
    """Raise an `InputError` where something is there that is neither a file nor a stream: it is never renamed onto."""
    if os.path.exists(path) and not path.is_file() and not is_stream(path):
        if path.is_dir():
            raise InputError("this is a folder, not a file", where=str(path), remedy="Name a file in it.")
        raise InputError("this is neither a file nor a stream", where=str(path), remedy="Name another file.")


def require_free(path: Path, purpose: Purpose, *, force: bool = False) -> None:
    """Raise where a file must not be replaced: to be asked before the work as well as when it is written.

    Args:
        path: the file.
        purpose: for which it would be written.
        force: whether files of others are replaced as well. An input and a filled laboratory sheet never are.

    Raises:
        InputError: the file is an input, a filled sheet, no regular file, or there for another purpose.
    """
    if not os.path.exists(path) or is_stream(path):
        return
    require_regular(path)
    if any(os.path.exists(each) and os.path.samefile(path, each) for each in purpose.inputs):
        what = f"this is an input of `{purpose.command}`"
        raise InputError(what, where=str(path), remedy="Nothing was written. Name another file.")
    place = path.resolve()
    entry = entries(place.parent).get(place.name)
    changed = entry is None or entry.get("sha256") not in (None, _digest(place))
    about = purpose.seen_from(place.parent)
    if entry is not None and not changed and about == {key: entry[key] for key in about}:
        return
    if changed and _is_filled_sheet(place):
        what = "this is a laboratory sheet with readings in it, which is never replaced"
        raise InputError(what, where=str(path), remedy="Nothing was written. Name another folder.")
    if force or place.stat().st_size == 0:
        return
    what = "this file is there already"
    if entry is not None:
        inputs = ", ".join(entry["inputs"])
        made = f"`expdesign {entry['command']}`"
        what += f", changed since {made} wrote it" if changed else f", written by {made} from {inputs or 'nothing'}"
    raise InputError(what, where=str(path), remedy=f"Nothing was written. Name another place, {_HINT}")


def require_free_names(folder: Path, names: Iterable[str], purpose: Purpose, *, force: bool = False) -> None:
    """`require_free` of the files of a folder whose names match one of `names` (`*` for any characters)."""
    for name in names:
        for path in sorted(folder.glob(name)):
            require_free(path, purpose, force=force)


def note_written(folder: Path, names: Iterable[str], purpose: Purpose, *, seen_from: Path | None = None) -> None:
    """Enter files of a folder, and what they were written for, into its record.

    Args:
        folder: where the files lie.
        names: of the files.
        purpose: for which they were written.
        seen_from: where the folder will lie, if it is a scratch folder.
    """
    noted = {name: entry for name, entry in entries(folder).items() if (folder / name).exists()}
    about = purpose.seen_from(seen_from or folder)
    _write(folder, noted | {name: about | {"sha256": _digest(folder / name)} for name in names})


def claim(folder: Path, names: Iterable[str], purpose: Purpose) -> None:
    """Enter files that will be written again and again while a command works, and belong to it whatever they hold."""
    _write(folder, entries(folder) | {name: purpose.seen_from(folder) for name in names})


def _write(folder: Path, entries: dict[str, Any]) -> None:
    scratch = folder / f"{RECORD}-{os.getpid()}"
    scratch.write_text(json.dumps(dict(sorted(entries.items())), indent=1) + "\n", encoding="utf-8")
    os.replace(scratch, folder / RECORD)


def entries(folder: Path) -> dict[str, Any]:
    """The record of a folder, an entry for each of its files; empty where there is none, or none that can be read."""
    try:
        content = json.loads((folder / RECORD).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    known = isinstance(content, dict) and all(isinstance(entry, dict) for entry in content.values())
    return {name: entry for name, entry in content.items() if {"command", "inputs"} <= set(entry)} if known else {}


def _relative(name: str, folder: Path) -> str:
    try:
        return os.path.relpath(Path(name).resolve(), folder.resolve()) if os.path.exists(name) else name
    except ValueError:  # another drive
        return str(Path(name).resolve())


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _is_filled_sheet(path: Path) -> bool:
    """Whether a table is a laboratory sheet into which readings were written, however badly the rest is written."""
    try:
        if is_excel_name(path):
            rows: Rows = sheet_rows(path.read_bytes(), str(path))[0]
        elif path.suffix.lower() == ".csv":
            rows = separated(decoded(path.read_bytes(), str(path))[0], str(path))[0]
        else:
            return False
    except InputError:
        return False
    if not rows or not set(_OF_A_SHEET) <= set(rows[0][1]):
        return False
    columns = [index for index, name in enumerate(rows[0][1]) if name.startswith(_READINGS)]
    return any(row[index].strip() for _, row in rows[1:] for index in columns if index < len(row))

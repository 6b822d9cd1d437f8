"""Do what docs/tutorial.md says, in an empty folder: `python docs/tutorial.py` puts the outputs into the page.

`python docs/tutorial.py walk` does so with docs/walk.md.

The page's files (blocks with a title) are written, its commands (lines that begin with `$`) are executed one after the
other, and what they print is what stands below them. Lines of progress are left out.
"""

import contextlib
import io
import os
import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from expdesign.app.commands.main import main

PAGE = Path(__file__).with_name("tutorial.md")
_FENCE = re.compile(r"^```(\w+)(?: title=\"([^\"]+)\")?\n(.*?)^```\n", flags=re.DOTALL | re.MULTILINE)
_PROGRESS = re.compile(r"^\w+ing(?: \(stage \d+ of \d+\))?: ")


@dataclass(frozen=True)
class Step:
    """A command of the page, what it shows below it, and what it printed."""

    command: str
    shown: str
    printed: str


def follow(text: str, folder: Path) -> Iterator[Step]:
    """Write the files and execute the commands of the page in `folder`."""
    for language, title, body in _FENCE.findall(text):
        if title:
            (folder / title).write_text(body, encoding="utf-8")
        elif language == "console":
            for command, shown in _commands(body):
                yield Step(command, shown, _printed(command, folder))


def _commands(body: str) -> Iterator[tuple[str, str]]:
    for part in re.split(r"^\$ ", body, flags=re.MULTILINE)[1:]:
        # A command goes on after a backslash, and within quotes.
        lines = part.splitlines()
        count = 1
        while lines[count - 1].endswith("\\") or "\n".join(lines[:count]).count('"') % 2:
            count += 1
        yield "\n".join(lines[:count]), "\n".join(lines[count:])


def _printed(command: str, folder: Path) -> str:
    if command.startswith("expdesign "):
        command, _, through = command.partition(" | ")
        output, before = io.StringIO(), Path.cwd()
        os.chdir(folder)
        try:
            with contextlib.redirect_stdout(output), contextlib.redirect_stderr(output):
                main(shlex.split(command.replace("\\\n", " "))[1:])
        except SystemExit as stop:
            if stop.code not in (0, None):
                raise RuntimeError(f"`{command}` failed: {output.getvalue()}") from None
        finally:
            os.chdir(before)
        text = output.getvalue()
        if through:
            text = subprocess.run(through, shell=True, input=text, capture_output=True, text=True, check=True).stdout
    else:
        shell = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
        done = subprocess.run(command, shell=True, cwd=folder, env=shell, capture_output=True, text=True, check=True)
        text = done.stdout
    lines = (line.rstrip() for line in text.splitlines())
    return "\n".join(line for line in lines if not _PROGRESS.match(line))


def rewritten(text: str, folder: Path) -> str:
    """The page with the outputs of today."""
    steps = follow(text, folder)

    def block(match: re.Match[str]) -> str:
        language, _, body = match.groups()
        if language != "console":
            return match.group(0)
        parts = []
        for _ in _commands(body):
            step = next(steps)
            parts.append("\n".join(filter(None, (f"$ {step.command}", step.printed))))
        return "```console\n" + "\n".join(parts) + "\n```\n"

    # Files are written as `follow` comes to them, which is in the order of the page.
    result = _FENCE.sub(block, text)
    assert next(steps, None) is None
    return result


if __name__ == "__main__":
    page = PAGE.with_stem(sys.argv[1]) if len(sys.argv) > 1 else PAGE
    with tempfile.TemporaryDirectory() as scratch:
        page.write_text(rewritten(page.read_text(encoding="utf-8"), Path(scratch)), encoding="utf-8")

"""Write docs/commands.md, every command with its options: `python docs/commands.py` (`--check` only compares)."""

import sys
from pathlib import Path

from typer.testing import CliRunner

from expdesign.app.commands.help import COMMANDS
from expdesign.app.commands.main import app

PAGE = Path(__file__).parent / "commands.md"
_HEAD = """# Commands

What `expdesign COMMAND --help` prints, by the groups of `expdesign --help`.
[File formats](file-formats.md#commands) have what each reads and writes, and the exit codes. In Python each is a
[function](reference.md) of the same name (`next` is `plan_next`).
"""


def page() -> str:
    """The page as it should be."""
    parts = [_HEAD]
    for group, names in COMMANDS.items():
        parts.append(f"\n## {group}\n")
        parts += [f"\n### `{name}`\n\n```text\n{help_of(name)}\n```\n" for name in names]
    return "".join(parts)


def help_of(name: str) -> str:
    """The help of a command, 100 characters wide."""
    result = CliRunner().invoke(
        app, [name, "--help"], prog_name="expdesign", env={"COLUMNS": "100"}, terminal_width=100
    )
    return "\n".join(line.rstrip() for line in result.output.strip().splitlines())


def main() -> int:
    """Write the page, or compare it."""
    if "--check" in sys.argv[1:]:
        return int(PAGE.read_text(encoding="utf-8") != page())
    PAGE.write_text(page(), encoding="utf-8")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())

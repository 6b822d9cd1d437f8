"""The help of commands: their list, what a docstring says of each, and its options in groups.

Nothing is imported for the list: what a command does is read off its source.
"""

import ast
import inspect
import re
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

from typer.core import TyperCommand

COMMANDS = {
    "The way, from a plan to a certificate": (
        "new", "check", "run", "sheet", "identify", "diagnose", "compensate", "verify",
    ),
    "Data": ("register", "correct", "simulate", "predict", "table", "physics"),
    "Research": ("compare", "montecarlo", "sweep", "evaluate", "next", "schema"),
}  # fmt: skip
"""Commands by the titles of their groups, in the order in which they are listed."""
_FUNCTIONS = {"next": "plan_next"}
"""Functions that are not called as their commands: `next` is a builtin."""
GROUPS: dict[str, tuple[str, ...]] = {
    "Measurements": ("shared_reference", "frames", "frame", "unit", "std", "base_frame", "interpolate", "other_robot"),
    "Arms": ("loss", "further", "hold", "accept"),
    "Computing": ("seconds", "samples", "random", "generations", "seed", "nodes", "workers", "cluster"),
    "Results": ("out", "units", "record", "json", "force", "strict"),
}
"""Options by the titles under which they stand; all others are of what the command is about."""
_TITLES = {name: title for title, names in GROUPS.items() for name in names}
_HERE = Path(__file__).parent
_API = _HERE.parent / "api"
_SECTION = re.compile(r"^(Args|Returns|Raises|Example|Command):$", re.MULTILINE)
_ARGUMENT = re.compile(r"^    (\w+): ", re.MULTILINE)
_IN_PYTHON = " In Python "
"""What follows it in the text of an argument is not for the command line."""


def function_of(name: str) -> str | None:
    """The function of the package that a command calls, in a module of its name; None where there is none."""
    function = _FUNCTIONS.get(name, name)
    return function if (_API / f"{function}.py").is_file() else None


@lru_cache(maxsize=1)
def listed_commands() -> dict[str, str]:
    """What each command does, in one sentence, in the order of the list."""
    return {name: _first(name) for names in COMMANDS.values() for name in names}


def _first(name: str) -> str:
    function = function_of(name)
    path, wanted = (_HERE / f"{name}.py", "command") if function is None else (_API / f"{function}.py", function)
    tree = ast.parse(path.read_text(encoding="utf-8"))
    node = next(node for node in tree.body if isinstance(node, ast.FunctionDef) and node.name == wanted)
    return Docstring.of(ast.get_docstring(node)).description[0]


@dataclass(frozen=True)
class Docstring:
    """A docstring of a function of the package, or of a part of a command.

    Attributes:
        description: paragraphs before the first section, the first of them one sentence.
        arguments: what each argument is, by its name.
        command: paragraphs about the command; the last is an example.
    """

    description: tuple[str, ...]
    arguments: dict[str, str] = field(default_factory=dict)
    command: tuple[str, ...] = ()

    @classmethod
    def of(cls, text: str | None) -> "Docstring":
        """The docstring in its parts, with paragraphs as single lines."""
        head, *rest = _SECTION.split(inspect.cleandoc(text or ""))
        sections = dict(zip(rest[::2], rest[1::2], strict=True))
        _, *named = _ARGUMENT.split(sections.get("Args", ""))
        arguments = {name: " ".join(text.split()) for name, text in zip(named[::2], named[1::2], strict=True)}
        return cls(_paragraphs(head), arguments, _paragraphs(sections.get("Command", "")))

    @property
    def help(self) -> str:
        """The help of a command: what it does, and an example."""
        *about, example = self.command or ("",)
        return "\n\n".join([*self.description, *about, *([f"Example: {example}"] if example else [])])

    def option(self, name: str) -> str:
        """The help of an option, as a sentence; empty where nothing is said of it."""
        text = self.arguments.get(name, "").partition(_IN_PYTHON)[0]
        return text[:1].upper() + text[1:]


def _paragraphs(text: str) -> tuple[str, ...]:
    return tuple(" ".join(part.split()) for part in text.split("\n\n") if part.strip())


class GroupedCommand(TyperCommand):
    """A command whose help has its options in groups."""

    def format_options(self, ctx: Any, formatter: Any) -> None:
        sections: dict[str, list[tuple[str, str]]] = {title: [] for title in ("Arguments", "Options", *GROUPS)}
        for parameter in self.get_params(ctx):
            shown = parameter.get_help_record(ctx)
            if shown is not None:
                title = _TITLES.get(str(parameter.name), "Options")
                sections["Arguments" if parameter.param_type_name == "argument" else title].append(shown)
        for title, rows in sections.items():
            if rows:
                with formatter.section(title):
                    formatter.write_dl(rows)

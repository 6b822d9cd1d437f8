"""Entry point: `expdesign COMMAND ...`.

Every module of this package with a function `command` is a command of the module's name. It is imported when it is
called: for the list of commands its group and the first line of its description are read off its source, so that
`expdesign --help` and the completion of a shell do not wait for the libraries of all of them.
"""

import ast
import importlib
import logging
import pkgutil
import sys
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperGroup
from typer.main import get_command

import expdesign
from expdesign.errors import ArgumentError, ExpdesignError

GROUPS = {
    "way": "The way, from a plan to a certificate",
    "data": "Data",
    "research": "Research",
}
"""Groups of commands with their titles, in the order of the list; a command says which one it is in (`GROUP`)."""

_LOOK: dict[str, Any] = {
    "pretty_exceptions_enable": False,
    "rich_markup_mode": None,
    "context_settings": {"help_option_names": ["-h", "--help"]},
}


@dataclass(frozen=True)
class Listed:
    """A command in the list: the first line of its description, its group and its place there."""

    first: str
    group: str
    place: int


@lru_cache(maxsize=1)
def command_modules() -> dict[str, Listed]:
    """The commands by their names, in the order of the list."""
    found = {}
    for info in pkgutil.iter_modules([str(Path(__file__).parent)]):
        tree = ast.parse((Path(__file__).parent / f"{info.name}.py").read_text(encoding="utf-8"))
        group, place = next(iter(GROUPS)), 0
        for node in tree.body:
            if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "GROUP":
                group, place = ast.literal_eval(node.value)
            if isinstance(node, ast.FunctionDef) and node.name == "command":
                first = (ast.get_docstring(node) or "").split("\n")[0]
                found[info.name.replace("_", "-")] = Listed(first, group, place)
    return dict(sorted(found.items(), key=lambda item: (list(GROUPS).index(item[1].group), item[1].place, item[0])))


class _InterruptedError(BaseException):
    """Somebody pressed Ctrl-C."""


class LazyCommands(TyperGroup):
    """The commands, imported one by one when they are called."""

    def list_commands(self, ctx: Any) -> list[str]:
        return list(command_modules())

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        if cmd_name not in command_modules():
            return None
        module = importlib.import_module(f"expdesign.app.commands.{cmd_name.replace('-', '_')}")
        one = typer.Typer(add_completion=False, **_LOOK)
        one.command(name=cmd_name)(module.command)
        return get_command(one)

    def invoke(self, ctx: Any) -> Any:
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:  # which would be answered without a word otherwise
            raise _InterruptedError from None

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        listed = command_modules()
        width = max(map(len, listed))
        for group, title in GROUPS.items():
            with formatter.section(title):
                formatter.write_dl(
                    [(name.ljust(width), one.first) for name, one in listed.items() if one.group == group]
                )

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        self.commands = dict.fromkeys(command_modules(), self)  # for the suggestion of the nearest name
        return super().resolve_command(ctx, args)


app = typer.Typer(
    name="expdesign",
    help="Plan and evaluate the calibration of robots that carry loads.",
    no_args_is_help=True,
    cls=LazyCommands,
    **_LOOK,
)


def _version(wanted: bool) -> None:
    if wanted:
        print(f"expdesign {expdesign.__version__}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """Plan and evaluate the calibration of robots that carry loads."""


class _Written(logging.Handler):
    """Collects what has been written completely, for whoever interrupts a command."""

    def __init__(self) -> None:
        super().__init__(logging.DEBUG)
        self.paths: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.paths.append(record.getMessage())

    @property
    def sentence(self) -> str:
        if not self.paths:
            return "Nothing was written."
        more = f" and {len(self.paths) - 3} more" if len(self.paths) > 3 else ""
        return f"Complete and kept: {', '.join(self.paths[:3])}{more}."


def main(arguments: list[str] | None = None) -> None:
    """Run the command line and exit: 0 on success, 2 on bad input (one message on standard error), 130 on Ctrl-C."""
    handler, written = (
        logging.StreamHandler(sys.stderr),
        _Written(),
    )  # what was found out about files, and what is there
    handler.setLevel(logging.INFO)
    log, output = logging.getLogger("expdesign"), logging.getLogger("expdesign.io.output")
    log.addHandler(handler)
    log.setLevel(logging.INFO)
    output.addHandler(written)
    output.setLevel(logging.DEBUG)
    try:
        app(args=arguments, standalone_mode=True)
    except ExpdesignError as error:
        message = error.option if isinstance(error, ArgumentError) else error.message
        print(f"expdesign: {message}", file=sys.stderr)
        sys.exit(2)
    except MemoryError:
        print(
            "expdesign: the problem does not fit into memory. Use fewer measurements, designs or rows.", file=sys.stderr
        )
        sys.exit(2)
    except (KeyboardInterrupt, _InterruptedError):
        print(f"expdesign: interrupted. {written.sentence}", file=sys.stderr)
        sys.exit(130)
    except BrokenPipeError:
        # The reader of standard output has gone (e.g. `| head`): no message can reach it.
        sys.stderr.close()
        sys.exit(1)
    finally:
        log.removeHandler(handler)
        output.removeHandler(written)

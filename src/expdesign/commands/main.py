"""Entry point: `expdesign COMMAND ...`.

Every module of this package with a function `command` is a command of the module's name. It is imported when it is
called: for the list of commands the first line of its description is read off its source, so that `expdesign --help`
and the completion of a shell do not wait for the libraries of all of them.
"""

import ast
import importlib
import logging
import pkgutil
import sys
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperGroup
from typer.main import get_command

import expdesign
from expdesign.errors import ExpdesignError

_LOOK: dict[str, Any] = {
    "pretty_exceptions_enable": False,
    "rich_markup_mode": None,
    "context_settings": {"help_option_names": ["-h", "--help"]},
}


@lru_cache(maxsize=1)
def command_modules() -> dict[str, str]:
    """Names of the commands, and the first line of each one's description."""
    found = {}
    for info in sorted(pkgutil.iter_modules([str(Path(__file__).parent)]), key=lambda module: module.name):
        tree = ast.parse((Path(__file__).parent / f"{info.name}.py").read_text(encoding="utf-8"))
        for node in tree.body:
            if isinstance(node, ast.FunctionDef) and node.name == "command":
                found[info.name.replace("_", "-")] = (ast.get_docstring(node) or "").split("\n")[0]
    return found


class LazyCommands(TyperGroup):
    """The commands, imported one by one when they are called."""

    def list_commands(self, ctx: Any) -> list[str]:
        return list(command_modules())

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        if cmd_name not in command_modules():
            return None
        module = importlib.import_module(f"expdesign.commands.{cmd_name.replace('-', '_')}")
        one = typer.Typer(add_completion=False, **_LOOK)
        one.command(name=cmd_name)(module.command)
        return get_command(one)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        with formatter.section("Commands"):
            formatter.write_dl(list(command_modules().items()))

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


def main(arguments: list[str] | None = None) -> None:
    """Run the command line and exit: 0 on success, 2 on bad input (one message on standard error), 130 on Ctrl-C."""
    handler = logging.StreamHandler(sys.stderr)  # what was found out about files
    log = logging.getLogger("expdesign")
    log.addHandler(handler)
    log.setLevel(logging.INFO)
    try:
        app(args=arguments, standalone_mode=True)
    except ExpdesignError as error:
        print(f"expdesign: {error.message}", file=sys.stderr)
        sys.exit(2)
    except MemoryError:
        print(
            "expdesign: the problem does not fit into memory. Use fewer measurements, designs or rows.", file=sys.stderr
        )
        sys.exit(2)
    except KeyboardInterrupt:
        print("expdesign: interrupted", file=sys.stderr)
        sys.exit(130)
    except BrokenPipeError:
        # The reader of standard output has gone (e.g. `| head`): no message can reach it.
        sys.stderr.close()
        sys.exit(1)
    finally:
        log.removeHandler(handler)

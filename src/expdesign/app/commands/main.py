"""Entry point: `expdesign COMMAND ...`.

A command is made of a function of the package when it is called (`maker`), so that `expdesign --help` and the
completion of a shell do not wait for the libraries of all of them.
"""

import importlib
import logging
import re
import sys
from importlib.metadata import version as version_of
from typing import Annotated, Any

import typer
from typer.core import TyperGroup
from typer.main import get_command

from expdesign.app.commands.help import COMMANDS, GroupedCommand, listed_commands
from expdesign.app.commands.spelling import Spelling
from expdesign.app.commands.terminal import encode_anything, printable, terminated_as_interrupted, unwritable_output
from expdesign.errors import ExpdesignError, InputError

_USAGE_ERROR: Any = typer.BadParameter.__base__
"""Base of the errors of a command line."""
_OF_AN_OPTION = re.compile(r"Invalid value for `([^`]+)`: (?:Value error, )?(.*)", re.DOTALL)
_LOOK: dict[str, Any] = {
    "pretty_exceptions_enable": False,
    "rich_markup_mode": None,
    "context_settings": {"help_option_names": ["-h", "--help"]},
}


class _InterruptedError(BaseException):
    """Somebody pressed Ctrl-C."""


class LazyCommands(TyperGroup):
    """The commands, imported one by one when they are called."""

    def list_commands(self, ctx: Any) -> list[str]:
        return list(listed_commands())

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        if cmd_name not in listed_commands():
            return None
        # The libraries of a command are imported when it is called.
        function, help_text = importlib.import_module("expdesign.app.commands.maker").made(cmd_name)
        one = typer.Typer(add_completion=False, **_LOOK)
        one.command(name=cmd_name, help=help_text, cls=GroupedCommand)(function)
        return get_command(one)

    def invoke(self, ctx: Any) -> Any:
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:  # which would be answered without a word otherwise
            raise _InterruptedError from None

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        listed = listed_commands()
        width = max(map(len, listed))
        for title, names in COMMANDS.items():
            with formatter.section(title):
                formatter.write_dl([(name.ljust(width), listed[name]) for name in names])

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        self.commands = dict.fromkeys(listed_commands(), self)  # for the suggestion of the nearest name
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
        print(f"expdesign {version_of('expdesign')}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """Plan and evaluate the calibration of robots that carry loads."""


class _Said(logging.StreamHandler[Any]):
    """Prints what was found out about files as a command says it."""

    def format(self, record: logging.LogRecord) -> str:
        return Spelling().said(super().format(record))


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


def _usage(error: Any) -> str:
    """What is wrong with the words of a command line, and what to do."""
    name = "" if error.ctx is None or error.ctx.parent is None else error.ctx.info_name
    said = error.format_message().replace("'", "`").rstrip(".")
    place = _OF_AN_OPTION.match(said)
    where, what = place.groups() if place is not None else (name, said)
    remedy = f"`{f'expdesign {name}'.strip()} --help` says what can be given."
    return InputError(what[:1].lower() + what[1:], where=where, remedy=remedy).message


def main(arguments: list[str] | None = None) -> None:
    """Run the command line and exit.

    Status (docs/file-formats.md): 0 done, 1 a defect, 2 bad input (one message on standard error), 3 done and the
    answer is no (`Result.refused`), 130 on Ctrl-C or SIGTERM.
    """
    handler, written = _Said(sys.stderr), _Written()  # what was found out about files, and what is there
    handler.setLevel(logging.INFO)
    log, output = logging.getLogger("expdesign"), logging.getLogger("expdesign.io.output")
    log.addHandler(handler)
    log.setLevel(logging.INFO)
    output.addHandler(written)
    output.setLevel(logging.DEBUG)
    encode_anything()
    try:
        with terminated_as_interrupted():
            sys.exit(_ended(arguments, written))
    finally:
        log.removeHandler(handler)
        output.removeHandler(written)


def _ended(arguments: list[str] | None, written: _Written) -> int:
    """Exit status of a command line, after one message where it did not end well."""
    try:
        status = app(args=arguments, prog_name="expdesign", standalone_mode=False)
        sys.stdout.flush()
        return status or 0
    except _USAGE_ERROR as error:
        if len(sys.argv if arguments is None else ["", *arguments]) < 2:
            error.show()  # the list of commands
            return 2
        return _bad(_usage(error))
    except ExpdesignError as error:
        return _bad(Spelling().said(error.message), written)
    except MemoryError:
        return _bad("the problem does not fit into memory. Use fewer measurements, designs or rows.", written)
    except (KeyboardInterrupt, _InterruptedError):
        print(f"expdesign: interrupted. {written.sentence}", file=sys.stderr)
        return 130
    except BrokenPipeError:
        # The reader of standard output has gone (e.g. `| head`): no message can reach it.
        unwritable_output()
        return 1
    except OSError:
        full = unwritable_output()
        if full is None:
            raise
        return _bad(f"standard output cannot be written ({full.strerror}). {written.sentence}")


def _bad(message: str, written: _Written | None = None) -> int:
    """Exit status of bad input, after one message and what was written all the same."""
    kept = f" {written.sentence}" if written is not None and written.paths else ""
    print(printable(f"expdesign: {message}{kept}"), file=sys.stderr)
    return 2

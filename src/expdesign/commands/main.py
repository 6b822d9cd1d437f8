"""Entry point: `expdesign COMMAND ...`."""

import importlib
import pkgutil
import sys

import typer

from expdesign.errors import ExpdesignError

app = typer.Typer(
    name="expdesign",
    help="Plan and evaluate the calibration of robots that carry loads.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)


@app.callback()
def _root() -> None:
    """Plan and evaluate the calibration of robots that carry loads."""


def _register() -> None:
    """Every module of this package with a function `command` is a command of the module's name."""
    path = importlib.import_module("expdesign.commands").__path__
    for info in sorted(pkgutil.iter_modules(path), key=lambda module: module.name):
        if info.name == "main":
            continue
        module = importlib.import_module(f"expdesign.commands.{info.name}")
        command = getattr(module, "command", None)
        if command is not None:
            app.command(name=info.name.replace("_", "-"))(command)


_register()


def main(arguments: list[str] | None = None) -> None:
    """Run the command line and exit: 0 on success, 2 on bad input (one message on standard error), 130 on Ctrl-C."""
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
        # The reader of standard output has gone; there is nobody left to tell.
        sys.stderr.close()
        sys.exit(1)

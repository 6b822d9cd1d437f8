"""Commands made of the functions of the package: options from the signature, help from the docstring.

A parameter without a default is an argument of the command, any other an option; callbacks are left out. The class of
what the function returns says how it is kept: `save` makes `--out` and `--force` (and `--units`), `save_record` makes
`--record`, and `record` without `save` makes `--json`. What a signature does not say stands in `spelling`.
"""

import importlib
import importlib.util
import inspect
import re
from collections.abc import Callable, Collection, Sequence
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any, Literal, get_args, get_origin

import typer

from expdesign.app.api.arguments import choices_of, hints_of, parts_of
from expdesign.app.commands.call import WRITTEN, Call
from expdesign.app.commands.help import Docstring, function_of
from expdesign.app.commands.spelling import SPELLINGS, Spelling
from expdesign.io.output import new_folder

Options = dict[str, tuple[Any, Any]]
"""Annotations and defaults of arguments and options, by their names in the command."""
_EMPTY = inspect.Parameter.empty
WORKERS = "Processes of this machine"
CLUSTER = "Address of a Dask scheduler instead, e.g. tcp://192.168.0.5:8786."
_OPTION = re.compile(r"`(\w+)`")


def made(name: str) -> tuple[Callable[..., None], str]:
    """The function that carries out a command, with annotations for typer, and the command's help."""
    function = function_of(name)
    if function is None:  # what writes files and computes nothing has no function in Python
        own: Callable[..., None] = importlib.import_module(f"{__package__}.{name}").command
        return own, Docstring.of(own.__doc__).help
    called = getattr(importlib.import_module(f"expdesign.app.api.{function}"), function)
    spelling, docstring = SPELLINGS.get(name, Spelling()), Docstring.of(called.__doc__)
    hints = hints_of(called)
    kind, parameters = hints.pop("return"), _shown(called, hints, spelling)
    arguments, options = _options(parameters, hints, docstring, spelling)
    kept = _result_options(kind, spelling)
    whole = {**arguments, **{key: kept[key] for key in kept if key == "out"}, **options, **kept}
    python = {spelling.name(argument): argument for argument in parameters}
    inputs = tuple(python[key] for key in arguments)

    def command(**texts: Any) -> None:
        given = {python.get(key, key): value for key, value in texts.items() if value not in (None, [])}
        out = given.pop("out", None)
        if out is None and spelling.out == "a new one under results/":
            first = given[inputs[0]]
            out = new_folder(first.stem if isinstance(first, Path) else name)
        Call(name, function, spelling, kind, inputs, given, out).carried_out()

    command.__annotations__ = {key: annotation for key, (annotation, _) in whole.items()}
    command.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
        [
            inspect.Parameter(key, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=annotation)
            for key, (annotation, default) in whole.items()
        ]
    )
    return command, docstring.help


def _shown(function: Any, hints: dict[str, Any], spelling: Spelling) -> dict[str, inspect.Parameter]:
    """Parameters that are arguments or options."""
    never = {*spelling.hidden, *spelling.always, "progress"}
    parameters = inspect.signature(function).parameters
    return {
        name: one
        for name, one in parameters.items()
        if name == "executors"
        or (name not in never and not any(get_origin(part) is Callable for part in parts_of(hints[name])))
    }


def _options(
    parameters: dict[str, inspect.Parameter], hints: dict[str, Any], docstring: Docstring, spelling: Spelling
) -> tuple[Options, Options]:
    """Arguments, and options."""
    arguments: Options = {}
    options: Options = {}
    for name, parameter in parameters.items():
        if name == "executors":
            left = "as many as it has processors" if spelling.workers is None else str(spelling.workers)
            options["workers"] = Annotated[int | None, typer.Option(help=f"{WORKERS}; {left} if left out.")], None
            options["cluster"] = Annotated[str | None, typer.Option(help=CLUSTER)], None
            continue
        key = spelling.name(name)
        required = parameter.kind is not inspect.Parameter.KEYWORD_ONLY and parameter.default is _EMPTY
        if name in spelling.positional or (required and name not in spelling.written and key != "out"):
            kind, several = _kind(hints[name])
            several |= parameter.kind is inspect.Parameter.VAR_POSITIONAL
            shown = typer.Argument(help=docstring.option(name))
            shape: Any = list[kind] if several else kind  # type: ignore[valid-type]
            arguments[key] = Annotated[shape, shown], parameter.default
        else:
            text = _OPTION.sub(
                lambda found: f"--{found[1].replace('_', '-')}" if found[1] in parameters else found[0],
                docstring.option(name),
            )
            options[key] = _option(parameter, hints[name], text, spelling)
    return arguments, options


def _option(parameter: inspect.Parameter, hint: Any, text: str, spelling: Spelling) -> tuple[Any, Any]:
    """Annotation and default of an option."""
    name, default = parameter.name, parameter.default
    written = spelling.written.get(name)
    kind: Any = str
    if written is not None:
        several, text = written.repeated, f"{text} {written.how}"
        default = _EMPTY if default is _EMPTY else None
    else:
        kind, several = _kind(hint)
        text, default = (f"{text} Repeatable.", None) if several else (text, default)
    flag = f"--{spelling.name(name).replace('_', '-')}"
    if kind is bool and default is not False:
        flag = f"{flag}/--no-{flag.removeprefix('--')}"
    shape: Any = list[kind] if several else kind
    return Annotated[shape if default is _EMPTY else shape | None, typer.Option(flag, help=text)], default


def _result_options(kind: Any, spelling: Spelling) -> Options:
    """Where and how the result is kept, by what its class can do."""
    if not hasattr(kind, "save"):
        shown = typer.Option("--json", help="Print one JSON document on standard output.")
        return {"json": (Annotated[bool, shown], False)} if hasattr(kind, "record") else {}
    docstring, parameters = Docstring.of(kind.save.__doc__), inspect.signature(kind.save).parameters
    place = docstring.option("folder" if "folder" in parameters else "file").rstrip(".")
    if getattr(kind, "FILES", ()):
        place += f" ({', '.join(kind.FILES)})"
    options: Options = {"out": (Annotated[Path, typer.Option(help=f"{place}.", **WRITTEN)], _EMPTY)}
    if spelling.out != "required":
        shown = typer.Option(help=f"{place}; {spelling.out} if left out.", **WRITTEN)
        options["out"] = Annotated[Path | None, shown], None
    if "units" in parameters:
        options["units"] = Annotated[str | None, typer.Option(help=docstring.option("units"))], None
    if hasattr(kind, "save_record"):
        about = Docstring.of(kind.save_record.__doc__).option("file")
        options["record"] = Annotated[Path | None, typer.Option(help=about, **WRITTEN)], None
    options["force"] = Annotated[bool, typer.Option("--force", help=docstring.option("force"))], False
    return options


def _kind(hint: Any) -> tuple[Any, bool]:
    """What a person writes for a type (one of its choices where it is a `Literal`), and whether several of it."""
    parts = parts_of(hint)
    listed = [part for part in parts if get_origin(part) in (Sequence, Collection, list)]
    several = bool(listed)
    parts = tuple(part for one in listed for part in parts_of(get_args(one)[0])) if listed else parts
    for kind in (Path, bool, float, int):
        if kind in parts:
            return kind, several
    choices = choices_of(parts)
    if choices and str not in parts:
        if not several:
            return Literal[tuple(choices)], several
        make: Any = StrEnum  # typer knows no list of literals
        return make("Choice", {choice: choice for choice in choices}), several
    assert choices or str in parts, f"no option can say {hint}"
    return str, several

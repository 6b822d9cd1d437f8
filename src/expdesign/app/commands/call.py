"""A command that was given: what is asked before the work, the work, and what is kept and said of it."""

import inspect
import sys
import time
from collections.abc import Mapping
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

import expdesign as xd
from expdesign.app.api.inputs import purpose_of
from expdesign.app.commands import BEGUN
from expdesign.app.commands.spelling import Spelling
from expdesign.app.commands.terminal import interruptible, printable
from expdesign.errors import ExpdesignError
from expdesign.io.output import json_text, require_writable
from expdesign.io.written import is_stream, require_free, require_free_names
from expdesign.report.result import FolderResult, Result

Force = Annotated[bool, typer.Option("--force", help="Replace files that are there for another purpose.")]


def _place(text: str | Path) -> Path:
    """A path to write to; an empty text (an unset variable of a shell) would be the working folder."""
    if not str(text).strip():  # a default is a path already
        raise typer.BadParameter("it is empty: name a place, or `.` for this folder")
    return Path(text)


WRITTEN: dict[str, Any] = {"parser": _place, "metavar": "PATH"}
"""What options have in common that say where something is written."""


def note(text: str) -> None:
    """One line on standard error; standard output belongs to results."""
    print(printable(text), file=sys.stderr, flush=True)


@dataclass(frozen=True)
class Call:
    """A command that was given.

    Attributes:
        name: of the command.
        function: name of the function of the package that it calls.
        spelling: how the command is spelled.
        kind: class of the result.
        inputs: names of the arguments that are not options.
        given: values of arguments and options by the function's own names; `out`, `units`, `record`, `json`, `force`,
            `workers` and `cluster` where the command has them.
        out: where the result is kept; None for nowhere.
    """

    name: str
    function: str
    spelling: Spelling
    kind: type[Any]
    inputs: tuple[str, ...]
    given: Mapping[str, Any]
    out: Path | None

    def carried_out(self) -> None:
        """Do the work, keep the result and say it; Ctrl-C ends a search that asks whether it is `ended`."""
        self.require_free()
        function = getattr(xd, self.function)
        parameters = inspect.signature(function).parameters
        with interruptible(note) if "ended" in parameters else nullcontext() as ended:
            result = self.result(function, parameters, ended)
            path = self.kept(result)
        self.say(result, path)

    @property
    def force(self) -> bool:
        """Whether files that are there for another purpose are replaced."""
        return bool(self.given.get("force"))

    def require_free(self) -> None:
        """Raise an `InputError` where a file cannot be written, or would replace another."""
        purpose = purpose_of(self.name, *(self.given[name] for name in self.inputs))
        files = [self.given.get("record"), self.out]
        if self.out is not None and issubclass(self.kind, FolderResult):
            require_writable(self.out)
            require_free_names(self.out, self.kind.FILES, purpose, force=self.force)
            files.remove(self.out)
        for file in files:
            if file is not None and not is_stream(file):
                require_free(file, purpose, force=self.force)
                require_writable(file.parent)

    def result(self, function: Any, parameters: Mapping[str, inspect.Parameter], ended: Any) -> Any:
        """What the function returns; the plans of a search are kept as soon as they are known."""
        arguments = {name: value for name, value in self.given.items() if name in parameters}
        for name, written in self.spelling.written.items():
            if name in arguments:
                arguments[name] = written.read(arguments[name])
        given = {"progress": True, "ended": ended, "searched": lambda run: run.save_plan(self.out, force=self.force)}
        arguments |= {**self.spelling.always, **{name: given[name] for name in given if name in parameters}}
        if arguments.get("seconds", -1.0) >= 0.0:  # what it took to get here counts too
            arguments["seconds"] = max(0.0, arguments["seconds"] - (time.perf_counter() - BEGUN))
        several = [name for name, one in parameters.items() if one.kind is inspect.Parameter.VAR_POSITIONAL]
        positional = [value for name in several for value in arguments.pop(name, ())]
        try:
            if "executors" not in parameters:
                return function(*positional, **arguments)
            from expdesign.app.parallel import executors_of  # noqa: PLC0415 (most work in one process)

            with executors_of(self.given.get("workers"), self.given.get("cluster"), self.spelling.workers) as executors:
                return function(*positional, **arguments, executors=executors)
        except ExpdesignError as error:
            where, remedy = self.spelling.said(error.where), self.spelling.said(error.remedy)
            raise ExpdesignError(self.spelling.said(error.what), where=where, remedy=remedy) from None

    def kept(self, result: Any) -> Path | None:
        """The path under which the result is kept, None where it is not."""
        if self.out is None:
            return None
        options = {name: value for name, value in self.given.items() if name in ("units", "force")}
        path: Path = result.save(self.out, **options)
        if "record" in self.given:
            result.save_record(self.given["record"], force=self.force)
        return path

    def say(self, result: Any, path: Path | None = None) -> None:
        """Print what the result says, and where it is kept; exit with status 3 where its answer is no (`refused`)."""
        if not isinstance(result, Result):
            print(json_text(result), end="")
            return
        if self.given.get("json"):
            print(json_text(getattr(result, "record")), end="")  # noqa: B009 (those with `--json` have one)
        else:
            for line in result.lines:
                print(printable(self.spelling.said(line)))
        for text in result.notes:
            note(self.spelling.said(text))
        if path is not None:
            print(path)
        if result.refused:
            raise typer.Exit(3)

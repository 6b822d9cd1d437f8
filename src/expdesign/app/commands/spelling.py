"""What the signature of a function does not say about its command: names of options, and values written as text."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from expdesign.app.commands import values
from expdesign.app.commands.values import Written

_ARGUMENT = re.compile(r"argument `(\w+)(?:=([^`]+))?`")
"""How messages name an argument, and a value of it."""


@dataclass(frozen=True)
class Spelling:
    """How the command of a function is spelled.

    Attributes:
        names: of arguments that are called otherwise.
        aliases: further options of an argument.
        positional: arguments with a default that are not options.
        written: arguments that are written as text.
        hidden: arguments that only Python has.
        always: arguments that the command always gives.
        out: whether `--out` has to be given, and what is done without it.
        workers: processes where neither `--workers` nor `--cluster` is given; None for as many as there are processors.
    """

    names: Mapping[str, str] = field(default_factory=dict)
    aliases: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    positional: tuple[str, ...] = ()
    written: Mapping[str, Written] = field(default_factory=dict)
    hidden: tuple[str, ...] = ()
    always: Mapping[str, object] = field(default_factory=dict)
    out: Literal["required", "a new one under results/", "nothing is kept"] = "required"
    workers: int | None = 1

    def name(self, argument: str) -> str:
        """The name of an argument as the command has it."""
        return self.names.get(argument, argument)

    def said(self, text: str) -> str:
        """A message about arguments of the function as the command says it, by its options."""
        return _ARGUMENT.sub(self._option, text)

    def _option(self, found: re.Match[str]) -> str:
        name = self.name(found[1]).replace("_", "-")
        if found[2] in ("True", "False", None):
            return f"--no-{name}" if found[2] == "False" else f"--{name}"
        return f"--{name} {found[2]}"


SPELLINGS: Mapping[str, Spelling] = {
    "check": Spelling(out="nothing is kept"),
    "compare": Spelling(names={"plans": "plan"}, written={"plans": values.NAMED_FILES}, out="a new one under results/"),
    "diagnose": Spelling(hidden=("without",), always={"interruptible": True}),
    "register": Spelling(names={"deviation": "std"}, written={"deviation": values.LENGTH}),
    "run": Spelling(hidden=("timed",), out="a new one under results/"),
    "schema": Spelling(positional=("kind",), hidden=("robots",)),
    "simulate": Spelling(aliases={"model": ("--truth",)}),
    "sweep": Spelling(names={"file": "sweep", "folder": "out"}, workers=None),
    "table": Spelling(written={"over": values.RANGES, "at": values.HELD, "error": values.ERRORS}),
}
"""Of the commands that need it."""

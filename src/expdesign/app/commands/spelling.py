"""What a signature does not say about its command: names of options, and values that are written as text.

Such as `x_mm=-30:30`, `mine=plan.csv` or `15 um`.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from expdesign.errors import InputError
from expdesign.io.units import quantity


@dataclass(frozen=True)
class Written:
    """How an option is written.

    Attributes:
        how: for the help, after what the option is.
        read: the argument of the function, from the texts that were given (one if it cannot be repeated).
        repeated: whether it can be given several times.
    """

    how: str
    read: Callable[[Any], Any]
    repeated: bool = True


def pairs(
    option: str, noun: str, example: str, read: Callable[[str], Any]
) -> Callable[[Sequence[str]], dict[str, Any]]:
    """What reads texts `NAME=VALUE` of an option: a mapping of values by name.

    Args:
        option: of the command.
        noun: what a text is that has a name and a value, with its article.
        example: of such a text.
        read: the value from its text; None where it is none.
    """

    def mapping(texts: Sequence[str]) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for text in texts:
            name, _, value = text.partition("=")
            if not value or (meant := read(value)) is None:
                raise InputError(f"`{text}` is not {noun}", where=option, remedy=f"Write e.g. {example}.")
            if name.strip() in found:
                raise InputError(f"`{name.strip()}` appears twice", where=option, remedy="Name each once.")
            found[name.strip()] = meant
        return found

    return mapping


def number(text: str) -> float | None:
    """A number; its unit stands in the name that it belongs to."""
    try:
        return float(text)
    except ValueError:
        return None


def ends(text: str) -> tuple[float, float] | None:
    """`LOW:HIGH`."""
    low, _, high = map(number, text.partition(":"))
    return None if low is None or high is None else (low, high)


def errors(text: str) -> dict[str, float]:
    """A length, an angle, or both, separated by a comma; what is not named stays what it is."""
    from expdesign.app.api.table import ERROR  # noqa: PLC0415 (the other commands do not need it)

    wanted = dict(ERROR)
    for part in text.split(","):
        value, unit = quantity(part, "--error")
        if unit.dimension not in wanted or value <= 0.0:
            what = f"`{part.strip()}` is no length or angle above 0"
            raise InputError(what, where="--error", remedy="Write e.g. `0.01 um, 0.1 urad`.")
        wanted[unit.dimension] = value
    return wanted


def length(text: str) -> float:
    """A length with its unit, in m."""
    value, unit = quantity(text, "--std")
    if unit.dimension != "length":
        raise InputError(f"`{text}` is no length", where="--std", remedy="Write e.g. '15 um'.")
    return value


RANGES = Written("As NAME=LOW:HIGH, e.g. x_mm=-30:30; repeatable.", pairs("--over", "a range", "x_mm=-30:30", ends))
HELD = Written("As NAME=VALUE, e.g. mass_kg=26.5; repeatable.", pairs("--at", "a value", "mass_kg=26.5", number))
NAMED_FILES = Written("As NAME=FILE.csv; repeatable.", pairs("--plan", "a named plan", "mine=plan.csv", Path))
ERRORS = Written("As text, e.g. '0.01 um, 0.1 urad' (the default).", errors, repeated=False)
LENGTH = Written("As text, e.g. '15 um'.", length, repeated=False)


_ARGUMENT = re.compile(r"argument `(\w+)(?:=([^`]+))?`")
"""How messages name an argument, and a value of it."""


@dataclass(frozen=True)
class Spelling:
    """How the command of a function is spelled.

    Attributes:
        names: of arguments that are called otherwise.
        positional: arguments with a default that are not options.
        written: arguments that are written as text.
        hidden: arguments that only Python has.
        always: arguments that the command always gives.
        out: whether `--out` has to be given, and what is done without it.
        workers: processes where neither `--workers` nor `--cluster` is given; None for as many as there are processors.
    """

    names: Mapping[str, str] = field(default_factory=dict)
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
    "compare": Spelling(names={"plans": "plan"}, written={"plans": NAMED_FILES}, out="a new one under results/"),
    "diagnose": Spelling(hidden=("without",), always={"interruptible": True}),
    "register": Spelling(names={"deviation": "std"}, written={"deviation": LENGTH}),
    "run": Spelling(out="a new one under results/"),
    "schema": Spelling(positional=("kind",), hidden=("robots",)),
    "sweep": Spelling(names={"file": "sweep", "folder": "out"}, workers=None),
    "table": Spelling(written={"over": RANGES, "at": HELD, "error": ERRORS}),
}
"""Of the commands that need it."""

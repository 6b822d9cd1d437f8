"""`extend`: a robot family, a physics, a criterion, a load error or a port of your own, beside those of the package."""

from typing import TypeVar

from expdesign import plugins
from expdesign.chain.effect import Effect
from expdesign.chain.ports.port import Port
from expdesign.errors import InputError
from expdesign.mechanics.loads.errors.source import LoadErrorSource
from expdesign.mechanics.robots.robot import Robot
from expdesign.planning.criteria.criterion import Criterion

C = TypeVar("C", bound=type)
KINDS: dict[type, str] = {
    Effect: "expdesign.chain.effects",
    Criterion: "expdesign.planning.criteria",
    Robot: "expdesign.mechanics.robots",
    LoadErrorSource: "expdesign.mechanics.loads.errors",
    Port: "expdesign.chain.ports.places",
}
"""Where the package keeps its own of each kind."""


def extend(cls: C) -> C:
    """Register a class for this process, also as a decorator; docs/extending.md has one of each kind.

    An installed package names its classes as entry points instead (groups `expdesign.physics`, `expdesign.criteria`,
    `expdesign.robots`, `expdesign.load_errors`, `expdesign.ports`), which commands and other processes know as well.

    Raises:
        InputError: the class is nothing that can be added, lacks what its base class asks for, or has the name of
            another one.
    """
    if not isinstance(cls, type):
        raise InputError(f"`{cls!r}` is not a class", remedy=_remedy())
    where = f"`{cls.__module__}.{cls.__qualname__}`"
    base = next((base for base in KINDS if issubclass(cls, base)), None)
    if base is None:
        raise InputError("nothing that can be added", where=where, remedy=_remedy())
    missing = sorted(f"`{name}`" for name in getattr(cls, "__abstractmethods__", ()))
    places = next((each for each in cls.__mro__ if {"at", "components"} & set(vars(each))), None)
    if base is Effect and places is Effect:
        missing.append("`at`")
    if missing:
        raise InputError(f"it lacks {', '.join(missing)}", where=where, remedy="Define what its base class asks for.")
    plugins.add(cls)
    try:
        plugins.implementations(KINDS[base], base)
    except InputError:
        plugins.remove(cls)
        raise
    return cls


def _remedy() -> str:
    return f"Give a class derived from one of {', '.join(kind.__name__ for kind in KINDS)}."

"""Find the implementations of a kind: in a package by their place, so that adding one is adding one file, and outside.

From outside come classes that were registered (`expdesign.extend`), and those that an installed distribution names as
entry points of the kind's group.
"""

import importlib
import inspect
import pkgutil
from functools import cache, lru_cache
from importlib.metadata import EntryPoint, entry_points
from typing import TypeVar

from expdesign.errors import InputError

T = TypeVar("T")

GROUPS = {
    "expdesign.chain.effects": ("expdesign.physics", "identifier"),
    "expdesign.planning.criteria": ("expdesign.criteria", "name"),
    "expdesign.mechanics.robots": ("expdesign.robots", "kind"),
    "expdesign.mechanics.loads.errors": ("expdesign.load_errors", "source"),
    "expdesign.chain.ports.places": ("expdesign.ports", "name"),
}
"""Groups of entry points by the packages in which the kinds lie, and the attribute that names one of a kind."""
ELSEWHERE = {"expdesign.planning.criteria": ("expdesign.assurance.model_error.meir",)}
"""Packages and modules in which implementations of a kind lie beside the kind's own."""
_REGISTERED: list[type] = []


def implementations(package: str, base: type[T]) -> list[type[T]]:
    """Concrete subclasses of `base`: in the modules of `package` and of its folders, in their order, then in packages
    beside it (`ELSEWHERE`), then from outside.

    Raises:
        InputError: an entry point cannot be loaded, or is nothing of that kind.
    """
    return list(_known(package, base))  # type: ignore[arg-type]  # classes are hashable


@cache
def _known(package: str, base: type[T]) -> tuple[type[T], ...]:
    """The same, looked for once until `forget`: walking the folders of a package reads the disk."""
    found: list[type[T]] = []
    for place in (package, *ELSEWHERE.get(package, ())):
        path = getattr(importlib.import_module(place), "__path__", None)
        names = [place] if path is None else sorted(info.name for info in pkgutil.walk_packages(path, f"{place}."))
        for module in map(importlib.import_module, names):
            for value in vars(module).values():
                defined_here = isinstance(value, type) and value.__module__ == module.__name__
                if defined_here and issubclass(value, base) and not inspect.isabstract(value):
                    found.append(value)
    return (*found, *_from_outside(package, base, found)) if package in GROUPS else tuple(found)


def _from_outside(package: str, base: type[T], inside: list[type[T]]) -> list[type[T]]:
    """Registered classes and those of entry points; of two that files could not tell apart, none is taken silently."""
    group, attribute = GROUPS[package]
    further = [_loaded(point, base) for point in _points(group)] + [cls for cls in _REGISTERED if issubclass(cls, base)]
    known = {getattr(cls, attribute): cls for cls in inside}
    new = [cls for cls in dict.fromkeys(further) if cls not in inside]
    for cls in new:
        name = getattr(cls, attribute, None)
        where = f"`{cls.__module__}.{cls.__qualname__}`"
        if not isinstance(name, str) or not name:
            raise InputError(f"it has no `{attribute}`", where=where, remedy=f"Set `{attribute}` in the class.")
        if name in known:
            what = f'`{attribute} = "{name}"` is that of `{known[name].__module__}` already'
            raise InputError(what, where=where, remedy="Choose another one.")
        known[name] = cls
    return new


def add(cls: type) -> None:
    """Have a class counted among the implementations of its kind, in this process."""
    if cls not in _REGISTERED:
        _REGISTERED.append(cls)
    forget()


def remove(cls: type) -> None:
    """Undo `add`."""
    _REGISTERED.remove(cls)
    forget()


def forget() -> None:
    """Look for implementations anew."""
    _known.cache_clear()
    _points.cache_clear()


@lru_cache(maxsize=len(GROUPS))
def _points(group: str) -> tuple[EntryPoint, ...]:
    """Entry points of a group, in the order of their names: asking for them reads the metadata of all distributions."""
    return tuple(sorted(entry_points(group=group), key=lambda point: (point.name, point.value)))


def extensions() -> dict[str, str]:
    """Versions of the installed distributions that have entry points of any kind, by their names."""
    every = [point.dist for group, _ in GROUPS.values() for point in _points(group)]
    return {dist.name: dist.version for dist in every if dist is not None}


def _loaded(point: EntryPoint, base: type[T]) -> type[T]:
    """The class that an entry point names."""
    name = "an installed package" if point.dist is None else f"`{point.dist.name}`"
    where = f"entry point `{point.name}` of {name}, group `{point.group}`"
    remedy = f"Correct `{point.value}` in that package, or uninstall it."
    try:
        cls = point.load()
    except Exception as error:
        raise InputError(f"cannot be loaded ({type(error).__name__}: {error})", where=where, remedy=remedy) from error
    if not (isinstance(cls, type) and issubclass(cls, base)) or inspect.isabstract(cls):
        raise InputError(f"`{point.value}` is no concrete `{base.__name__}`", where=where, remedy=remedy)
    return cls

"""Find the implementations that lie in a package, so that adding one is adding one file."""

import importlib
import inspect
import pkgutil
from typing import TypeVar

T = TypeVar("T")


def implementations(package: str, base: type[T]) -> list[type[T]]:
    """Concrete subclasses of `base` in the modules of `package` and of its folders, in the order of the modules."""
    found: list[type[T]] = []
    path = importlib.import_module(package).__path__
    for info in sorted(pkgutil.walk_packages(path, f"{package}."), key=lambda module: module.name):
        module = importlib.import_module(info.name)
        for value in vars(module).values():
            defined_here = isinstance(value, type) and value.__module__ == module.__name__
            if defined_here and issubclass(value, base) and not inspect.isabstract(value):
                found.append(value)
    return found

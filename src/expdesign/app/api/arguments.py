"""Arguments of the package's functions, checked as their annotations say: names, whole numbers, bounds and choices."""

import inspect
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from functools import wraps
from numbers import Integral, Real
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, ParamSpec, TypeVar, Union, get_args, get_origin, get_type_hints

from expdesign.errors import ArgumentError
from expdesign.io.nearest import nearest

P = ParamSpec("P")
R = TypeVar("R")


@dataclass(frozen=True)
class Within:
    """What a number has to be; stands in the annotation of an argument.

    Attributes:
        noun: what a number beyond the bounds is not.
        remedy: what to give instead.
        low: least number, or with `strict` what it has to exceed.
        high: largest number, or with `strict` what has to exceed it.
        strict: whether the bounds are excluded.
    """

    noun: str
    remedy: str
    low: float
    high: float = float("inf")
    strict: bool = False

    def holds(self, value: float) -> bool:
        """Whether a number is within the bounds, and one at all."""
        return self.low < value < self.high if self.strict else self.low <= value <= self.high


Seed = Annotated[int, Within("a seed", "Use a whole number of at least 0.", 0)]


def hints_of(function: Callable[..., Any]) -> dict[str, Any]:
    """Annotations of a function; configurations, which are imported where they are needed, as paths."""
    return get_type_hints(function, localns={"Config": Path, "DesignProblem": Path}, include_extras=True)


def parts_of(hint: Any) -> tuple[Any, ...]:
    """The types of a union, or the one type; without None, and without what else an annotation says."""
    hint = get_args(hint)[0] if get_origin(hint) is Annotated else hint
    parts = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    return tuple(part for part in parts if part is not NoneType)


def choices_of(parts: Sequence[Any]) -> list[Any]:
    """What can be chosen of the types of an argument."""
    return [choice for part in parts if get_origin(part) is Literal for choice in get_args(part)]


def named_arguments(function: Callable[P, R]) -> Callable[P, R]:
    """Answer an unknown keyword with the nearest that the function has, and a value that its annotation excludes.

    Raises:
        TypeError: when it is called with such a keyword.
        ArgumentError: a number is none, not whole where it has to be, or beyond its bounds; or no choice that there is.
    """

    @wraps(function)
    def called(*args: P.args, **kwargs: P.kwargs) -> R:
        known, hints = inspect.signature(function).parameters, hints_of(function)
        for name, value in kwargs.items():
            if name not in known:
                raise TypeError(f"`{function.__name__}` has no argument `{name}`. {nearest(name, known)}")
            if value is not None or known[name].default is not None:
                kwargs[name] = _checked(name, value, hints[name])
        return function(*args, **kwargs)

    return called


def _checked(name: str, value: Any, hint: Any) -> Any:
    """The value of an argument, a whole number as one; raises an `ArgumentError` where the annotation excludes it."""
    parts = parts_of(hint)
    if get_origin(parts[0]) is Collection:
        choices = choices_of(parts_of(get_args(parts[0])[0]))
        wrong = [value] if isinstance(value, str) else [one for one in value if choices and one not in choices]
        if wrong:
            remedy = f"List some of {', '.join(choices)}." if choices else f"Write {wrong}."
            raise ArgumentError(f"`{wrong[0]}` is not in the list of what can be given", argument=name, remedy=remedy)
    choices = choices_of(parts)
    if choices and len(parts) == 1 and value not in choices:
        remedy = f"Choose {', '.join(choices[:-1])} or {choices[-1]}."
        raise ArgumentError(f"`{value}` is not known", argument=name, remedy=remedy)
    if set(parts) <= {int, float}:
        if not isinstance(value, Real):
            raise ArgumentError(f"{value!r} is not a number", argument=name, remedy="Give one, without quotes.")
        if int in parts and not isinstance(value, Integral):
            if not float(value).is_integer():
                raise ArgumentError(f"{value!r} is not a whole number", argument=name, remedy="Give a whole one.")
            value = int(float(value))
    for bounds in getattr(hint, "__metadata__", ()):
        if not bounds.holds(value):
            shown = value if isinstance(value, int) else f"{value:g}"
            raise ArgumentError(f"{shown} is not {bounds.noun}", argument=name, remedy=bounds.remedy)
    return value

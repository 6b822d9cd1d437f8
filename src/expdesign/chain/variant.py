"""Forms of one effect: a closed set of names (a `StrEnum`), or a value with a text form of its own.

An effect of one form has the variant `ONLY`, whose text is empty. Variants with numbers in them (a range of poses, the
size of a weight, another leg) are frozen dataclasses whose `str` is what files hold, and which round their numbers to
what that text says, so that a file gives back the same physics to the last bit.
"""

from enum import StrEnum
from typing import Protocol, runtime_checkable


@runtime_checkable
class Variant(Protocol):
    """Anything hashable with one text form."""

    def __str__(self) -> str: ...

    def __hash__(self) -> int: ...


class Only(StrEnum):
    """The variant of an effect that has one form."""

    ONLY = ""


ONLY = Only.ONLY


def rounded(value: float) -> float:
    """A number as a variant's text gives it back (six digits)."""
    return float(f"{value:.6g}")

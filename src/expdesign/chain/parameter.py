"""Parameters of effects and instruments: their sizes, their bounds, and what is known of them beforehand."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Parameter:
    """A parameter of an effect.

    Attributes:
        name: with its unit.
        scale: typical size, by which it is scaled in fits.
        neutral: value at which the effect vanishes (for a shape, a typical value).
        low, high: bounds.
        spread: standard deviation about `neutral` before anything is measured, infinite where nothing is known.
        shape: whether it only shapes the effect (a pitch, a time constant) and means nothing while the others are
            neutral.
    """

    name: str
    scale: float
    neutral: float = 0.0
    low: float = float("-inf")
    high: float = float("inf")
    shape: bool = False
    spread: float = float("inf")

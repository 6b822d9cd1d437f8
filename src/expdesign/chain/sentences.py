"""Reported values with their intervals, as they are written into sentences."""

from dataclasses import dataclass

ENDLESS = (-1e300, 1e300)
"""Interval of what nothing determines and no limit bounds: JSON has no infinite numbers."""


class Alone(float):
    """A number in a sentence: `{tau_s.best:1e3 .3g}` writes it in thousandths."""

    def __format__(self, spec: str) -> str:
        *factor, number = spec.split()
        return format(float(self) * float(factor[0]) if factor else float(self), number)


@dataclass(frozen=True)
class Reported:
    """An estimate with its interval in a sentence.

    `{gap:1e6 .3g}` is `12 (10 to 14)` in millionths, `{ratio:100 .1f %}` is `12.0 % (10.0 to 14.0 %)`, and
    `{cubic:softens|stiffens}` a word for what is positive and one for what is not. An interval that is all that is
    `possible` says nothing of the value.
    """

    best: Alone
    low: Alone
    high: Alone
    possible: tuple[float, float]

    @property
    def undetermined(self) -> bool:
        return (self.low, self.high) == self.possible

    def __format__(self, spec: str) -> str:
        if "|" in spec:
            return spec.split("|")[self.best <= 0.0]
        if self.undetermined:
            return "undetermined"
        spec, percent, _ = spec.partition(" %")
        return f"{self.best:{spec}}{percent} ({self.low:{spec}} to {self.high:{spec}}{percent})"


class Listed(tuple[Reported, ...]):
    """All values in a sentence, without their intervals: `{all:1e3 .2f}`."""

    def __format__(self, spec: str) -> str:
        return ", ".join(format(each if each.undetermined else each.best, spec) for each in self)

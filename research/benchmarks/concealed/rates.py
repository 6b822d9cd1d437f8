"""Shares with what chance makes of them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import sqrt


@dataclass(frozen=True)
class Rate:
    """`hits` of `total`."""

    hits: int
    total: int

    @classmethod
    def of(cls, values: Iterable[bool]) -> Rate:
        drawn = [bool(value) for value in values]
        return cls(sum(drawn), len(drawn))

    @property
    def share(self) -> float:
        return self.hits / self.total if self.total else float("nan")

    @property
    def standard_error(self) -> float:
        """Binomial standard error sqrt(p (1 - p) / n)."""
        return sqrt(self.share * (1 - self.share) / self.total) if self.total else float("nan")

    @property
    def interval(self) -> tuple[float, float]:
        """95 % interval (E. B. Wilson, J. Am. Stat. Assoc. 22 (1927) 209), which is not empty at 0 and 1."""
        if not self.total:
            return 0.0, 1.0
        z, n, p = 1.96, self.total, self.share
        middle, half = p + z**2 / (2 * n), z * sqrt(p * (1 - p) / n + z**2 / (4 * n**2))
        return max((middle - half) / (1 + z**2 / n), 0.0), min((middle + half) / (1 + z**2 / n), 1.0)

    def __str__(self) -> str:
        if not self.total:
            return "no cases"
        low, high = self.interval
        return (
            f"{100 * self.share:.1f} ± {100 * self.standard_error:.1f} % ({self.hits} of {self.total};"
            f" 95 %: {100 * low:.0f}-{100 * high:.0f} %)"
        )


def grid(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """A table in Markdown."""
    return [f"| {' | '.join(row)} |" for row in (head, ["---"] * len(head), *rows)]

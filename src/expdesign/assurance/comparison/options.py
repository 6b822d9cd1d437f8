"""How criteria are compared."""

from dataclasses import dataclass


@dataclass(frozen=True)
class ComparisonOptions:
    """Thresholds and numbers of a comparison.

    Attributes:
        probes: designs on which criteria are compared.
        same: relative difference below which two criteria are the same.
        agreement: part of the attained error below which designs are said to be equally accurate.
        fewest: designs below which there is no correlation worth the name.
        resamples: of the bootstrap of a correlation's interval.
        said: differences of two configurations that a message lists.
    """

    probes: int = 8
    same: float = 1e-12
    agreement: float = 1e-3
    fewest: int = 4
    resamples: int = 2000
    said: int = 4


COMPARISON = ComparisonOptions()
"""What commands use."""

"""What a decision on a robot takes for the same, for impossible or for nothing."""

from dataclasses import dataclass


@dataclass(frozen=True)
class AcceptanceOptions:
    """Thresholds of acceptance and verification.

    Attributes:
        rounding: relative; an axis with U = T passes.
        most: repetitions or readings beyond which a number is as good as none.
        draws: of every union of axes, from one fixed seed: the same recordings are decided alike.
        negligible: sum of the axes' probabilities below which that sum, an upper bound, stands for the union.
        same_target: m or rad, N or N·m by which rows of one target may differ.
        farthest: m or rad; a measured pose farther from its target is in another unit or frame.
    """

    rounding: float = 1e-9
    most: int = 1_000_000
    draws: int = 1024
    negligible: float = 1e-9
    same_target: float = 1e-7
    farthest: float = 0.1


ACCEPTANCE = AcceptanceOptions()
"""What commands use."""

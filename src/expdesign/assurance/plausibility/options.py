"""When something is called a mistake: every threshold of the judgement of recordings."""

from dataclasses import dataclass


@dataclass(frozen=True)
class MistakeOptions:
    """Thresholds, which lie far outside what sound recordings of machines with any physics reach.

    Attributes:
        gain: factor by which an alternative reading must reduce the misfit.
        poor: misfit below which nothing needs an explanation by a mistake where noise is not stated.
        fair: misfit below which the signs and sizes of compliances mean something.
        most: share of the compliances of one sign that makes it the sign of all.
        odds: how much likelier than chance a mistake must be, for each alternative that is tried.
        refuted: p-value of χ² below which the recordings as they are do not fit the robot with their stated noise.
        consistent: p-value above which they do under an alternative; it is then named whatever the gain.
        unit_ratio: factor between identified and stated stiffness beyond which a unit is suspected.
        alike: standard deviation of the logarithms of the actuators' factors below which they are one factor.
        near: distance of the logarithm of that factor from a known one within which it is that one.
        exact: the same two for factors near 1, which robots may have as well: their common distance and spread.
        chance: probability by which structure in the numbers (copies, rounding, scatter) may be accident.
        repeatability: how many times better than stated readings may repeat.
        noisy: bounds on the factor by which all columns scatter more than stated, when that is a mistake of the unit.
        enough: degrees of freedom from which on the scatter of rows and columns is compared.
        slip: standard deviations from what the others say beyond which slips are tried for a row or a reading.
        candidates: of these so many, the most conspicuous ones.
        rows: rows beyond which further ones are not looked at.
    """

    gain: float = 10.0
    poor: float = 1e-3
    fair: float = 0.1
    most: float = 0.8
    odds: float = 1e4
    refuted: float = 1e-6
    consistent: float = 0.01
    unit_ratio: float = 30.0
    alike: float = 0.35
    near: float = 0.15
    exact: float = 0.04
    chance: float = 1e-6
    repeatability: float = 10.0
    noisy: float = 0.2
    enough: float = 40.0
    slip: float = 3.0
    candidates: int = 4
    rows: int = 3000


DEFAULT = MistakeOptions()
"""What commands use."""

"""What the residuals say of standard deviations that were stated."""

from dataclasses import dataclass

from expdesign.chain.recordings.recordings import Remark


@dataclass(frozen=True)
class NoiseBeyondStated(Remark):
    """Residuals exceed the stated noise, and a second component was estimated.

    Attributes:
        name: `translations` or `rotations`.
        stated: RMS of the stated standard deviations (m or rad).
        needed: what they would have to be.
        extra: the second component, needed² − stated².
    """

    name: str
    stated: float
    needed: float
    extra: float


@dataclass(frozen=True)
class GenerousNoise(Remark):
    """The stated standard deviations are far larger than the residuals, from which the noise was estimated.

    Attributes:
        name: `translations` or `rotations`.
        stated: RMS of the stated standard deviations (m or rad).
        needed: what the residuals show.
    """

    name: str
    stated: float
    needed: float

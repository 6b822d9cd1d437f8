"""All effects at once: of a machine with many small errors (`many`), or of what a body stands on (`support_laws`)."""

from collections.abc import Sequence
from dataclasses import dataclass

from expdesign.diagnosis.stability import Stability
from expdesign.identification.fit import Fit
from expdesign.ports.curve import Curve


@dataclass(frozen=True, kw_only=True)
class GroupAtOnce:
    """Effects that share a factor on their deviations.

    Attributes:
        size: RMS of what they do to the readings, in standard deviations.
        determined: how many of their parameters the data determine.
        curve: of its first law, or of all laws of the load; None for effects of known form.
    """

    size: float
    determined: float
    curve: Curve | None = None


@dataclass(frozen=True, kw_only=True)
class AtOnce:
    """All effects together.

    Attributes:
        fit: of the chain with all effects that are there.
        groups: those that are there, largest first.
        before, after: RMS of left-out readings without and with them.
        noise: standard deviation of the whitened residuals.
        stability: how often nine tenths of the rows keep the same groups, in their order; None where groups have no
            names that refits could repeat.
    """

    fit: Fit
    groups: Sequence[GroupAtOnce]
    before: float
    after: float
    noise: float
    stability: Stability | None = None

"""All effects at once: of a machine with many small errors (`many`), or of what a body stands on (`support_laws`)."""

from collections.abc import Sequence
from dataclasses import dataclass

from expdesign.arrays import BoolArray
from expdesign.chain.ports.curve import Curve
from expdesign.diagnosis.options import OPTIONS
from expdesign.diagnosis.stability import Stability
from expdesign.estimation.fit import Fit


@dataclass(frozen=True, kw_only=True)
class GroupAtOnce:
    """Effects that share a factor on their deviations.

    Attributes:
        size: RMS of what they do to the readings, in standard deviations.
        determined: how many of their parameters the data determine.
        p_value: that left-out blocks are predicted no better with them.
        curve: of its first law, or of all laws of the load; None for effects of known form.
    """

    size: float
    determined: float
    p_value: float
    curve: Curve | None = None

    def probability(self, *, beside_laws: bool) -> float:
        """That it is there: that it predicts what was left out, as far as no other law may stand in for it."""
        return (OPTIONS.beside_laws if beside_laws else OPTIONS.most) * (1.0 - self.p_value)


@dataclass(frozen=True, kw_only=True)
class AtOnce:
    """All effects together.

    Attributes:
        fit: of the chain with all effects that are there.
        groups: those that are there, largest first.
        before, after: RMS of left-out readings without and with them.
        noise: standard deviation of the whitened residuals.
        aside: rows that were set aside as single mistakes, shape (N,).
        stability: how often nine tenths of the rows keep the same groups, in their order; None where groups have no
            names that refits could repeat.
    """

    fit: Fit
    groups: Sequence[GroupAtOnce]
    before: float
    after: float
    noise: float
    aside: BoolArray
    stability: Stability | None = None

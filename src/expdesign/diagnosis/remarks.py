"""What limits the statements of a diagnosis, as data; the sentences are in `report/remark_texts.py`."""

from dataclasses import dataclass
from enum import StrEnum

from expdesign.chain.recordings.recordings import Remark


@dataclass(frozen=True)
class AliasedParameters(Remark):
    """Parameters that stay what was assumed, because only combinations of them are determined.

    Attributes:
        names: of the parameters.
    """

    names: tuple[str, ...]


@dataclass(frozen=True)
class WithoutMoment(Remark):
    """Directions about which no load had a moment.

    Attributes:
        directions: unit vectors, components each.
    """

    directions: tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class Extrapolation(Remark):
    """Held-out rows depend on what the fitted rows do not determine.

    Attributes:
        held_out, fitted: errors in standard deviations.
    """

    held_out: float
    fitted: float


@dataclass(frozen=True)
class SerialCorrelation(Remark):
    """Residuals of consecutive rows are alike.

    Attributes:
        correlation: of neighbours.
        rows: that were fitted.
        effective_rows: as many independent ones would tell as much.
    """

    correlation: float
    rows: int
    effective_rows: float


@dataclass(frozen=True)
class ConfoundedTime(Remark):
    """Something else changed with time, so that a drift is hard to tell from it.

    Attributes:
        name: of what changed.
        share: of the variance of time that follows from it.
        imitations: keys of drifts that do not show apart from it, and are not named.
    """

    name: str
    share: float
    imitations: tuple[str, ...]


@dataclass(frozen=True)
class TooFewForLaws(Remark):
    """No law at a port can be sought.

    Attributes:
        rows: that may be fitted.
        needed: number of them that a law takes.
    """

    rows: int
    needed: int


class Sought(StrEnum):
    """Kinds of laws, and what recordings must have for one to be sought."""

    TIME = "time"
    MEMORY = "memory"
    PLACE = "place"
    FORCE = "force"


@dataclass(frozen=True)
class NotSought(Remark):
    """A kind of law that these recordings cannot show."""

    law: Sought


@dataclass(frozen=True)
class WrittenOtherwise(Remark):
    """The model file predicts the fitted rows otherwise than the diagnosis says of itself.

    Attributes:
        difference: RMS in standard deviations of a reading.
    """

    difference: float


@dataclass(frozen=True)
class Averaged(Remark):
    """Too little was measured to tell what is there, so that predictions are averages.

    Attributes:
        rows: that were fitted.
        effects: over which predictions are averaged, the likeliest first.
    """

    rows: int
    effects: tuple[str, ...]

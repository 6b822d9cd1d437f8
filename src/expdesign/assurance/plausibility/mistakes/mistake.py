"""What a kind of mistake says about itself: how recordings with it would have to be read, or what gives it away."""

from collections.abc import Iterator
from dataclasses import dataclass

from expdesign.assurance.plausibility.evidence import Evidence, Hypothesis
from expdesign.assurance.plausibility.finding import Implausibility


@dataclass(frozen=True)
class Alternative:
    """Another reading of the same recordings.

    Attributes:
        sentence: what was mistaken, and what to do.
        sample: the recordings read so.
        where: row and column, where it concerns one.
        tried: of how many alternatives of its kind it was the most promising, without fitting the others.
    """

    sentence: str
    sample: Hypothesis
    where: str = ""
    tried: int = 1


class Mistake:
    """A kind of mistake. Alternatives of all kinds compete, and the best is named; findings stand for themselves."""

    def alternatives(self, evidence: Evidence) -> Iterator[Alternative]:
        """The recordings as they would be without the mistake."""
        return iter(())

    def findings(self, evidence: Evidence) -> Iterator[Implausibility]:
        """What gives the mistake away without a comparison."""
        return iter(())

"""Signs of readings and of loads."""

from collections.abc import Iterator

import numpy as np

from expdesign.assurance.plausibility.evidence import Evidence
from expdesign.assurance.plausibility.mistakes.mistake import Alternative, Mistake


class TurnedSigns(Mistake):
    """Everything, one column, or all translations or rotations with the other sign."""

    def alternatives(self, evidence: Evidence) -> Iterator[Alternative]:
        stated, linear, count = evidence.stated, evidence.linear, len(evidence.axes)
        yield Alternative(
            "Have all deflections, or all loads, the wrong sign? A deflection is the loaded minus the unloaded pose, "
            "and a load what the environment applies to the platform.",
            stated.scaled(np.full(count, -1.0)),
        )
        for column, name in enumerate(evidence.names):
            factors = np.ones(count)
            factors[column] = -1.0
            yield Alternative(f"Has {name} the wrong sign?", stated.scaled(factors))
        for kind, noun in ((linear, "translations"), (~linear, "rotations")):
            if kind.sum() > 1:
                yield Alternative(f"Have the {noun} the wrong sign?", stated.scaled(np.where(kind, -1.0, 1.0)))

"""Where laws are, by evidence over ports: every component is given its chance in the place of one that was found.

The log evidence of a component is what its laws gain together (`Search.weighed`), with the laws of all other
components kept. Machines and kernels are never exact, so that differences of log evidence are divided by a
temperature before they become probabilities; it was set on simulated cases (results/ports).
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from expdesign.chain.component import Component
from expdesign.diagnosis.evidence.options import EVIDENCE


@dataclass(frozen=True)
class Place:
    """A component where a law may be.

    Attributes:
        component: where.
        log_evidence: gain of log evidence by its laws together.
        probability: that the law is there.
    """

    component: Component
    log_evidence: float
    probability: float


def places(gains: Mapping[Component, float]) -> tuple[Place, ...]:
    """Components by probability, from the gain of log evidence by the laws of each."""
    names = sorted(gains, key=lambda name: -gains[name])
    evidence = np.array([gains[name] for name in names])
    temperature = max(EVIDENCE.temperature, EVIDENCE.share * float(evidence.max()))
    weights = np.exp((evidence - evidence.max()) / temperature)
    weights /= weights.sum()
    return tuple(Place(name, float(e), float(w)) for name, e, w in zip(names, evidence, weights, strict=True))

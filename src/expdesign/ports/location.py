"""Where laws are, by evidence over ports: every component is given its chance in the place of a law that was found.

The log evidence of a component is the mean of exp(gain) over its entries (all are equally probable beforehand), with
the other laws kept. Machines and kernels are never exact, so that differences of log evidence are divided by a
temperature before they become probabilities; it was set on simulated cases (`benchmarks/ports/calibration.py`).
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import Component
from expdesign.ports.dictionary import Atom

TEMPERATURE = 16.0
"""Divides differences of log evidence: the most likely of 1 to 16 on 16 cases (results/ports)."""
SHARE = 0.005
"""Differences of log evidence count at most in this proportion to the evidence itself: no model is exact."""
OPEN = 0.05
"""Probability from which a component belongs to the set that cannot be told apart."""


@dataclass(frozen=True)
class Place:
    """A component where a law may be.

    Attributes:
        component: where.
        log_evidence: gain of log evidence by its laws, averaged over its entries.
        probability: that the law is there.
    """

    component: Component
    log_evidence: float
    probability: float


def places(atoms: list[Atom], gains: FloatArray) -> tuple[Place, ...]:
    """Components by probability, from the gains of all entries of the dictionary beside the other laws."""
    by_component: dict[Component, list[float]] = {}
    for atom, gain in zip(atoms, gains, strict=True):
        by_component.setdefault(atom.component, []).append(float(gain))
    names = list(by_component)
    evidence = np.array([_log_mean(np.array(by_component[name])) for name in names])
    temperature = max(TEMPERATURE, SHARE * float(evidence.max()))
    weights = np.exp((evidence - evidence.max()) / temperature)
    weights /= weights.sum()
    order = np.argsort(-evidence, kind="stable")
    return tuple(Place(names[i], float(evidence[i]), float(weights[i])) for i in order)


def _log_mean(gains: FloatArray) -> float:
    most = float(gains.max())
    return most + float(np.log(np.exp(gains - most).mean()))

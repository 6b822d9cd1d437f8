"""Laws that were found, as links of the chain: forms with the features that the readings tell something about."""

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.ports.dictionary import Atom
from expdesign.chain.ports.features import Basis
from expdesign.chain.ports.law import Form, Law
from expdesign.chain.ports.sight import Sight
from expdesign.mechanics.robots.robot import Robot

_TELLING = 0.02
"""Features that change the readings by less, in variances of the noise summed over all rows, are left out: the readings
say nothing of them, and they do nothing to the readings."""


def law_of(
    atom: Atom, variance: float, weights: FloatArray, sight: Sight, robot: Robot, number: int
) -> tuple[Law, FloatArray]:
    """The link of a law and its parameters, from its weights in the dictionary's features (f,)."""
    entry, basis = atom.entry, atom.basis
    assert entry is not None
    assert basis is not None
    blocks, rank = entry.blocks, basis.rank
    gram = np.zeros((rank, rank))
    for block in range(blocks):
        own = slice(block * rank, (block + 1) * rank)
        gram += atom.gram[own, own]
    values, vectors = np.linalg.eigh(gram)
    kept = np.flatnonzero(variance * values > _TELLING)[::-1]
    turned = vectors[:, kept if kept.size else [-1]]
    smaller = Basis(basis.kernel, basis.scales, basis.centres, basis.weights @ turned)
    counts = sight.counts
    low, high = [], []
    for channel in entry.channels:
        # Channels of one block are one law, such as that of a load less that of its reference, with one range.
        alike = {other.inputs for other in entry.channels if other.block == channel.block}
        seen = np.concatenate([np.column_stack([sight.values(q)[counts] for q in inputs]) for inputs in alike])
        low.append(seen.min(axis=0))
        high.append(seen.max(axis=0))
    form = Form(
        entry.port, entry.component, entry.form, entry.channels, smaller, np.array(low), np.array(high),
        float(np.sqrt(variance)),
    )  # fmt: skip
    law = Law(robot, form, number)
    start = np.concatenate([turned.T @ weights[b * rank : (b + 1) * rank] for b in range(blocks)])
    return law, np.concatenate([start, np.zeros(len(law.parameters) - len(start))])

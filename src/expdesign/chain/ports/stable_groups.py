"""Which groups of effects nine tenths of the rows keep."""

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.chain.ports.everything import Everything, Linearised, Priors, chosen_groups


def kept_groups(found: Everything, priors: Priors, blocks: IntArray, tenths: IntArray) -> list[frozenset[int]]:
    """The groups that are kept without each tenth of the readings, on the linearised problem.

    Args:
        found: all effects fitted together, where the problem is linearised.
        priors: with all groups, as before any was left out.
        blocks: block of every reading that is left out together to choose groups, shape (M,).
        tenths: part of every reading that is left out of a refit, shape (M,).
    """
    kept = []
    for tenth in np.unique(tenths):
        rows = tenths != tenth
        _, chosen = chosen_groups(_linear(found, rows), priors, found.values, blocks[rows], rounds=3)
        kept.append(frozenset(np.unique(chosen.group[chosen.group >= 0]).tolist()))
    return kept


def _linear(found: Everything, rows: BoolArray) -> Linearised:
    residuals, slopes = found.residuals[rows], found.slopes[rows]

    def of(values: FloatArray) -> tuple[FloatArray, FloatArray]:
        return residuals - slopes @ (values - found.values), slopes

    return of

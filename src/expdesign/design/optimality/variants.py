"""The measurements of designs, each with one variable changed: what a neighbour differs in."""

import numpy as np

from expdesign.arrays import BoolArray, FloatArray
from expdesign.design.problem import DesignProblem

_LEVELS = 6


def variants(problem: DesignProblem, parents: FloatArray, wanted: BoolArray | None = None) -> FloatArray:
    """The measurements of designs (b, m, g), each with one variable changed, all or those wanted (g,), shape
    (b, m, v, g).
    """
    space, found = problem.space, []
    for decision in np.arange(space.decisions) if wanted is None else np.flatnonzero(wanted):
        low, high = space.lower[decision], space.upper[decision]
        if not space.discrete[decision]:
            values = [np.full(parents.shape[:2], end) for end in (low, 0.5 * (low + high), high)]
        elif high < _LEVELS:
            values = [np.full(parents.shape[:2], level) for level in np.arange(high + 1.0)]
        else:
            values = [np.clip(parents[..., decision] + step, low, high) for step in (-1.0, 1.0)]
            values += [np.full(parents.shape[:2], end) for end in (low, high)]
        for value in values:
            changed = parents.copy()
            changed[..., decision] = value
            found.append(changed)
    if problem.noise.shared_reference and wanted is None:
        # A step away from a series, with a reference of its own; and at the pose of another one.
        found.append(space.inward(parents, 1))
        found += [np.where(space.of_pose, np.roll(parents, k, axis=1), parents) for k in range(1, parents.shape[1])]
    return np.stack(found, axis=2)

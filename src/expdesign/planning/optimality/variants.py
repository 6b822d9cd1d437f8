"""The measurements of designs, each with one variable changed: what a neighbour differs in."""

import numpy as np

from expdesign.arrays import BoolArray, FloatArray
from expdesign.planning.problem import DesignProblem

_LEVELS = 6


def variants(problem: DesignProblem, parents: FloatArray, wanted: BoolArray | None = None) -> FloatArray:
    """The measurements of designs (b, m, g), each with one variable changed, all or those wanted (g,), shape
    (b, m, v, g).
    """
    space, found = problem.space, []
    chosen = np.ones(space.decisions, dtype=bool) if wanted is None else wanted.copy()
    if space.settings is not None:
        chosen[space.settings.gene] = False
    for decision in np.flatnonzero(chosen):
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
    settings = space.settings
    if settings is not None and wanted is None:
        others = [np.roll(parents, k, axis=1) for k in range(1, parents.shape[1])]
        if settings.shared:
            # Its pose set anew, with a reference of its own; and at the pose of another one, with or without that's.
            found.append(space.anew(parents))
            found += [np.where(space.of_pose, space.anew(other), parents) for other in others]
        found += [np.where(space.of_pose, other, parents) for other in others]
        if settings.budget is not None:
            for setting in (0.0, settings.first):
                changed = parents.copy()
                changed[..., settings.gene] = setting
                found.append(changed)
    return np.stack(found, axis=2) if found else parents[:, :, None]

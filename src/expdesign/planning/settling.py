"""The designs of a front, brought to where the optimality conditions hold.

A front is followed by predictions between its designs, of which those in the widest gaps alone are corrected. What is
written is pursued to its end; a design that is still rough then is left out where the front can do without it.
"""

import numpy as np

from expdesign.arrays import BoolArray, FloatArray
from expdesign.planning.operators.operator import State
from expdesign.planning.optimality.descents import Pace, descended
from expdesign.planning.optimality.kktpm import kktpm
from expdesign.planning.scalarisation import at_points, spans

_PACE = Pace(steps=30, tolerance=1e-8, inner=1e-7)


def settle(state: State, chosen: FloatArray) -> None:
    """Pursue those of designs (d, m, g) that do not satisfy the optimality conditions to the end, in the archive."""
    space, archive = state.problem.space, state.archive
    # In coarse steps, or held by other constraints, an optimum does not satisfy the conditions of a continuous one.
    coarse = bool((space.grid.steps > state.options.settled * (space.upper - space.lower)).any())
    if not state.smooth or coarse or state.problem.constraints is not None or len(chosen) == 0:
        return
    rough = chosen[~(kktpm(state.problem, chosen) <= state.options.settled)]
    if len(rough) == 0:
        return
    values, _ = state.population.criteria(rough)
    aims = at_points(values[:, : archive.objectives], spans(archive.values)[: archive.objectives], values.shape[1])
    found, _ = descended(state.objectives, rough, aims, _PACE)
    archive.add(*state.evaluated(found))
    known = {design.tobytes(): place for place, design in enumerate(archive.designs)}
    left = [known[design.tobytes()] for design in rough if design.tobytes() in known]
    ends = set(np.argmin(archive.values, axis=0).tolist())
    drop: BoolArray = np.zeros(len(archive), dtype=bool)
    drop[[place for place in left if place not in ends]] = True
    if not drop.all():
        archive.designs, archive.values = archive.designs[~drop], archive.values[~drop]

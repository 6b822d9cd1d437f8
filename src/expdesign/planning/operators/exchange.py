"""Exchange of single measurements: how a search leaves a valley, which gradients cannot.

Which pose or mass comes first, where exactly comes from gradients afterwards. Measurements are exchanged for those that
other good designs have, for some drawn at random, or for themselves with one variable at another of its values: an end
of its range, a neighbour on its grid, another choice, the pose of another measurement of the plan. Whole settings of
the robot are moved, and within a budget time is freed for what takes more. Where criteria are sums over measurements
every exchange is judged, one after the other until none helps (Fedorov 1972); else some of them, drawn at random.
"""

import math

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.planning.operators.state import AIMS, BRIEF_STEPS, LIBRARY, State
from expdesign.planning.optimality.exchange import variants
from expdesign.planning.sampling import extreme_measurements, reachable_measurements
from expdesign.planning.scalarisation import Aims, achieved

_POSES = 40
"""Drawn at random, and of good designs, to which whole settings are moved."""


class SingleExchange:
    """Exchanges one measurement after the other, of the best designs and of designs drawn at random."""

    name = "exchange"

    def propose(self, state: State) -> FloatArray:
        aims = state.aims(AIMS)
        parents = state.best(aims)
        found, of = [], []
        if state.sums and len(state.library):
            # From anywhere too for what everything else hangs on; for points along the front in turn.
            random = np.flatnonzero(aims.single | (state.generator.random(len(aims)) < 0.3))
            own = np.concatenate([np.arange(len(aims)), random])
            found.append(self._by_sums(state, parents, aims[own], len(random)))
            of.append(own)
        space = state.problem
        if not state.sums or space.constraints is not None:
            found.append(drawn_exchanges(state, parents, aims))
            of.append(np.arange(len(aims)))
        designs, places = np.concatenate(found), np.concatenate(of)
        changed = (designs != parents[places]).any(axis=(1, 2))
        designs, places = designs[changed], places[changed]
        both = np.concatenate([designs.reshape(len(designs), math.prod(designs.shape[1:])), places[:, None]], axis=1)
        first = np.sort(np.unique(both, axis=0, return_index=True)[1])
        designs, places = designs[first], places[first]
        return state.descended(designs, aims[places], BRIEF_STEPS)

    @staticmethod
    def _by_sums(state: State, parents: FloatArray, aims: Aims, random: int) -> FloatArray:
        """Designs after exchanges from parents (b, m, g) and from so many drawn at random, for aims of both."""
        space = state.problem.space
        offered = state.library
        if state.gridded:
            drawn = extreme_measurements(state.problem, LIBRARY, 1.0, state.generator)
            offered = np.concatenate([offered, np.unique(drawn, axis=0)])
        plans = _random_plans(len(offered), random, space.measurements, state.generator)
        designs = np.concatenate([_thinned(state, parents), offered[plans]])
        exchange = state.exchange
        found = designs.copy()
        if space.settings is not None:
            drawn = extreme_measurements(state.problem, _POSES, float(state.generator.random()), state.generator)
            found = exchange.moved(designs, aims, np.concatenate([drawn, offered[:_POSES]]))
        # Where settings count, each measurement has many alternatives already.
        chance = 0.5 if space.settings is None else 0.0
        varied = state.gridded or bool(state.generator.random() < chance)
        for some, own, loaded in ((aims.single, varied, True), (~aims.single, state.gridded, state.gridded)):
            found[some] = exchange.singles(found[some], aims[some], offered, varied=own, loaded=loaded)
        return found


def _thinned(state: State, designs: FloatArray) -> FloatArray:
    """Designs (b, m, g), of which every second one leaves out some measurements where time is limited.

    Within a budget no exchange of a single measurement pays for a further pose: what it takes has to be freed first
    (ruin and recreate, Schrimpf et al., J. Comput. Phys. 159 (2000) 139).
    """
    settings = state.problem.space.settings
    if settings is None or settings.budget is None:
        return designs
    left = state.generator.random(designs.shape[:2]) >= 0.7
    left &= (np.arange(len(designs)) % 2 == int(state.generator.integers(2)))[:, None]
    found = designs.copy()
    found[..., settings.gene] = np.where(left, 0.0, designs[..., settings.gene])
    return found


def _random_plans(listed: int, count: int, m: int, generator: np.random.Generator) -> IntArray:
    """Plans (count, m) of a list's measurements at random, each with one of them repeated none to m times."""
    plans = generator.integers(listed, size=(count, m))
    repeated = np.arange(m) < generator.integers(1, m + 1, size=(count, 1))
    found: IntArray = np.where(repeated, plans[:, :1], plans)
    return found


def drawn_exchanges(state: State, parents: FloatArray, aims: Aims) -> FloatArray:
    """Designs (b, m, g) after some exchanges of one measurement, half of them of one variable, each the best of some
    drawn at random and judged by the criteria themselves. The first exchange may also be for the worse.
    """
    common = reachable_measurements(state.problem, 24, state.generator)
    common = np.concatenate([state.library, common]) if len(state.library) else common
    found, score = _best_drawn(state, parents, aims, common)
    moving = np.arange(len(parents))
    for _ in range(6 if state.gridded else 0):
        tried, reached = _best_drawn(state, found[moving], aims[moving], common)
        better = reached < score[moving] - 1e-9 * (1.0 + np.abs(score[moving]))
        moving, tried = moving[better], tried[better]
        found[moving], score[moving] = tried, reached[better]
        if moving.size == 0:
            break
    return found


def _best_drawn(state: State, parents: FloatArray, aims: Aims, common: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The best of exchanges of designs (b, m, g) that are drawn, and how far they are from their aims, (b,).

    Args:
        state: what the search knows.
        parents: the designs.
        aims: of each, b.
        common: measurements for which any is exchanged, shape (l, g).
    """
    batch, m, _ = parents.shape
    space, drawn = state.problem.space, 60
    draw, own = state.generator.integers, variants(state.problem.space, parents)
    trials = np.repeat(parents[:, None], drawn, axis=1)
    first, second = np.indices((batch, drawn))
    place = draw(m, size=(batch, drawn))
    varied = own[first, place, draw(own.shape[2], size=(batch, drawn))]
    listed = common[draw(len(common), size=(batch, drawn))]
    if state.problem.noise.shared_reference:
        # Another load at the pose of a measurement that the plan has: they share their reference.
        there = parents[first, draw(m, size=(batch, drawn))]
        listed = np.where(space.of_pose & (second % 4 == 1)[..., None], there, listed)
    trials[first, second, place] = np.where((second % 2 == 0)[..., None], varied, listed)
    trials = space.canonical(trials)
    # One parent after the other: before each assessment it is asked whether time is over.
    values = np.stack([state.objectives.values(state.problem.assessed(designs)) for designs in trials])
    score = achieved(values, aims.centres[:, None], aims.weights[:, None])
    none = np.isnan(values).any(axis=-1) | ~np.isfinite(score) | (trials == parents[:, None]).all(axis=(2, 3))
    score[none] = np.inf
    return trials[np.arange(batch), score.argmin(axis=1)], score.min(axis=1)

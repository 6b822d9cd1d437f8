"""Exchange of measurements where criteria are sums over them (`plan_sums.py`): one, or a plan of repeated ones.

Fedorov 1972 exchanges one measurement after the other until none helps. What it does not find: load errors that each
measurement has of its own average out over repetitions of whichever measurement suffers least.
"""

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.planning.optimality.plan_sums import PlanSums
from expdesign.planning.problem import DesignProblem
from expdesign.planning.scalarisation import Aims, achieved

_TOGETHER = 10_000_000
"""Entries of the sums that are formed at a time, at most."""
_HELPS = 1e-9
"""Relative gain that counts as one."""

ADDITIVE = ("duir", "feir", "total")
"""Criteria that are functions of sums over measurements."""


def exchanges_are_sums(problem: DesignProblem, names: tuple[str, ...]) -> bool:
    """Whether criteria with these names depend on sums over measurements, of which each may be exchanged by itself."""
    return not set(names) - set(ADDITIVE)


class Exchange:
    """Exchanges of measurements, judged by sums.

    Args:
        problem: the design problem.
        names: of the criteria k of the aims, all in `ADDITIVE`.
        factor: on the load errors, so that `total` is √(DUIR² + factor²·FEIR²).
    """

    def __init__(self, problem: DesignProblem, names: tuple[str, ...], factor: float = 1.0) -> None:
        self._problem, self._space, self._names = problem, problem.space, names
        self._sums = PlanSums(problem, factor)

    def _scores(self, sums: FloatArray, centres: FloatArray, weights: FloatArray) -> FloatArray:
        """How far designs are from their aims, (...), by their sums (..., c); centres and weights (..., k)."""
        with np.errstate(all="ignore"):
            noise, force = self._sums.variances(sums)
            both = {"duir": noise, "feir": force, "total": noise + force}
            values = np.stack([np.sqrt(both[name].max(axis=-1)) for name in self._names], axis=-1)
            score = achieved(values, centres, weights)
        usable: FloatArray = np.where(np.isfinite(score), score, 1e30)
        return usable

    def scores(self, designs: FloatArray, aims: Aims) -> FloatArray:
        """How far designs (b, m, g) are from their aims, shape (b,)."""
        parts = self._sums.parts(designs.reshape(-1, designs.shape[-1])).reshape(*designs.shape[:2], -1)
        sums = self._sums.sums(parts, designs[..., self._space.of_pose])
        return self._scores(sums, aims.centres, aims.weights)

    def singles(
        self, designs: FloatArray, aims: Aims, common: FloatArray, *, varied: bool = False, loaded: bool = False
    ) -> FloatArray:
        """Designs (b, m, g) at which no exchange of one measurement helps.

        Args:
            designs: where exchanges begin, shape (b, m, g).
            aims: of each, b.
            common: measurements for which any is exchanged, shape (l, g).
            varied: whether measurements are exchanged for their own variants too.
            loaded: whether, where references are shared, they are exchanged for loads near those of others, at their
                poses.
        """
        if len(designs) == 0:
            return designs
        sums, designs = self._sums, designs.copy()
        (batch, m, g), count, pose = designs.shape, len(common), self._space.of_pose
        shared, own = sums.parts(common), varied or self._space.settings is not None
        there = sums.parts(designs.reshape(-1, g)).reshape(batch, m, -1)
        score = self._scores(sums.sums(there, designs[..., pose]), aims.centres, aims.weights)
        moving, settings = np.arange(batch), self._space.settings
        together = max(1, _TOGETHER // (count * shared.shape[1]))
        for sweep in range(8):
            helped = np.zeros(batch, dtype=bool)
            for place in range(m):
                self._problem.interrupt()
                for start in range(0, len(moving), together):
                    part = moving[start : start + together]
                    # Sums of what remains, not differences, which would lose digits.
                    others, rest = np.delete(designs[part], place, axis=1), np.delete(there[part], place, axis=1)
                    options = sums.joined(rest, others[..., pose], shared[None], common[None][..., pose])
                    if own:
                        more = self._own_options(designs[part], place, varied, sweep if loaded else None)
                        theirs = sums.parts(more.reshape(-1, g)).reshape(*more.shape[:2], -1)
                        joined = sums.joined(rest, others[..., pose], theirs, more[..., pose])
                        options = np.concatenate([options, joined], axis=1)
                    scores = self._scores(options, aims.centres[part, None], aims.weights[part, None])
                    if settings is not None and settings.budget is not None:
                        listed = np.broadcast_to(common, (len(part), *common.shape))
                        within = settings.affordable(others, np.concatenate([listed, more], axis=1))
                        scores = np.where(within, scores, np.inf)
                    if own and varied:
                        # What lies beyond the robot's limits would be best, and descents would have to lead back.
                        beyond = ~self._problem.reachable(more)
                        scores[:, count:] = np.where(beyond, np.inf, scores[:, count:])
                    best = scores.argmin(axis=1)
                    found = scores[np.arange(len(part)), best]
                    better = found < score[part] - _HELPS * (1.0 + np.abs(score[part]))
                    for row in np.flatnonzero(better):
                        index, chosen = part[row], best[row]
                        listed = chosen < count
                        designs[index, place] = common[chosen] if listed else more[row, chosen - count]
                        there[index, place] = shared[chosen] if listed else theirs[row, chosen - count]
                    score[part[better]], helped[part[better]] = found[better], True
            moving = np.flatnonzero(helped)
            if moving.size == 0:
                break
        return designs

    def moved(self, designs: FloatArray, aims: Aims, offered: FloatArray) -> FloatArray:
        """Designs (b, m, g) of which whole settings of the robot are at the poses of others (l, g) where that helps.

        Its measurements keep their loads. One exchanged alone would need a setting more.
        """
        settings, pose, sums = self._space.settings, self._space.of_pose, self._sums
        assert settings is not None
        found = designs.copy()
        for design, centre, weight in zip(found, aims.centres, aims.weights, strict=True):
            parts = sums.parts(design)
            score = float(self._scores(sums.sums(parts[None], design[None][..., pose]), centre, weight)[0])
            for first in np.flatnonzero(settings.units(design)):
                own = (design[:, pose] == design[first, pose]).all(axis=1)
                tried = np.where(own[:, None] & pose, offered[:, None], design)
                theirs = np.repeat(parts[None], len(offered), axis=0)
                theirs[:, own] = sums.parts(tried[:, own].reshape(-1, len(pose))).reshape(len(offered), own.sum(), -1)
                scores = self._scores(sums.sums(theirs, tried[..., pose]), centre, weight)
                best = int(scores.argmin())
                if scores[best] < score - _HELPS * (1.0 + abs(score)):
                    design[:], parts, score = tried[best], theirs[best], float(scores[best])
        return found

    def _own_options(self, designs: FloatArray, place: int, varied: bool, sweep: int | None) -> FloatArray:
        """Alternatives (b, v, g) to the measurement of designs (b, m, g) at a place: where wanted, its variants; where
        settings count, also at its pose set anew, at the poses of the other ones, in a numbered sweep with loads near
        those of some of them, or left out.
        """
        own, space = designs[:, place, None], self._space
        found = [variants(self._problem, own)[:, 0]] if varied else [space.anew(own)]
        if space.settings is not None:
            others, count = np.delete(designs, place, axis=1), designs.shape[1] - 1
            found += [np.where(space.of_pose, others, own), np.where(space.of_pose, space.anew(others), own)]
            if space.settings.budget is not None:
                out = own.copy()
                out[..., space.settings.gene] = 0.0
                found.append(out)
            if sweep is not None:
                # Of long plans other ones in every sweep: all would be as many alternatives as measurements squared.
                near = np.linspace(0, count, min(count, 8), endpoint=False, dtype=int)
                some = (place + sweep + near) % count
                more = variants(self._problem, others[:, np.sort(some)], ~space.of_pose)
                found.append(more.reshape(len(designs), -1, space.decisions))
        return np.concatenate(found, axis=1)

    def repeated(
        self, drawn: FloatArray, aims: Aims, count: int, paired: int
    ) -> tuple[FloatArray, IntArray, FloatArray]:
        """The best plans (d, m, g) of one of some measurements, and of two for all numbers of repetitions of the first.

        Args:
            drawn: the measurements, shape (l, g).
            aims: b of them.
            count: plans of each kind for each aim.
            paired: how many measurements are paired with each other.

        Returns:
            The plans, for which aim (d,) each is, and how far from it (d,).
        """
        m, sums, pose = self._space.measurements, self._sums, self._space.of_pose
        parts, everyone = sums.parts(drawn), np.arange(len(drawn))

        def scored(options: FloatArray) -> FloatArray:
            return self._scores(options, aims.centres[:, None], aims.weights[:, None])

        def least(
            scores: FloatArray, first: IntArray, second: IntArray, times: int
        ) -> tuple[FloatArray, IntArray, FloatArray]:
            best = np.argsort(scores, axis=1, kind="stable")[:, :count]
            of = np.repeat(np.arange(len(best)), best.shape[1])
            plans = np.where(np.arange(m) < times, first[best.ravel(), None], second[best.ravel(), None])
            return drawn[plans], of, scores[of, best.ravel()]

        scores = scored(sums.repeated(parts, m))
        found = [least(scores, everyone, everyone, m)]
        # Those that are the least by themselves, and some of all.
        alone = np.unique(scores.argsort(axis=1, kind="stable")[:, : max(1, paired // (4 * len(scores)))])
        chosen = np.unique(np.concatenate([alone, np.arange(min(paired, len(drawn)))]))
        first, second = (chosen[index].ravel() for index in np.indices((len(chosen), len(chosen))))
        if self._problem.noise.shared_reference:
            # At one pose the two would share their reference, and be one series.
            apart = (drawn[first][:, pose] != drawn[second][:, pose]).any(axis=1)
            first, second = first[apart], second[apart]
        for times in range(1, m // 2 + 1):
            one, other = (sums.repeated(parts, number) for number in (times, m - times))
            found.append(least(scored(one[first] + other[second]), first, second, times))
        plans, of, values = (np.concatenate(part) for part in zip(*found, strict=True))
        return plans, of, values


def rounded(weights: FloatArray, count: int, draws: int, generator: np.random.Generator) -> IntArray:
    """Draws (draws, count) of candidates, each as often as its weight says give or take one (systematic sampling)."""
    support = np.flatnonzero(weights > 0.0)
    order = np.argsort(generator.random((draws, len(support))), axis=1)
    edges = np.cumsum(weights[support][order] / weights.sum(), axis=1)
    points = (np.arange(count) + generator.random((draws, 1))) / count
    places = (points[:, :, None] > edges[:, None, :]).sum(axis=2)
    chosen: IntArray = support[np.take_along_axis(order, np.minimum(places, len(support) - 1), axis=1)]
    return chosen


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
        elif high < 6:
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

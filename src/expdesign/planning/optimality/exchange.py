"""Exchange of measurements where criteria are sums over them: one, or a plan of repeated ones.

Fedorov 1972 exchanges one measurement after the other until none helps. What it does not find: load errors that each
measurement has of its own average out over repetitions of whichever measurement suffers least.

DUIR and FEIR are functions of sums over the measurements (`Sums`) or, where these share references, over their series:
a measurement then has rows of the unknown reading of its reference too, and a series is the sum over its measurements,
from which that reading is eliminated. So exchanging one measurement costs the same however many there are. Sums square
the condition of Ã, which the ranking of exchanges can bear; the value that is reported is computed without them.
"""

from math import prod

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.planning.criteria.information import Sums
from expdesign.planning.optimality.measurement_maps import MeasurementMaps
from expdesign.planning.problem import DesignProblem
from expdesign.planning.scalarisation import Aims, achieved
from expdesign.planning.space import DesignSpace

_TOGETHER = 10_000_000
"""Entries of the sums that are formed at a time, at most."""
_HELPS = 1e-9
"""Relative gain that counts as one."""
_SWEEPS = 8
"""Times that every measurement of a design is exchanged, at most."""

ADDITIVE = ("duir", "feir", "total")
"""Criteria that are functions of sums over measurements."""


def exchanges_are_sums(problem: DesignProblem, names: tuple[str, ...]) -> bool:
    """Whether criteria with these names depend on sums over measurements, of which each may be exchanged by itself."""
    return not set(names) - set(ADDITIVE)


class Exchange:
    """Exchanges of measurements, judged by sums.

    Sums are `Sums.packed`, shape (..., q, w); of single measurements, whose reference may be shared, they have the
    reading of that reference as further unknowns.

    Args:
        problem: the design problem.
        names: of the criteria k of the aims, all in `ADDITIVE`.
        factor: s, on the load errors, so that `total` is √(DUIR² + s²·FEIR²).
    """

    def __init__(self, problem: DesignProblem, names: tuple[str, ...], factor: float = 1.0) -> None:
        self._problem, self._space, self._names, self._factor = problem, problem.space, names, factor
        self._readings = len(problem.noise.axes) if problem.noise.shared_reference else 0
        self._weighs = problem.estimator == "generalised"
        self._maps = MeasurementMaps(problem, factor if self._weighs else 0.0)
        self._estimated, self._targets = int(self._maps.common.sum()), self._maps.relaxation().targets
        known = problem.known
        self._known = None if known is None else Sums.of_information(known.in_units(problem.loaded.scale)).packed

    def told(self, measurements: FloatArray) -> FloatArray:
        """Sums of single measurements (..., g), 0 of those that are not taken."""
        observation, errors = self._maps.whitened(*self._space.decode(measurements))
        rows, own = self._maps.weighed(observation, errors, reference=self._readings > 0)
        common = own[..., :0]
        if not self._weighs:
            errors = self._maps.sharpness * self._factor * errors
            shared = self._problem.shared_errors
            own, common = errors[..., ~shared], errors[..., shared]
        return Sums.of_measurements(rows, own, common).packed * self._space.taken(measurements)[..., None, None]

    def sums(self, told: FloatArray, designs: FloatArray) -> FloatArray:
        """Sums (b, q, w) over the measurements of designs (b, m, g), of which each has told (b, m, q', w')."""
        return told.sum(axis=1) if not self._readings else self._series(told, designs)[1].sum(axis=1)

    def with_one(self, told: FloatArray, designs: FloatArray, options: FloatArray, new: FloatArray) -> FloatArray:
        """Sums (b, l, q, w) of designs (b, n, g) with one measurement more, for l of them.

        Args:
            told: sums of the measurements that they have, shape (b, n, q', w').
            designs: what they have.
            options: what comes to it, shape (b, l, g) or (1, l, g).
            new: sums of that, shape (b, l, q', w') or (1, l, q', w').
        """
        if not self._readings:
            return told.sum(axis=1)[:, None] + new
        together, series = self._series(told, designs)
        found = series.sum(axis=1)[:, None] + self._closed(new)
        # Where another measurement is at the pose, both are one series.
        pose = self._space.of_pose
        meets = (designs[:, :, None, pose] == options[:, None][..., pose]).all(axis=3)
        design, option = np.nonzero(meets.any(axis=1))
        if len(design):
            with_it = meets.argmax(axis=1)[design, option]
            source = design if len(new) == len(told) else np.zeros_like(design)
            others = _mixed(1.0 - np.eye(told.shape[1]), series)
            longer = together[design, with_it] + new[source, option]
            found[design, option] = others[design, with_it] + self._closed(longer)
        return found

    def _series(self, told: FloatArray, designs: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Sums of single measurements (b, m, q', w') over the series of each, and what it adds to those of the design,
        (b, m, q, w), which is zero but for its first measurement.
        """
        poses = designs[..., self._space.of_pose]
        same = (poses[:, :, None] == poses[:, None]).all(axis=3)
        first = ~np.tril(same, -1).any(axis=2)
        together = _mixed(same.astype(float), told)
        return together, np.where(first[..., None, None], self._closed(together), 0.0)

    def _closed(self, told: FloatArray) -> FloatArray:
        """What complete series add, from sums over their measurements (..., q', w'), shape (..., q, w)."""
        return Sums(told).eliminated(self._readings, 2.0).packed if self._readings else told

    def distances(self, sums: FloatArray, aims: Aims) -> FloatArray:
        """How far designs are from their aims, (b, ...), by their sums (b, ..., q, w)."""
        shape = (len(aims), *(1,) * (sums.ndim - 3), -1)
        with np.errstate(all="ignore"):
            whole = Sums(sums if self._known is None else sums + self._known, self._estimated)
            found = whole.variances(self._targets, self._problem.estimator)
            noise, force = (part.sum(axis=-1) for part in found)
            both = {"duir": noise, "feir": force, "total": noise + force}
            values = np.stack([np.sqrt(both[name].max(axis=-1)) for name in self._names], axis=-1)
            score = achieved(values, aims.centres.reshape(shape), aims.weights.reshape(shape))
        usable: FloatArray = np.where(np.isfinite(score), score, 1e30)
        return usable

    def scores(self, designs: FloatArray, aims: Aims) -> FloatArray:
        """How far designs (b, m, g) are from their aims, shape (b,)."""
        return self.distances(self.sums(self.told(designs), designs), aims)

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
        found, listed, told = designs.copy(), self.told(common), self.told(designs)
        together = max(1, _TOGETHER // listed.size)
        if len(designs) > together:
            parts = [slice(start, start + together) for start in range(0, len(designs), together)]
            one = [self.singles(designs[p], aims[p], common, varied=varied, loaded=loaded) for p in parts]
            return np.concatenate(one)
        score, m = self.distances(self.sums(told, found), aims), found.shape[1]
        vain = np.zeros(len(found), dtype=np.int64)  # places running at which no exchange helped
        for sweep, place in np.ndindex(_SWEEPS, m):
            moving = np.flatnonzero(vain < m)
            if moving.size == 0:
                break
            self._problem.interrupt()
            own = self._own_options(found[moving], place, varied, sweep if loaded else None)
            some = found[moving], told[moving], place, aims[moving]
            chosen, its, reached = self._best(*some, common, listed, own)
            better = reached < score[moving] - _HELPS * (1.0 + np.abs(score[moving]))
            changed = moving[better]
            found[changed, place], told[changed, place] = chosen[better], its[better]
            score[changed], vain[moving] = reached[better], np.where(better, 0, vain[moving] + 1)
        return found

    def _best(
        self,
        designs: FloatArray,
        told: FloatArray,
        place: int,
        aims: Aims,
        common: FloatArray,
        listed: FloatArray,
        own: FloatArray,
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """The best alternatives (b, g) to the measurements of designs (b, m, g) at a place, out of those for all (l, g)
        and of their own (b, v, g), their sums, and how far the designs with them are from their aims, (b,).
        """
        # Sums of what remains, not differences, which would lose digits.
        rest, others = np.delete(told, place, axis=1), np.delete(designs, place, axis=1)
        sums = self.with_one(rest, others, common[None], listed[None])
        if own.shape[1]:
            theirs = self.told(own)
            sums = np.concatenate([sums, self.with_one(rest, others, own, theirs)], axis=1)
        options = np.concatenate([np.broadcast_to(common, (len(designs), *common.shape)), own], axis=1)
        scores, settings, every = self.distances(sums, aims), self._space.settings, np.arange(len(designs))
        if settings is not None and settings.budget is not None:
            scores = np.where(settings.affordable(others, options), scores, np.inf)
        best = scores.argmin(axis=1)
        its, of_own = listed[np.minimum(best, len(common) - 1)], best >= len(common)
        if of_own.any():
            its[of_own] = theirs[of_own, best[of_own] - len(common)]
        return options[every, best], its, scores[every, best]

    def _own_options(self, designs: FloatArray, place: int, varied: bool, sweep: int | None) -> FloatArray:
        """Alternatives (b, v, g) to the measurement of designs (b, m, g) at a place: where wanted, with one variable
        changed; where settings count, in another one, in a numbered sweep with loads near those of some others there.
        """
        own, space, count = designs[:, place, None], self._space, designs.shape[1] - 1
        found = [changed(space, own)[:, 0] if varied else own[:, :0]]
        if space.settings is not None:
            found.append(regrouped(space, designs)[:, place])
            if sweep is not None:
                # Of long plans other ones in every sweep: all would be as many alternatives as measurements squared.
                near = np.linspace(0, count, min(count, 8), endpoint=False, dtype=int)
                some = np.sort((place + sweep + near) % count)
                more = changed(space, np.delete(designs, place, axis=1)[:, some], ~space.of_pose)
                found.append(more.reshape(len(designs), -1, space.decisions))
        options = np.concatenate(found, axis=1)
        # What lies beyond the robot's limits would be best, and descents would have to lead back.
        return np.where(self._problem.reachable(options)[..., None], options, own) if varied else options

    def moved(self, designs: FloatArray, aims: Aims, offered: FloatArray) -> FloatArray:
        """Designs (b, m, g) of which whole settings of the robot are at the poses of others (l, g) where that helps.

        Its measurements keep their loads. One exchanged alone would need a setting more.
        """
        settings, pose = self._space.settings, self._space.of_pose
        assert settings is not None
        found = designs.copy()
        for index, design in enumerate(found):
            aim, told = aims[index : index + 1], self.told(design)
            score = float(self.distances(self.sums(told[None], design[None]), aim)[0])
            for first in np.flatnonzero(settings.units(design)):
                own = (design[:, pose] == design[first, pose]).all(axis=1)
                tried = np.where(own[:, None] & pose, offered[:, None], design)
                theirs = np.repeat(told[None], len(offered), axis=0)
                theirs[:, own] = self.told(tried[:, own])
                scores = self.distances(self.sums(theirs, tried)[None], aim)[0]
                best = int(scores.argmin())
                if scores[best] < score - _HELPS * (1.0 + abs(score)):
                    design[:], told, score = tried[best], theirs[best], float(scores[best])
        return found

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
        m, told, everyone = self._space.measurements, self.told(drawn), np.arange(len(drawn))

        def least(
            scores: FloatArray, first: IntArray, second: IntArray, times: int
        ) -> tuple[FloatArray, IntArray, FloatArray]:
            best = np.argsort(scores, axis=1, kind="stable")[:, :count]
            of = np.repeat(np.arange(len(best)), best.shape[1])
            plans = np.where(np.arange(m) < times, first[best.ravel(), None], second[best.ravel(), None])
            return drawn[plans], of, scores[of, best.ravel()]

        scores = self.distances(self._closed(m * told)[None], aims)
        found = [least(scores, everyone, everyone, m)]
        # Those that are the least by themselves, and some of all.
        alone = np.unique(scores.argsort(axis=1, kind="stable")[:, : max(1, paired // (4 * len(scores)))])
        chosen = np.unique(np.concatenate([alone, np.arange(min(paired, len(drawn)))]))
        first, second = (chosen[index].ravel() for index in np.indices((len(chosen), len(chosen))))
        if self._problem.noise.shared_reference:
            # At one pose the two would share their reference, and be one series.
            pose = self._space.of_pose
            apart = (drawn[first][:, pose] != drawn[second][:, pose]).any(axis=1)
            first, second = first[apart], second[apart]
        for times in range(1, m // 2 + 1):
            one, other = (self._closed(number * told) for number in (times, m - times))
            found.append(least(self.distances((one[first] + other[second])[None], aims), first, second, times))
        plans, of, values = (np.concatenate(part) for part in zip(*found, strict=True))
        return plans, of, values


def _mixed(weights: FloatArray, sums: FloatArray) -> FloatArray:
    """Weighted sums (b, m, ...) of those of measurements (b, m, ...), with weights (b, m, m) or (m, m)."""
    found: FloatArray = (weights @ sums.reshape(*sums.shape[:2], prod(sums.shape[2:]))).reshape(sums.shape)
    return found


def rounded(weights: FloatArray, count: int, draws: int, generator: np.random.Generator) -> IntArray:
    """Draws (draws, count) of candidates, each as often as its weight says give or take one (systematic sampling)."""
    support = np.flatnonzero(weights > 0.0)
    order = np.argsort(generator.random((draws, len(support))), axis=1)
    edges = np.cumsum(weights[support][order] / weights.sum(), axis=1)
    points = (np.arange(count) + generator.random((draws, 1))) / count
    places = (points[:, :, None] > edges[:, None, :]).sum(axis=2)
    chosen: IntArray = support[np.take_along_axis(order, np.minimum(places, len(support) - 1), axis=1)]
    return chosen


def variants(space: DesignSpace, designs: FloatArray) -> FloatArray:
    """The measurements of designs (b, m, g), each with one variable changed or in another setting, (b, m, v, g)."""
    found = changed(space, designs)
    return found if space.settings is None else np.concatenate([found, regrouped(space, designs)], axis=2)


def changed(space: DesignSpace, measurements: FloatArray, wanted: BoolArray | None = None) -> FloatArray:
    """Measurements (b, m, g), each with one variable changed, all or those wanted (g,), shape (b, m, v, g)."""
    found, chosen = [], np.ones(space.decisions, dtype=bool) if wanted is None else wanted.copy()
    if space.settings is not None:
        chosen[space.settings.gene] = False
    for decision in np.flatnonzero(chosen):
        low, high, here = space.lower[decision], space.upper[decision], measurements[..., decision]
        if not space.discrete[decision]:
            values = [low, 0.5 * (low + high), high]
        elif high < 6:
            values = list(np.arange(high + 1.0))
        else:
            values = [np.clip(here - 1.0, low, high), np.clip(here + 1.0, low, high), low, high]
        for value in values:
            found.append(measurements.copy())
            found[-1][..., decision] = value
    return np.stack(found, axis=2) if found else measurements[:, :, None]


def regrouped(space: DesignSpace, designs: FloatArray) -> FloatArray:
    """The measurements of designs (b, m, g) in other settings, shape (b, m, v, g): each with its pose set anew, at the
    pose of another one, and set anew there, or left out.
    """
    settings, others = space.settings, [np.roll(designs, k, axis=1) for k in range(1, designs.shape[1])]
    assert settings is not None
    found = [space.anew(designs), *(np.where(space.of_pose, other, designs) for other in others)]
    if settings.shared:
        found += [np.where(space.of_pose, space.anew(other), designs) for other in others]
    if settings.budget is not None:
        found.append(designs.copy())
        found[-1][..., settings.gene] = 0.0
    return np.stack(found, axis=2)

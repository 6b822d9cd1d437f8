"""Candidates of a bound that are series: measurements at one pose with one reference reading (theory.md 10.6)."""

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.chain.instrument.deflection_noise import series_by_pose
from expdesign.mechanics.differentiation import gradient, independent, plain, sum_of_squares
from expdesign.planning.optimality.differentiated import to_variables
from expdesign.planning.optimality.information import MeasurementInformation
from expdesign.planning.optimality.measurement_pool import Effort, Found, ascent_words, enumerated, promising, usable
from expdesign.planning.optimality.series import Multisets, SeriesInformation
from expdesign.planning.optimality.sqp import MinimaxSearch
from expdesign.planning.optimality.weights import Dual

_ADDED, _LEAST_POSES = 40, 200


def takes_series(information: MeasurementInformation) -> bool:
    """Whether a problem's measurements share references in a way that candidates may be series.

    A measurement is then a pose and a load, and what a series tells is convex in each load.
    """
    problem = information.problem
    space = problem.space
    index = information.load_variables().index
    return (
        problem.noise.shared_reference
        and information.convex_in_load
        and bool((space.of_pose | np.isin(np.arange(space.decisions), index)).all())
    )


class SeriesPool:
    """Series as candidates, variables (j, n, g) with NaN for missing measurements.

    Args:
        information: maps of single measurements.
        samples: number of random measurements among the first candidates over a continuum.

    Attributes:
        information: maps of series.
        multisets: the series at a pose, by the extreme loads of their measurements.
    """

    complete = False

    def __init__(self, information: MeasurementInformation, samples: int) -> None:
        self._problem, self._samples = information.problem, samples
        self.information = SeriesInformation(information)
        self._generator = np.random.default_rng(information.problem.optimiser.seed)
        self._loads = information.load_variables()
        self._poses = enumerated(self._problem, self._loads.index)
        self._maps: FloatArray | None = None
        poses = samples if self._poses is None else len(self._poses)
        self.multisets = Multisets(len(self._loads.vertices), self._problem.space.measurements, poses)

    def caveat(self) -> str:
        return ""

    def rows(self, candidates: FloatArray) -> FloatArray:
        return self.information.rows(candidates)

    def measurements(self, candidates: FloatArray, weights: FloatArray) -> tuple[FloatArray, FloatArray]:
        there = ~np.isnan(candidates[..., 0])
        shares = np.broadcast_to((weights / there.sum(axis=1))[:, None], there.shape)
        return candidates[there], shares[there]

    def first(self, front: FloatArray | None) -> FloatArray:
        """Random series, of one to m measurements, and those of the front."""
        poses = self._poses if self._poses is not None else self._sampled()
        if len(poses) == 0:
            return np.zeros((0, self.multisets.longest, self._problem.space.decisions))
        taken = poses[np.linspace(0, len(poses) - 1, min(len(poses), _LEAST_POSES)).round().astype(int)]
        parts = []
        for members in self.multisets.members:
            drawn = members[self._generator.integers(len(members), size=2 * len(taken))]
            parts.append(self._series(np.concatenate([taken, taken]), drawn))
        if front is not None:
            parts.append(self._of_designs(front))
        return np.concatenate(parts)

    def distinct(self, candidates: FloatArray) -> FloatArray:
        space = self._problem.space
        span = np.where(space.upper > space.lower, space.upper - space.lower, 1.0)
        scaled = np.round((candidates - space.lower) / span, 6)
        flat = np.nan_to_num(scaled, nan=-1.0).reshape(len(candidates), -1)
        _, first = np.unique(flat, axis=0, return_index=True)
        return candidates[np.sort(first)]

    def largest(self, dual: Dual, candidates: FloatArray, rows: FloatArray, effort: Effort) -> Found:
        if self._poses is not None:
            return self._over_all(dual)
        known = dual.sensitivities(rows)
        order = np.argsort(-known, kind="stable")
        starts = candidates[promising(order, effort.starts, self._generator)]
        return self._ascend(dual, starts, float(known[order[0]]), effort)

    def _over_all(self, dual: Dual) -> Found:
        """The best series at every pose of a finite set."""
        assert self._poses is not None
        if self._maps is None:
            self._maps = self.information.reference_rows(self._options(self._poses))
        best = self.multisets.best(dual, self._maps)
        order = np.argsort(-best.values, kind="stable")[:_ADDED]
        words = (
            f"the sensitivity of a series (measurements at one pose with one reference) was evaluated at all "
            f"{len(self._poses)} poses for all series of up to {self.multisets.longest} measurements"
        )
        if self._loads.index.size:
            words += " with extreme loads, where it is largest because it is convex in every load"
        if self.multisets.longest < self._problem.space.measurements:
            words += ", and bounded for longer ones"
        series = self._series(self._poses[order], best.chosen[order])
        return Found(series, float(best.bound.max()), words)

    def _ascend(self, dual: Dual, starts: FloatArray, known: float, effort: Effort) -> Found:
        size = max(known, 1e-300)
        series = self._at_best_loads(dual, starts[:, 0])[0]

        def pieces(variables: FloatArray, index: IntArray) -> tuple[FloatArray, FloatArray]:
            values, slopes = self.sensitivity(dual, self._moved(series[index], variables[:, 0]))
            return -values[:, None] / size, -slopes[:, None, None, :] / size

        search = MinimaxSearch(self._problem, pieces)
        for _ in range(effort.passes):
            ends = search.minimise(series[:, :1].copy(), iterations=effort.steps, tolerance=1e-8, inner=1e-4)[:, 0]
            before = series[..., self._loads.index]
            series, bound = self._at_best_loads(dual, ends)
            if np.array_equal(before, series[..., self._loads.index], equal_nan=True):
                break
        keep = self._problem.loaded.robot.usable(self._problem.space.decode(series[:, 0])[0])
        if not keep.any():
            return Found(starts, known, "no ascent of a series' sensitivity ended within the robot's limits")
        series, bound = series[keep], bound[keep]
        values = dual.sensitivities(self.rows(series))
        order = np.argsort(-values, kind="stable")
        words = f"series share a reference; {ascent_words(values, float(values.max()))}"
        return Found(series[order], max(known, float(bound.max())), words)

    def sensitivity(self, dual: Dual, series: FloatArray) -> tuple[FloatArray, FloatArray]:
        """tr(QᵀN_sQ)/n (b,) of series (b, n, g), and its gradient with respect to the pose's variables (b, g)."""
        q, there = dual.matrix.shape[0], ~np.isnan(series[..., 0])
        quantities = self._problem.space.quantities(np.where(there[..., None], series, series[:, :1]))
        flat = independent(quantities.reshape(-1, quantities.shape[-1]))
        with np.errstate(all="ignore"):
            rows = self.information.information.reference_rows(flat)
            numbers = plain(rows).reshape(*there.shape, *rows.shape[1:]) * there[..., None, None]
            # The reference that tells least: at its best value the derivative needs no change of it.
            turned = np.einsum("bnki,bnkr->bir", numbers[..., q:], numbers[..., :q] @ dual.matrix)
            gram = np.einsum("bnki,bnkj->bij", numbers[..., q:], numbers[..., q:])
            reference = np.linalg.solve(2.0 * np.eye(gram.shape[-1]) + gram, turned)
            spread = np.repeat(reference[:, None], there.shape[1], axis=1).reshape(-1, *reference.shape[1:])
            found = sum_of_squares(rows[..., :q] @ dual.matrix - rows[..., q:] @ spread, (1, 2))
        share = (there / there.sum(axis=1, keepdims=True)).reshape(-1)
        values = (plain(found) * share).reshape(there.shape).sum(axis=1)
        values = values + 2.0 * (reference**2).sum(axis=(1, 2)) / there.sum(axis=1)
        by_quantities = gradient(found, share, flat).reshape(*there.shape, -1)
        slopes = to_variables(self._problem, by_quantities.sum(axis=1))
        return values, np.where(self._problem.space.of_pose, slopes, 0.0)

    def _sampled(self) -> FloatArray:
        count = max(_LEAST_POSES, self._samples // len(self._loads.vertices))
        return usable(self._problem, self._problem.space.sample(count, self._generator))

    def _options(self, poses: FloatArray) -> FloatArray:
        """The measurements with extreme loads at poses (p, g), shape (p, v, g)."""
        options = np.repeat(poses[:, None], len(self._loads.vertices), axis=1)
        options[..., self._loads.index] = self._loads.vertices
        return options

    def _series(self, poses: FloatArray, members: IntArray) -> FloatArray:
        """Series (p, n, g) at poses (p, g) of vertices of the loads (p, n'), −1 for missing ones."""
        series = np.full((len(poses), self.multisets.longest, poses.shape[1]), np.nan)
        part = np.repeat(poses[:, None], members.shape[1], axis=1)
        part[..., self._loads.index] = self._loads.vertices[members]
        part[members < 0] = np.nan
        series[:, : members.shape[1]] = part
        return series

    def _moved(self, series: FloatArray, poses: FloatArray) -> FloatArray:
        """Series (b, n, g) taken to the poses of measurements (b, g)."""
        there = ~np.isnan(series[..., :1])
        return np.where(self._problem.space.of_pose & there, poses[:, None], series)

    def _at_best_loads(self, dual: Dual, poses: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The most sensitive series at poses (b, g), and what no series there exceeds, shape (b,)."""
        best = self.multisets.best(dual, self.information.reference_rows(self._options(poses)))
        return self._series(poses, best.chosen), best.bound

    def _of_designs(self, designs: FloatArray) -> FloatArray:
        """The series of designs (d, m, g) that are short enough to be candidates."""
        numbers = series_by_pose(self._problem.space.decode(designs)[0])
        found = []
        for design, series in zip(designs, numbers, strict=True):
            for number in range(1, int(series.max()) + 1):
                members = design[series == number]
                if len(members) <= self.multisets.longest:
                    padded = np.full((self.multisets.longest, design.shape[-1]), np.nan)
                    padded[: len(members)] = members
                    found.append(padded)
        return self.distinct(np.array(found)) if found else np.zeros((0, self.multisets.longest, designs.shape[-1]))

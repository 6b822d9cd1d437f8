"""DUIR and FEIR of very many plans by sums over their measurements or, where these share references, their series.

The sums (`Sums`) of each measurement are a flat vector, so that exchanging one measurement costs the same however many
there are. Where measurements share references, a measurement has rows of the unknown reading of its reference too, and
a series is the sum over its measurements, from which that reading is eliminated. Sums square the condition of Ã, which
the ranking of exchanges can bear; the value that is reported is computed without them.
"""

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.planning.criteria.information import Sums
from expdesign.planning.optimality.measurement_maps import MeasurementMaps
from expdesign.planning.problem import DesignProblem


class PlanSums:
    """The sums over measurements on which DUIR and FEIR depend.

    Args:
        problem: the design problem.
        factor: s, of the load errors.
    """

    def __init__(self, problem: DesignProblem, factor: float) -> None:
        self._problem, self._factor = problem, factor
        self._readings = len(problem.noise.axes) if problem.noise.shared_reference else 0
        self._maps = MeasurementMaps(problem, factor if problem.estimator == "generalised" else 0.0)
        self._targets = self._maps.relaxation().targets
        self._estimated = int(self._maps.common.sum())
        seen = 0 if problem.estimator == "generalised" else int(problem.shared_errors.sum())
        self._sizes = self._targets.shape[-1], seen
        known = problem.known
        self._known = None if known is None else self._flat(Sums.of_information(known.in_units(problem.loaded.scale)))

    def parts(self, variables: FloatArray) -> FloatArray:
        """Sums of single measurements with variables (j, g), with the reading of their reference, shape (j, c')."""
        problem = self._problem
        if problem.estimator == "generalised":
            rows, errors = self._maps.weighed(variables, reference=self._readings > 0)
            found = Sums.of_measurements(rows, errors, np.zeros(errors.shape[-1], dtype=bool))
            return self._flat(found) * problem.space.taken(variables)[:, None]
        observation, errors = problem.whitened(*problem.space.decode(variables))
        rows = observation * problem.loaded.scale
        if self._readings:
            # A reading of the reference has half the variance of a deflection.
            one = np.broadcast_to(np.eye(self._readings), (*rows.shape[:2], self._readings))
            rows = np.sqrt(2.0) * np.concatenate([rows, one], axis=2)
            errors = np.sqrt(2.0) * errors
        found = Sums.of_measurements(rows, self._factor * errors, problem.shared_errors)
        return self._flat(found) * problem.space.taken(variables)[:, None]

    def sums(self, parts: FloatArray, poses: FloatArray) -> FloatArray:
        """Sums (b, c) over the measurements of designs, whose parts are (b, m, c') and poses (b, m, n)."""
        return parts.sum(axis=1) if not self._readings else self._series(parts, poses)[1].sum(axis=1)

    def repeated(self, parts: FloatArray, times: int) -> FloatArray:
        """Sums (..., c) over a measurement with parts (..., c') that is repeated so many times."""
        return self._closed(times * parts)

    def joined(self, there: FloatArray, at: FloatArray, new: FloatArray, poses: FloatArray) -> FloatArray:
        """Sums (b, l, c) of designs with one measurement more, for l alternatives.

        Args:
            there: parts of the other measurements, shape (b, m − 1, c').
            at: their poses, shape (b, m − 1, n).
            new: parts of the alternatives, shape (b, l, c') or (1, l, c').
            poses: of the alternatives, shape (b, l, n) or (1, l, n).
        """
        if not self._readings:
            return there.sum(axis=1)[:, None] + new
        together, series = self._series(there, at)
        found = series.sum(axis=1)[:, None] + self._closed(new)
        # Where another measurement is at the pose, both are one series.
        meets = (at[:, :, None] == poses[:, None]).all(axis=3)
        design, option = np.nonzero(meets.any(axis=1))
        if len(design):
            with_it = meets.argmax(axis=1)[design, option]
            source = design if len(new) == len(there) else np.zeros_like(design)
            others = (1.0 - np.eye(at.shape[1])) @ series
            longer = together[design, with_it] + new[source, option]
            found[design, option] = others[design, with_it] + self._closed(longer)
        return found

    def with_more(self, parts: FloatArray, more: FloatArray, poses: FloatArray) -> FloatArray:
        """Sums (b, m, c) of designs with parts (b, m, c') at poses (b, m, n) of which one after the other has more."""
        if not self._readings:
            return parts.sum(axis=1)[:, None] + more
        together, series = self._series(parts, poses)
        return series.sum(axis=1)[:, None] + self._closed(together + more) - self._closed(together)

    def total(self, sums: FloatArray) -> FloatArray:
        """`total`² (...) of flat sums (..., c)."""
        found: FloatArray = np.add(*self.variances(sums)).max(axis=-1)
        return found

    def variances(self, sums: FloatArray) -> tuple[FloatArray, FloatArray]:
        """DUIR² and s²·FEIR² of every alternative of the maximum over targets, (..., t), of flat sums (..., c)."""
        noise, force = self.whole(sums).variances(self._targets, self._problem.estimator)
        return noise.sum(axis=-1), force.sum(axis=-1)

    def whole(self, sums: FloatArray) -> Sums:
        """The same of a whole plan, with what is known before it."""
        found = self._unfolded(sums if self._known is None else sums + self._known, self._sizes[0])
        return found.with_prior(self._estimated) if self._estimated else found

    def _series(self, parts: FloatArray, poses: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Sums of the parts (b, m, c') over the series of each measurement, and what it adds, (b, m, c), which is zero
        but for its first measurement.
        """
        same = (poses[:, :, None] == poses[:, None]).all(axis=3)
        first = ~np.tril(same, -1).any(axis=2)
        together = same.astype(float) @ parts
        return together, np.where(first[..., None], self._closed(together), 0.0)

    def _closed(self, parts: FloatArray) -> FloatArray:
        """What complete series add, from sums over their measurements (..., c'), shape (..., c)."""
        if not self._readings:
            return parts
        found = self._unfolded(parts, self._sizes[0] + self._readings)
        return self._flat(found.eliminated(self._readings, 2.0))

    def _unfolded(self, flat: FloatArray, size: int) -> Sums:
        edges = [size * size, 2 * size * size]
        shapes = [(size, size), (size, size), (size, self._sizes[1])]
        pieces = np.split(flat, edges, axis=-1)
        return Sums(*(each.reshape(*flat.shape[:-1], *shape) for each, shape in zip(pieces, shapes, strict=True)))

    @staticmethod
    def _flat(sums: Sums) -> FloatArray:
        parts = (sums.matrix, sums.own, sums.shared)
        return np.concatenate([each.reshape(*each.shape[:-2], -1) for each in parts], axis=-1)

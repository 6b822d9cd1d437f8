"""What DUIR and FEIR of a plan depend on: sums over its measurements or, where these share references, its series.

What they are is in `planning/criteria/information.py`; here they are flat vectors of many plans, so that exchanging one
measurement costs the same however many there are. The sums square the condition of Ã, which the ranking of exchanges
can bear; the value that is reported is computed without them.

The n rows of a series that share their reference have the covariance V⊗½(I + 11ᵀ), with the inverse
2·V⁻¹⊗(I − 11ᵀ/(n + 1)). With whitened maps a_i of the compliances, d_i of the load errors, and ā = Σa_i/(n + 1), the
series adds

    M = 2(Σ a_iᵀa_i − āᵀΣa_i) , S = 2(Σ a_iᵀd_i − āᵀΣd_i) , N = 4 Σ (a_i − ā)ᵀd_id_iᵀ(a_i − ā) ,

functions of sums over its rows alone, which for a single row are those of a measurement with a reference of its own.
"""

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.planning.criteria.information import propagated
from expdesign.planning.optimality.information import MeasurementInformation
from expdesign.planning.problem import DesignProblem


class Additive:
    """The sums over measurements on which DUIR and FEIR depend.

    Args:
        problem: the design problem; measurements are taken not to share their reference.
        factor: s, of the load errors.
    """

    def __init__(self, problem: DesignProblem, factor: float) -> None:
        self._problem, self._factor = problem, factor
        self._targets = MeasurementInformation(problem, 0.0).relaxation().targets
        size = self._targets.shape[-1]
        shapes = [(size, size), (size, size), (size, int(problem.shared_errors.sum()))]
        self._shapes = shapes

    def parts(self, variables: FloatArray) -> FloatArray:
        """What measurements with variables (j, g) add to the sums, shape (j, c)."""
        problem, factor = self._problem, self._factor
        observation, errors = problem.whitened(*problem.space.decode(variables))
        rows, shared = observation * problem.loaded.scale, problem.shared_errors
        transposed = rows.swapaxes(1, 2)
        common, own = factor * errors[..., shared], factor * errors[..., ~shared]
        reach = transposed @ own
        parts = [transposed @ rows, reach @ reach.swapaxes(1, 2), transposed @ common]
        return self._of_taken(variables, parts)

    def _of_taken(self, variables: FloatArray, parts: list[FloatArray]) -> FloatArray:
        together = np.concatenate([part.reshape(len(variables), -1) for part in parts], axis=1)
        return together * self._problem.space.taken(variables)[:, None]

    def sums(self, parts: FloatArray, poses: FloatArray) -> FloatArray:
        """Sums (b, c) over the measurements of designs, whose parts are (b, m, c) and poses (b, m, n)."""
        return parts.sum(axis=1)

    def repeated(self, parts: FloatArray, times: int) -> FloatArray:
        """Sums (..., c) over a measurement with parts (..., c') that is repeated so many times."""
        return times * parts

    def joined(self, there: FloatArray, at: FloatArray, new: FloatArray, poses: FloatArray) -> FloatArray:
        """Sums (b, l, c) of designs with one measurement more, for l alternatives.

        Args:
            there: parts of the other measurements, shape (b, m − 1, c').
            at: their poses, shape (b, m − 1, n).
            new: parts of the alternatives, shape (b, l, c') or (1, l, c').
            poses: of the alternatives, shape (b, l, n) or (1, l, n).
        """
        return there.sum(axis=1)[:, None] + new

    def terms(self, sums: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """M, N and S, each (..., n, ·), of sums (..., c)."""
        sizes = np.cumsum([int(np.prod(shape)) for shape in self._shapes])[:-1]
        matrix, own, common = (
            part.reshape(*sums.shape[:-1], *shape)
            for part, shape in zip(np.split(sums, sizes, axis=-1), self._shapes, strict=True)
        )
        return matrix, own, common

    def inverse(self, matrix: FloatArray) -> FloatArray:
        """M⁻¹ of informations M (..., p, p)."""
        # A ridge far below rounding of a regular matrix keeps a singular one from stopping the batch.
        size = np.trace(matrix, axis1=-2, axis2=-1)[..., None, None]
        found: FloatArray = np.linalg.inv(matrix + 1e-14 * np.maximum(size, 1e-300) * np.eye(matrix.shape[-1]))
        return found

    def gains(self, matrix: FloatArray) -> FloatArray:
        """T·M⁻¹ of every alternative of the maximum over targets, (..., t, r, p), of informations M (..., p, p)."""
        found: FloatArray = self._targets @ self.inverse(matrix)[..., None, :, :]
        return found

    def variances(self, sums: FloatArray) -> tuple[FloatArray, FloatArray]:
        """DUIR² and s²·FEIR² of every alternative of the maximum over targets, (..., t), of sums (..., c)."""
        matrix, own, common = self.terms(sums)
        noise, force = propagated(self._targets, self.inverse(matrix), common, own)
        return noise.sum(axis=-1), force.sum(axis=-1)


class SeriesAdditive(Additive):
    """The same where measurements at a pose share their reference: parts hold what sums over a series are made of."""

    def parts(self, variables: FloatArray) -> FloatArray:
        """a·aᵀ, aᵀddᵀa, aᵀd of the shared errors, and a, d, ddᵀa, ddᵀ, of measurements (j, g), shape (j, c')."""
        problem, factor = self._problem, self._factor
        observation, errors = problem.whitened(*problem.space.decode(variables))
        rows, shared = observation * problem.loaded.scale, problem.shared_errors
        own, common = factor * errors[..., ~shared], factor * errors[..., shared]
        spread = own @ own.swapaxes(1, 2)
        along, transposed = spread @ rows, rows.swapaxes(1, 2)
        parts = [transposed @ rows, transposed @ along, transposed @ common, rows, common, along, spread]
        return self._of_taken(variables, parts)

    def sums(self, parts: FloatArray, poses: FloatArray) -> FloatArray:
        found: FloatArray = self._series(parts, poses)[2].sum(axis=1)
        return found

    def _series(self, parts: FloatArray, poses: FloatArray) -> tuple[FloatArray, IntArray, FloatArray]:
        """Sums of the parts (b, m, c') over the series of each measurement, its length (b, m), and what it adds, (b, m,
        c), which is zero but for its first measurement.
        """
        same = (poses[:, :, None] == poses[:, None]).all(axis=3)
        first = ~np.tril(same, -1).any(axis=2)
        together, count = same.astype(float) @ parts, same.sum(axis=2)
        return together, count, np.where(first[..., None], self._closed(together, count), 0.0)

    def joined(self, there: FloatArray, at: FloatArray, new: FloatArray, poses: FloatArray) -> FloatArray:
        together, count, series = self._series(there, at)
        found = series.sum(axis=1)[:, None] + self.repeated(new, 1)
        # Where another measurement is at the pose, both are one series.
        meets = (at[:, :, None] == poses[:, None]).all(axis=3)
        design, option = np.nonzero(meets.any(axis=1))
        if len(design):
            with_it = meets.argmax(axis=1)[design, option]
            source = design if len(new) == len(there) else np.zeros_like(design)
            others = (1.0 - np.eye(at.shape[1])) @ series
            longer = together[design, with_it] + new[source, option]
            found[design, option] = others[design, with_it] + self._closed(longer, count[design, with_it] + 1)
        return found

    def repeated(self, parts: FloatArray, times: int) -> FloatArray:
        return self._closed(times * parts, np.full(parts.shape[:-1], float(times)))

    def _closed(self, sums: FloatArray, count: FloatArray) -> FloatArray:
        """What series of `count` (...) rows add, from sums over their rows (..., c'), shape (..., c)."""
        (p, _), _, (_, s) = self._shapes
        k = len(self._problem.noise.axes)
        shapes = [*self._shapes, (k, p), (k, s), (k, p), (k, k)]
        edges = np.cumsum([a * b for a, b in shapes])[:-1]
        matrix, own, reach, rows, common, along, spread = (
            part.reshape(*sums.shape[:-1], *shape)
            for part, shape in zip(np.split(sums, edges, axis=-1), shapes, strict=True)
        )
        mean = (rows / (count[..., None, None] + 1.0)).swapaxes(-1, -2)
        cross = mean @ along
        own = own - cross - cross.swapaxes(-1, -2) + mean @ spread @ mean.swapaxes(-1, -2)
        parts = [2.0 * (matrix - mean @ rows), 4.0 * own, 2.0 * (reach - mean @ common)]
        return np.concatenate([part.reshape(*count.shape, -1) for part in parts], axis=-1)


def additive(problem: DesignProblem, factor: float) -> Additive:
    """The sums of a problem, as its measurements share references or not."""
    return SeriesAdditive(problem, factor) if problem.noise.shared_reference else Additive(problem, factor)

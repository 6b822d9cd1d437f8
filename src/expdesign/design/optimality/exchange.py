"""Exchange of measurements within a list of candidates (Fedorov 1972), and the rounding of weights that it starts from.

What a plan is worth depends on its measurements through sums alone: with M_j = A_jᵀV⁻¹A_j, S_j = A_jᵀV⁻¹D_jL_j of the
shared and N_j = A_jᵀV⁻¹D_jL_jL_jᵀD_jᵀV⁻¹A_j of the independent load errors,

    DUIR² + s²·FEIR² = tr(C·M⁻¹) + s²·tr(C·M⁻¹·(N + S·Sᵀ)·M⁻¹) ,

so that exchanging one measurement costs the same however many there are. The sums square the condition of Ã, which the
ranking of exchanges can bear; the value that is reported is computed without them.
"""

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.design.optimality.information import MeasurementInformation
from expdesign.design.problem import DesignProblem

_SWEEPS = 50


def rounded(weights: FloatArray, count: int, draws: int, generator: np.random.Generator) -> IntArray:
    """Draws (draws, count) of candidates, each as often as its weight says give or take one (systematic sampling)."""
    support = np.flatnonzero(weights > 0.0)
    order = np.argsort(generator.random((draws, len(support))), axis=1)
    edges = np.cumsum(weights[support][order] / weights.sum(), axis=1)
    points = (np.arange(count) + generator.random((draws, 1))) / count
    places = (points[:, :, None] > edges[:, None, :]).sum(axis=2)
    chosen: IntArray = support[np.take_along_axis(order, np.minimum(places, len(support) - 1), axis=1)]
    return chosen


class Exchange:
    """Exchange of measurements within a list of candidates.

    Args:
        problem: the design problem.
        variables: candidates, shape (j, g).
        factor: s, of the load errors.
    """

    def __init__(self, problem: DesignProblem, variables: FloatArray, factor: float) -> None:
        information = MeasurementInformation(problem, 0.0)
        observation, errors = problem.whitened(*problem.space.decode(variables))
        rows, shared = observation * problem.loaded.scale, problem.shared_errors
        transposed = rows.swapaxes(1, 2)
        common, own = factor * errors[..., shared], factor * errors[..., ~shared]
        reach = transposed @ own
        parts = [transposed @ rows, reach @ reach.swapaxes(1, 2), transposed @ common]
        self._shapes = [part.shape[1:] for part in parts]
        self._parts: FloatArray = np.concatenate([part.reshape(len(variables), -1) for part in parts], axis=1)
        self._targets = information.relaxation().targets

    def sums(self, plans: IntArray) -> FloatArray:
        """Sums (b, c) over the measurements of plans (b, m)."""
        return self._parts[plans].sum(axis=1)

    def values(self, sums: FloatArray) -> FloatArray:
        """DUIR² + s²·FEIR² (...,) of plans with the given sums (..., c); inf where they identify too little."""
        sizes = np.cumsum([int(np.prod(shape)) for shape in self._shapes])[:-1]
        matrix, own, common = (
            part.reshape(*sums.shape[:-1], *shape)
            for part, shape in zip(np.split(sums, sizes, axis=-1), self._shapes, strict=True)
        )
        # A ridge far below rounding of a regular matrix keeps a singular one from stopping the batch.
        size = np.trace(matrix, axis1=-2, axis2=-1)[..., None, None]
        inverse = np.linalg.inv(matrix + 1e-14 * np.maximum(size, 1e-300) * np.eye(matrix.shape[-1]))
        gain = self._targets @ inverse[..., None, :, :]
        noise = np.einsum("...trp,trp->...t", gain, self._targets)
        turned = (gain @ own[..., None, :, :]) * gain
        force = turned.sum(axis=(-2, -1)) + ((gain @ common[..., None, :, :]) ** 2).sum(axis=(-2, -1))
        largest = (noise + force).max(axis=-1)
        result: FloatArray = np.where((largest > 0.0) & np.isfinite(largest), largest, np.inf)
        return result

    def best(self, plans: IntArray, count: int) -> IntArray:
        """The best `count` of plans (b, m), without repetitions."""
        plans = np.unique(np.sort(plans, axis=1), axis=0)
        values = self.values(self.sums(plans))
        return plans[np.argsort(values, kind="stable")[:count]]

    def improve(self, plans: IntArray) -> IntArray:
        """Plans (b, m) after exchanges that help, one measurement at a time, until none does (Fedorov 1972)."""
        plans = plans.copy()
        for plan in plans:
            sums = self._parts[plan].sum(axis=0)
            value = float(self.values(sums))
            for _ in range(_SWEEPS):
                before = value
                for place in range(len(plan)):
                    without = self._parts[np.delete(plan, place)].sum(axis=0)
                    found = self.values(without + self._parts)
                    winner = int(np.argmin(found))
                    if found[winner] < value * (1.0 - 1e-10):
                        plan[place], value = winner, float(found[winner])
                if value >= before * (1.0 - 1e-9):
                    break
        return plans

"""What DUIR and FEIR of a plan depend on: sums over its measurements, where these share no reference.

With M_j = A_jᵀV⁻¹A_j, S_j = A_jᵀV⁻¹D_jL_j of the shared and N_j = A_jᵀV⁻¹D_jL_jL_jᵀD_jᵀV⁻¹A_j of the independent load
errors,

    DUIR² + s²·FEIR² = tr(C·M⁻¹) + s²·tr(C·M⁻¹·(N + S·Sᵀ)·M⁻¹) ,

so that exchanging one measurement costs the same however many there are. The sums square the condition of Ã, which the
ranking of exchanges can bear; the value that is reported is computed without them.
"""

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.design.optimality.information import MeasurementInformation
from expdesign.design.problem import DesignProblem


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
        return np.concatenate([part.reshape(len(variables), -1) for part in parts], axis=1)

    def variances(self, sums: FloatArray) -> tuple[FloatArray, FloatArray]:
        """DUIR² and s²·FEIR² of every alternative of the maximum over targets, (..., t), of sums (..., c)."""
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
        return noise, force

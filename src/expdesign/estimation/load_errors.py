"""Errors of the recorded loads that are known beforehand, in the test of fit (theory.md 5.6).

A scale that is off by 20 g, or a centre of mass by a millimetre, moves the readings. Where such errors are declared, a
misfit that they account for is no reason to doubt the model: the test of generalised least squares has them as
nuisance parameters δ of unit variance,

    χ² = min over θ, δ of |r − S·θ − G·δ|² + |δ|²,

with whitened residuals r of the fit, sensitivities S of its parameters and G of the load errors. With the covariance P
of the fit, χ² falls by (Gᵀr)ᵀ·(I + Gᵀ(I − S·P·Sᵀ)·G)⁻¹·(Gᵀr), and its degrees of freedom stay, δ having as many
readings as parameters. The estimate is that of theory.md 3 all the same; what load errors do to it is its budget's.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import block_diag

from expdesign.arrays import FloatArray, as_matrix
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.row import row_data
from expdesign.errors import InputError
from expdesign.estimation.fit import Fit
from expdesign.estimation.whitening import Whitening
from expdesign.mechanics.elastostatics.measurements import LoadedRobot


@dataclass(frozen=True)
class DeclaredLoadErrors:
    """The load errors of a configuration.

    Attributes:
        loaded: the robot under the load of the configuration, with its sources of load error, at least one.
        source: the configuration.
    """

    loaded: LoadedRobot
    source: str

    def readings(self, fit: Fit, recorded: Recordings) -> list[FloatArray]:
        """What one standard deviation of every component of each source does to the readings, row by row (N, k, d).

        Raises:
            InputError: the errors are of another kind of load than was recorded.
        """
        rotation = fit.chain.robot.jacobians(recorded.configurations).rotation
        sources = self.loaded.load_errors(rotation, self._loads(recorded))
        return [
            np.stack([_moved(fit, recorded, wrenches[..., d]) for d in range(wrenches.shape[-1])], axis=-1)
            for wrenches in sources
        ]

    def explained(self, fit: Fit, recorded: Recordings, whitening: Whitening) -> float:
        """By how much χ² falls where the recorded loads may have these errors.

        Args:
            fit: whose residuals are of these rows, and of no others.
            recorded: the rows that were fitted.
            whitening: of the same rows.
        """
        columns = [
            as_matrix(whitening.apply(moved)) if source.shared else _row_by_row(moved, whitening)
            for source, moved in zip(self.loaded.sources, self.readings(fit, recorded), strict=True)
        ]
        errors, sensitivities = np.hstack(columns), as_matrix(fit.sensitivities)
        seen = sensitivities.T @ errors
        curvature = errors.T @ errors - seen.T @ (fit.estimable.generalised / fit.inflation) @ seen
        gradient = errors.T @ fit.residuals.ravel()
        return float(gradient @ np.linalg.solve(np.eye(len(gradient)) + curvature, gradient))

    def _loads(self, recorded: Recordings) -> FloatArray:
        """Parameters of the recorded loads, of the kind that the errors are of, shape (N, p)."""
        if not self.loaded.load.has_mass:
            return recorded.wrenches
        if recorded.payload is None:
            what = "the load errors of the configuration are those of a payload, and the recordings have wrenches"
            remedy = "Record mass_kg and the centre of mass, or use a configuration with `kind: wrench`."
            raise InputError(what, where=recorded.source, remedy=remedy)
        return np.concatenate([recorded.payload, recorded.gravity], axis=1)


def _row_by_row(moved: FloatArray, whitening: Whitening) -> FloatArray:
    """Columns of errors that every row has for itself: N·d of N·k readings, from (N, k, d)."""
    count, readings, components = moved.shape
    apart = np.reshape(block_diag(*moved), (count, readings, count * components))
    return as_matrix(whitening.apply(apart))


def _moved(fit: Fit, recorded: Recordings, change: FloatArray) -> FloatArray:
    """Change of the readings (N, k) by a change of the loads (N, n), halved between its two signs."""
    ends = []
    for sign in (0.5, -0.5):
        wrenches, absolute = recorded.wrenches + sign * change, recorded.absolute + sign * change
        rows = row_data(replace(recorded, wrenches=wrenches, absolute=absolute), fit.chain.robot)
        ends.append(fit.chain.predict(rows, fit.values))
    moved: FloatArray = (ends[0] - ends[1])[:, recorded.axes]
    return moved

"""Maps of single measurements, for bounds: candidates drawn from the design space, and what they tell, as R.

For DUIR, R_j = G·A_j. For the total error, load errors that all measurements share are estimated along with the
compliances, R_j = [G·A_j, G·D_j·L_j], with their own covariance as prior, and those that differ from measurement to
measurement add to the noise, V_j = V + D_j·Σ_j·D_jᵀ (theory.md 10.4): no linear unbiased estimator, weighted least
squares among them, does better than the generalised least squares that this describes. Where measurements share their
unloaded reference, V is taken as V/2: the covariance of a series is V⊗½(I + 11ᵀ) ⪰ V⊗½I, so that independent
measurements with half the covariance tell more.

Parameters are scaled: compliances by the approximate ones, load errors by their standard deviations.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.mechanics.differentiation import inverse_root, one_and_gram, plain
from expdesign.planning.optimality.weights import Relaxation
from expdesign.planning.problem import DesignProblem
from expdesign.planning.variables import Rows

CHUNK = 20000
"""Number of measurements that are evaluated at a time, so that memory is that of the results."""


@dataclass(frozen=True)
class LoadVariables:
    """Variables that set the load itself.

    Attributes:
        index: of the variables.
        vertices: every combination of their extreme values, shape (v, len(index)).
    """

    index: IntArray
    vertices: FloatArray


_OVERFLOW = 1e60
"""Observation matrices and error sensitivities beyond this are those of a singular pose."""


class MeasurementMaps:
    """Maps R of single measurements of a problem.

    Args:
        problem: the design problem.
        load_errors: factor on the load errors: 0 leaves DUIR, 1 the total error, and what lies between or beyond
            trades the one for the other, DUIR² + factor²·FEIR².
    """

    def __init__(self, problem: DesignProblem, load_errors: float) -> None:
        self.problem, self.load_errors = problem, load_errors
        shared = problem.shared_errors
        self.common: BoolArray = shared & (load_errors > 0.0)
        self.own: BoolArray = ~shared & (load_errors > 0.0)
        self.sharpness = np.sqrt(2.0) if problem.noise.shared_reference else 1.0
        self._scale = problem.loaded.scale

    def relaxation(self) -> Relaxation:
        """The convex problem for plans of as many measurements as the configuration has."""
        targets = self.problem.targets
        rows = targets.blocks(targets.observation) * self._scale
        if targets.aggregate == "mean":
            rows = np.linalg.qr(rows[0])[1][None]
        nuisance = int(self.common.sum())
        padded = np.concatenate([rows, np.zeros((*rows.shape[:2], nuisance))], axis=2)
        prior = np.diag(np.concatenate([np.zeros(rows.shape[-1]), np.ones(nuisance)]))
        return Relaxation(padded, prior, self.problem.space.measurements)

    def rows(self, variables: FloatArray, *, reference: bool = False) -> FloatArray:
        """R (j, k, q) of measurements with variables (j, g); [R, H] with the `reference` that they share."""
        parts = np.split(self.problem.space.quantities(variables), range(CHUNK, len(variables), CHUNK))
        return np.concatenate([self.of_quantities(part, reference=reference) for part in parts])

    def of_quantities(self, quantities: FloatArray, *, reference: bool = False) -> FloatArray:
        """R (b, k, q) of readings with quantities (b, z), plain or recorded; behind it, where wanted, H (b, k, k), what
        an unknown reading of the reference adds to the whitened deflection (theory.md 10.6).
        """
        whitened = self.whitened(*self.problem.space.split(quantities))
        return self.weighed(*whitened, reference=reference)[0]

    def whitened(self, configurations: FloatArray, loads: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Whitened maps as of the problem, 0 at singular poses.

        An ascent or an exchange may pass one, where the maps overflow; the limit on the condition number keeps such a
        measurement out of every result, and here it counts as if it told nothing.
        """
        observation, errors = self.problem.whitened(configurations, loads)
        size = np.abs(plain(observation)).max(axis=(-2, -1)) + np.abs(plain(errors)).max(axis=(-2, -1), initial=0.0)
        regular = (size < _OVERFLOW)[..., None, None]
        if regular.all():
            return observation, errors
        return np.where(regular, observation, 0.0), np.where(regular, errors, 0.0)

    def weighed(self, observation: FloatArray, errors: FloatArray, *, reference: bool) -> tuple[FloatArray, FloatArray]:
        """R (..., k, q) of whitened maps, with H behind it where wanted, and in the same weights the readings per
        standard deviation of the load errors that each measurement has of its own, (..., k, e).
        """
        stacked, own = observation * (self.sharpness * self._scale), errors @ self._chosen(self.own)
        if self.common.any():
            stacked = np.concatenate([stacked, errors @ self._chosen(self.common)], axis=-1)
        if reference:
            one = self.sharpness * np.eye(stacked.shape[-2])
            stacked = np.concatenate([stacked, np.broadcast_to(one, (*stacked.shape[:-2], *one.shape))], axis=-1)
        if not self.own.any():
            return stacked, own
        weight = inverse_root(one_and_gram(own))
        return weight @ stacked, weight @ own

    def _chosen(self, flags: BoolArray) -> FloatArray:
        """What takes the load errors of some sources from those of all, weighted as they count, shape (d, d')."""
        chosen: FloatArray = self.sharpness * self.load_errors * np.eye(len(flags))[:, flags]
        return chosen

    @property
    def convex_in_load(self) -> bool:
        """Whether d is convex in every load quantity, so that only extreme loads need be looked at.

        At a fixed pose the wrench, and every load error's effect, is affine in each quantity of the load taken alone,
        and d is the square of a linear function of them (theory.md 10.1), as long as the weighting does not depend on
        the load and the compliance map does not.
        """
        loaded = self.problem.loaded
        own = [source.source for source in loaded.sources if not source.shared and self.load_errors > 0.0]
        return loaded.linear_in_load and all(name == "wrench" for name in own)

    def load_variables(self) -> LoadVariables:
        """The variables that set the load (not the tilt of the base), and their extreme combinations."""
        space = self.problem.space
        index, ends = [], []
        for place, variable in enumerate(space.variables):
            if space.n_pose <= variable.columns[0] < space.n_pose + space.n_load:
                index.append(place)
                if isinstance(variable.domain, Rows):
                    values = variable.domain.table[:, 0]
                    ends.append((float(values.argmin()), float(values.argmax())))
                else:
                    ends.append(variable.bounds)
        corners = list(product(*ends))
        return LoadVariables(np.array(index, dtype=np.int64), np.array(corners).reshape(len(corners), len(index)))

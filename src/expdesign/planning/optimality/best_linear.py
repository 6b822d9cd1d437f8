"""What the best linear unbiased estimator would reach at a plan, against least squares, by which plans are judged.

Least squares weigh every reading by the instrument's noise alone. The generalised least squares of Aitken (1936) count
the load errors as well, which is to estimate those that all measurements share along with the compliances, and the
reference that a series shares (theory.md 10.4, 10.6). Bounds on `total` are of it.
"""

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.planning.criteria.information import Information
from expdesign.planning.optimality.differentiated import shared_series
from expdesign.planning.optimality.information import MeasurementInformation
from expdesign.planning.problem import DesignProblem


def best_linear_total(problem: DesignProblem, design: FloatArray) -> float:
    """`total` of a design (m, g) by the best linear unbiased estimator; infinite where it identifies too little."""
    information = MeasurementInformation(problem, 1.0)
    quantities = problem.space.quantities(design[problem.space.taken(design)])
    rows = information.reference_rows(quantities)
    parameters, common = len(problem.loaded.scale), int(problem.shared_errors.sum())
    maps, errors, reference = np.split(rows, [parameters, parameters + common], axis=-1)
    nuisance, prior = errors.reshape(len(rows) * rows.shape[1], common), np.ones(common)
    series = shared_series(problem, quantities) if problem.noise.shared_reference else None
    if series is not None:
        # A reading of the reference for each series, of half the variance of a deflection.
        of_series = series[:, None] == np.unique(series)
        placed = np.einsum("ms,mkl->mksl", of_series, reference).reshape(len(nuisance), -1)
        nuisance, prior = np.concatenate([nuisance, placed], axis=1), np.ones(common + placed.shape[1])
        prior[common:] = np.sqrt(2.0)
    known = Information.beside(maps.reshape(-1, parameters), nuisance, prior)
    variances, _, determined = known.variances(information.relaxation().targets[..., :parameters])
    return float(np.sqrt(variances.sum(axis=-1).max())) if determined.all() else float(np.inf)

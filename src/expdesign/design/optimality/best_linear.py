"""What the best linear unbiased estimator would reach at a plan, against least squares, by which plans are judged.

Least squares weigh every reading by the instrument's noise alone. The generalised least squares of Aitken (1936) count
the load errors as well,

    Cov = (Aᵀ·C⁻¹·A)⁻¹ ,   C = S⊗V + Σ_own + D·Σ_shared·Dᵀ ,

and are what bounds on `total` are of (theory.md 10.4).
"""

from typing import Any

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.design.optimality.differentiated import shared_series
from expdesign.design.optimality.information import MeasurementInformation
from expdesign.design.problem import DesignProblem


def best_linear_total(problem: DesignProblem, design: FloatArray) -> float:
    """`total` of a design (m, g) by the best linear unbiased estimator; infinite where it identifies too little."""
    design = design[problem.space.taken(design)]
    quantities = problem.space.quantities(design)
    configurations, loads = problem.space.split(quantities)
    observation, errors = problem.whitened(configurations, loads)
    m, k, parameters = observation.shape
    rows = (observation * problem.loaded.scale).reshape(m * k, parameters)
    same = np.eye(m)
    if problem.noise.shared_reference:
        series = shared_series(problem, quantities)
        assert series is not None
        same = 0.5 * (np.eye(m) + (series[:, None] == series))
    own, common = errors[..., ~problem.shared_errors], errors[..., problem.shared_errors].reshape(m * k, -1)
    covariance = np.kron(same, np.eye(k)) + common @ common.T
    for place, block in enumerate(own @ own.swapaxes(1, 2)):
        part = slice(place * k, (place + 1) * k)
        covariance[part, part] += block
    white = np.linalg.solve(np.linalg.cholesky(covariance), rows)
    if np.linalg.matrix_rank(white) < parameters:
        return float(np.inf)
    triangle: Any = np.linalg.qr(white, mode="r")
    targets = MeasurementInformation(problem, 0.0).relaxation().targets
    roots = np.linalg.solve(triangle.T, targets.swapaxes(1, 2))
    return float(np.sqrt((roots**2).sum(axis=(1, 2)).max()))

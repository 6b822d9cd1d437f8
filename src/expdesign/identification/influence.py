"""What every measurement contributed: leverage, whether it is an outlier, and which actuator it informed."""

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2, f

from expdesign.arrays import BoolArray, FloatArray
from expdesign.identification.fit import Fit

SIGNIFICANCE = 0.01
"""Chance that a file without outliers has a row flagged as one (shared among the rows, Bonferroni)."""


@dataclass(frozen=True)
class Influence:
    """Contributions of N rows.

    Attributes:
        leverage: trace of each row's block of the hat matrix, between 0 and the number of its readings; their sum is
            the number of parameters (less what a prior contributes), shape (N,).
        distance: rᵀ(I − H)⁻¹r of each row's whitened residuals, shape (N,).
        p_value: of that distance, one row at a time, shape (N,).
        outlier: rows whose p_value is below `SIGNIFICANCE` / N, shape (N,).
        share: part of the information on each actuator's compliance that the row holds, shape (N, n_p); columns add up
            to 1.
    """

    leverage: FloatArray
    distance: FloatArray
    p_value: FloatArray
    outlier: BoolArray
    share: FloatArray


def influence(fit: Fit, *, noise_known: bool) -> Influence:
    """Contributions of the rows of a fit to its parameters.

    With known noise the distance is χ²-distributed with one degree of freedom per reading; otherwise it is compared
    with the residuals of all other rows, which makes it F-distributed.
    """
    count, readings, _ = fit.sensitivities.shape
    hat = fit.sensitivities @ fit.estimable.generalised @ fit.sensitivities.swapaxes(1, 2)
    leverage = np.trace(hat, axis1=1, axis2=2)
    # A reading that alone determines a parameter has no residual to judge it by.
    room = np.eye(readings) * (1.0 + 1e-9) - hat
    distance = (fit.residuals * np.linalg.solve(room, fit.residuals[..., None])[..., 0]).sum(axis=1)
    distance = np.where(np.linalg.norm(fit.residuals, axis=1) > 1e-6, np.maximum(distance, 0.0), 0.0)
    others = fit.dof - readings
    if noise_known:
        p_value = chi2.sf(distance, readings)
    elif others > 0:
        rest = np.maximum(fit.chi2 - distance, 1e-300) / others
        p_value = f.sf(distance / readings / rest, readings, others)
    else:
        p_value = np.ones(count)
    information = (fit.sensitivities**2).sum(axis=1)
    total = information.sum(axis=0)
    share = information / np.where(total > 0.0, total, 1.0)
    return Influence(leverage, distance, p_value, p_value < SIGNIFICANCE / count, share)

"""What every measurement contributed: leverage, whether it is an outlier, and which actuator it informed."""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import BoolArray, FloatArray
from expdesign.estimation.fit import Fit
from expdesign.estimation.outlying import outlying_rows, row_chances
from expdesign.estimation.whitening import Whitening


@dataclass(frozen=True)
class Influence:
    """Contributions of N rows.

    Attributes:
        leverage: trace of each row's block of the hat matrix, between 0 and the number of its readings; their sum is
            the number of parameters (less what a prior contributes), shape (N,).
        distance: by how much χ² is lower without each row, shape (N,).
        p_value: of that distance, one row at a time, shape (N,).
        outlier: rows that stand out from the others (`outlying.outlying_rows`), shape (N,).
        share: part of the information on each actuator's compliance that the row holds, shape (N, n_p); columns add up
            to 1.
    """

    leverage: FloatArray
    distance: FloatArray
    p_value: FloatArray
    outlier: BoolArray
    share: FloatArray


def influence(fit: Fit, whitening: Whitening, *, noise_known: bool) -> Influence:
    """Contributions of the rows of a fit to its parameters.

    With known noise the distance is χ²-distributed with one degree of freedom per reading; otherwise it is compared
    with the residuals of all other rows, which makes it F-distributed.
    """
    leverage = ((fit.sensitivities @ fit.estimable.generalised) * fit.sensitivities).sum(axis=(1, 2))
    distance, p_value = row_chances(fit, whitening, noise_known=noise_known)
    outlier = np.zeros(len(leverage), dtype=bool)
    outlier[list(outlying_rows(fit, whitening, noise_known=noise_known).aside)] = True
    information = (fit.sensitivities**2).sum(axis=1)
    total = information.sum(axis=0)
    share = information / np.where(total > 0.0, total, 1.0)
    return Influence(leverage, distance, p_value, outlier, share)

"""The whitening is an inverse root of the covariance that the noise has."""

import numpy as np
import pytest

from expdesign.estimation.whitening import Whitening

SERIES = np.array([4, 4, 7, 4, 9, 9])
DEVIATIONS = np.random.default_rng(0).uniform(0.5, 2.0, (6, 3))


def covariance(shared: bool) -> np.ndarray:
    """Of the readings of one component, from the definition: half of the variance common to rows of one reference."""
    same = SERIES[:, None] == SERIES[None, :]
    return 0.5 * (np.eye(6) + same) if shared else np.eye(6)


@pytest.mark.parametrize("shared", [False, True])
def test_whitened_noise_has_unit_covariance(shared: bool) -> None:
    whitening = Whitening(DEVIATIONS, references=SERIES.astype(str) if shared else None)
    for component in range(3):
        unit = np.zeros((6, 3, 6))
        unit[np.arange(6), component, np.arange(6)] = 1.0
        matrix = whitening.apply(unit)[:, component]
        deviation = DEVIATIONS[:, component]
        noise = covariance(shared) * np.outer(deviation, deviation)
        np.testing.assert_allclose(matrix @ noise @ matrix.T, np.eye(6), atol=1e-12)

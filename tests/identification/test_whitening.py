"""The whitening is an inverse root of the covariance that the noise has."""

import numpy as np
import pytest

from expdesign.estimation.whitening import LoadColumns, Whitening

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


@pytest.mark.parametrize("shared", [False, True])
def test_declared_load_errors_are_whitened_with_the_noise(shared: bool) -> None:
    random = np.random.default_rng(1)
    loads = LoadColumns(random.standard_normal((6, 3, 2)), 2.0 * random.standard_normal((6, 3, 2)))
    whitening = Whitening(DEVIATIONS, references=SERIES.astype(str) if shared else None, loads=loads)
    unit = np.eye(18).reshape(6, 3, 18)
    root = whitening.apply(unit).reshape(18, 18)
    noise = np.kron(covariance(shared), np.eye(3)) * np.outer(DEVIATIONS.ravel(), DEVIATIONS.ravel())
    common = loads.as_shared.shared.reshape(18, -1)
    total = noise + common @ common.T
    np.testing.assert_allclose(root @ total @ root.T, np.eye(18), atol=1e-11)
    expected = np.linalg.slogdet(total)[1] - np.linalg.slogdet(noise)[1]
    assert whitening.log_determinant == pytest.approx(expected, abs=1e-10)
    scaled = np.linalg.inv(total) * np.outer(DEVIATIONS.ravel(), DEVIATIONS.ravel())
    twice = whitening.scores(whitening.decorrelated(unit)).reshape(18, 18)
    np.testing.assert_allclose(twice, scaled, atol=1e-11)
    blocks = [scaled[3 * row : 3 * row + 3, 3 * row : 3 * row + 3] for row in range(6)]
    np.testing.assert_allclose(whitening.precision, blocks, atol=1e-11)
    if shared:
        return
    kept = np.array([True, False, True, True, False, True])
    part = whitening.rows(kept).apply(np.eye(12).reshape(4, 3, 12)).reshape(12, 12)
    chosen = np.repeat(kept, 3)
    np.testing.assert_allclose(part @ total[np.ix_(chosen, chosen)] @ part.T, np.eye(12), atol=1e-11)

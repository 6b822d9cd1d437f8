"""The whitening is an inverse root of the covariance that the noise has."""

from dataclasses import replace

import numpy as np
import pytest

from expdesign.estimation.shared_noise import SharedNoise
from expdesign.estimation.whitening import LoadColumns, Whitening
from tests.diagnosis.samples import base_fit, sample_of, simulated
from tests.identification.test_correlated_noise import correlation

DEVIATIONS = np.random.default_rng(0).uniform(0.5, 2.0, (6, 3))


REFERENCES = np.array(["4", "4", "7", "4", "", "9"])


@pytest.mark.parametrize("correlated", [False, True])
@pytest.mark.parametrize("references", [None, REFERENCES])
def test_the_whole_covariance(references: np.ndarray | None, correlated: bool) -> None:
    """References that rows share, readings of a row that are correlated, and load errors of rows and of all."""
    random = np.random.default_rng(1)
    loads = LoadColumns(random.standard_normal((6, 3, 2)), 2.0 * random.standard_normal((6, 3, 2)))
    one = correlation(random, 3) if correlated else np.eye(3)
    values, vectors = np.linalg.eigh(one)
    within = np.broadcast_to((vectors / np.sqrt(values)) @ vectors.T, (6, 3, 3)) if correlated else None
    whitening = Whitening(DEVIATIONS, references=references, within=within, loads=loads)
    across, scale = np.eye(6), np.diag(DEVIATIONS.ravel())
    if references is not None:
        alike = (references[:, None] == references) & (references != "")[:, None]
        across = np.where(np.eye(6, dtype=bool), 1.0, 0.5 * alike)
    noise = scale @ np.kron(across, one) @ scale
    common = loads.as_shared.shared.reshape(18, -1)
    total = noise + common @ common.T
    unit = np.eye(18).reshape(6, 3, 18)
    root = whitening.apply(unit).reshape(18, 18)
    np.testing.assert_allclose(root.T @ root, np.linalg.inv(total), atol=1e-10)
    scaled = scale @ np.linalg.inv(total) @ scale
    twice = whitening.scores(whitening.decorrelated(unit)).reshape(18, 18)
    np.testing.assert_allclose(twice, scaled, atol=1e-10)
    blocks = [scaled[3 * row : 3 * row + 3, 3 * row : 3 * row + 3] for row in range(6)]
    np.testing.assert_allclose(whitening.precision, blocks, atol=1e-10)
    if not correlated:
        expected = np.linalg.slogdet(total)[1] - np.linalg.slogdet(noise)[1]
        assert whitening.log_determinant == pytest.approx(expected, abs=1e-10)
    if references is None:
        kept = np.array([True, False, True, True, False, True])
        part = whitening.rows(kept).apply(np.eye(12).reshape(4, 3, 12)).reshape(12, 12)
        chosen = np.repeat(kept, 3)
        np.testing.assert_allclose(part @ total[np.ix_(chosen, chosen)] @ part.T, np.eye(12), atol=1e-10)


def test_some_rows_that_share_references_and_are_correlated() -> None:
    within = np.broadcast_to(np.eye(3), (6, 3, 3))
    half = Whitening(DEVIATIONS, references=REFERENCES, within=within).rows(np.arange(6) % 3 > 0)
    assert half.apply(np.ones((4, 3, 18))).shape == (4, 3, 18)


NAME = "bipod-unequal"


def test_whitening_is_the_inverse_root_of_the_covariance() -> None:
    generator = np.random.default_rng(2)
    laws, variances = [generator.standard_normal((40, width)) for width in (1, 3)], [4.0, 0.3]
    covariance = np.eye(40) + sum(size * law @ law.T for law, size in zip(laws, variances, strict=True))
    root = SharedNoise.of(np.hstack([law * np.sqrt(size) for law, size in zip(laws, variances, strict=True)])).whitened(
        np.eye(40)
    )
    np.testing.assert_allclose(root @ covariance @ root.T, np.eye(40), atol=1e-9)


def test_a_sample_with_this_noise_is_whitened_as_its_readings_are() -> None:
    """Rows that do not count stay at zero, and residuals and derivatives are taken through the same root."""
    sample = sample_of(NAME, simulated(NAME))
    sample = sample.restricted(np.arange(len(sample.counts)) % 4 != 0)
    base, kept = base_fit(NAME, sample), sample.kept
    shared = SharedNoise.of(np.sqrt(3.0) * np.random.default_rng(0).standard_normal((int(kept.sum()), 2)))
    plain, slopes = sample.residuals_with_sensitivities(base.chain, base.values)
    whitened, turned = replace(sample, shared=shared).residuals_with_sensitivities(base.chain, base.values)
    for before, after in (
        (plain.ravel(), whitened.ravel()),
        (slopes.reshape(len(kept), -1), turned.reshape(len(kept), -1)),
    ):
        np.testing.assert_allclose(after[kept], shared.whitened(before[kept]))
        assert not after[~kept].any()

"""Noise that readings share, by which they are whitened."""

from dataclasses import replace

import numpy as np

from expdesign.estimation.shared_noise import SharedNoise
from tests.diagnosis.samples import base_fit, sample_of, simulated

NAME = "bipod-unequal"


def test_whitening_is_the_inverse_root_of_the_covariance() -> None:
    generator = np.random.default_rng(2)
    laws, variances = [generator.standard_normal((40, width)) for width in (1, 3)], [4.0, 0.3]
    covariance = np.eye(40) + sum(size * law @ law.T for law, size in zip(laws, variances, strict=True))
    root = SharedNoise.of_laws(laws, variances).whitened(np.eye(40))
    np.testing.assert_allclose(root @ covariance @ root.T, np.eye(40), atol=1e-9)


def test_a_sample_with_this_noise_is_whitened_as_its_readings_are() -> None:
    """Rows that do not count stay at zero, and residuals and derivatives are taken through the same root."""
    sample = sample_of(NAME, simulated(NAME))
    sample = sample.restricted(np.arange(len(sample.counts)) % 4 != 0)
    base, kept = base_fit(NAME, sample), sample.kept
    shared = SharedNoise.of_laws([np.random.default_rng(0).standard_normal((int(kept.sum()), 2))], [3.0])
    plain, slopes = sample.residuals_with_sensitivities(base.chain, base.values)
    whitened, turned = replace(sample, shared=shared).residuals_with_sensitivities(base.chain, base.values)
    for before, after in (
        (plain.ravel(), whitened.ravel()),
        (slopes.reshape(len(kept), -1), turned.reshape(len(kept), -1)),
    ):
        np.testing.assert_allclose(after[kept], shared.whitened(before[kept]))
        assert not after[~kept].any()

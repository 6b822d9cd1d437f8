"""Errors of many repetitions of one experiment: noise of the readings, and what acts beside the assumed load."""

from typing import Literal

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.design.plan import Plan
from expdesign.elastostatics.measurements import LoadedRobot
from expdesign.instrument.deflection_noise import DeflectionNoise

Distribution = Literal["normal", "uniform"]


def drawn_load_errors(
    loaded: LoadedRobot, plan: Plan, count: int, generator: np.random.Generator, distribution: Distribution = "normal"
) -> FloatArray:
    """Actual minus assumed wrench ε_F = Σ L·δ (theory.md 5.2), shape (count, m, n); an unloaded row has no error.

    A shared source has one δ for all measurements of a repetition. `uniform` has the same standard deviations.
    """
    rotation = loaded.robot.jacobians(plan.configurations).rotation
    wrenches, scaled = loaded.wrenches(rotation, plan.loads)
    total = np.zeros((count, *wrenches.shape))
    for source, sensitivity in zip(loaded.sources, scaled, strict=True):
        size = (count, 1 if source.shared else len(plan), sensitivity.shape[-1])
        if distribution == "normal":
            delta = generator.standard_normal(size)
        else:
            delta = generator.uniform(-np.sqrt(3.0), np.sqrt(3.0), size)
        # A source has few components, and a sum over them is faster than a batch of small matrix products.
        for component in range(sensitivity.shape[-1]):
            total += delta[..., component, None] * sensitivity[..., component]
    total[:, (wrenches == 0.0).all(axis=1)] = 0.0
    return total


def drawn_noise(
    noise: DeflectionNoise, series: IntArray, count: int, generator: np.random.Generator, pose_map: FloatArray
) -> FloatArray:
    """Noise of the measured components (m, rad), shape (count, m, k).

    With a shared reference half its variance is common to the measurements of a series. `pose_map` is J̌ of each
    measurement (m, n, n_a), on which the noise may depend.
    """
    root = np.linalg.inv(noise.whitener_at(pose_map))
    own = generator.standard_normal((count, len(series), root.shape[-1]))
    if noise.shared_reference:
        _, index = np.unique(series, return_inverse=True)
        common = generator.standard_normal((count, int(index.max()) + 1, root.shape[-1]))
        own = np.sqrt(0.5) * (own + common[:, index])
    drawn: FloatArray = own @ root.T if root.ndim == 2 else np.einsum("skj,kij->ski", own, root)
    return drawn

"""Errors of experiments drawn at random: noise of the readings, and what acts beside the assumed load."""

from typing import Literal

import numpy as np
from scipy.linalg import block_diag

from expdesign.arrays import FloatArray, IntArray
from expdesign.chain.instrument.deflection_noise import DeflectionNoise
from expdesign.mechanics.elastostatics.measurements import LoadedRobot

Distribution = Literal["normal", "uniform"]


def drawn_load_errors(
    loaded: LoadedRobot,
    configurations: FloatArray,
    loads: FloatArray,
    count: int,
    generator: np.random.Generator,
    distribution: Distribution = "normal",
) -> FloatArray:
    """Actual minus assumed wrench ε_F = Σ L·δ (N, N·m) of `count` repetitions (theory.md 5.2), shape (count, m, n).

    A shared source has one δ for all m measurements of a repetition; an unloaded measurement has no error.

    Args:
        loaded: the robot with its sources of load error.
        configurations: shape (m, n_q).
        loads: assumed loads, shape (m, k).
        count: of repetitions.
        generator: of random numbers.
        distribution: of δ; `uniform` has the same standard deviations.
    """
    wrenches, scaled = loaded.wrenches(loaded.robot.jacobians(configurations).rotation, loads)
    rows = wrenches.size
    total = np.zeros((count, rows))
    for source, sensitivity in zip(loaded.sources, scaled, strict=True):
        width = sensitivity.shape[-1]
        spread = sensitivity.reshape(rows, width) if source.shared else block_diag(*sensitivity)
        if distribution == "normal":
            delta = generator.standard_normal((count, spread.shape[1]))
        else:
            delta = generator.uniform(-np.sqrt(3.0), np.sqrt(3.0), (count, spread.shape[1]))
        total += delta @ spread.T
    errors = total.reshape(count, *wrenches.shape)
    errors[:, (wrenches == 0.0).all(axis=1)] = 0.0
    return errors


def drawn_noise(
    noise: DeflectionNoise, series: IntArray, count: int, generator: np.random.Generator, pose_map: FloatArray
) -> FloatArray:
    """Noise of the k measured components (m, rad) of `count` repetitions, shape (count, m, k).

    With a shared reference half its variance is common to the measurements of a series (`series`, shape (m,)).
    `pose_map` is J̌ of each measurement, shape (m, n, n_a), on which the noise may depend.
    """
    root = np.linalg.inv(noise.whitener_at(pose_map))
    own = generator.standard_normal((count, len(series), root.shape[-1]))
    if noise.shared_reference:
        _, index = np.unique(series, return_inverse=True)
        common = generator.standard_normal((count, int(index.max()) + 1, root.shape[-1]))
        own = np.sqrt(0.5) * (own + common[:, index])
    drawn: FloatArray = own @ root.T if root.ndim == 2 else np.einsum("skj,kij->ski", own, root)
    return drawn

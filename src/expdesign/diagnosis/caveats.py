"""What limits the statements of a diagnosis, in sentences."""

import numpy as np

from expdesign.diagnosis.base_models import base_model
from expdesign.diagnosis.dispersion import ALIKE, Dispersion
from expdesign.diagnosis.held_out import HeldOut
from expdesign.diagnosis.sample import Sample
from expdesign.diagnosis.selection import Model

_EXPLODES = 10.0
"""Factor between held-out and fitted error above which the held-out rows ask for what was not determined."""
_NO_MOMENT = 1e-6
"""Share of the largest moments below which those about a direction are the rounding of a file."""


def caveats(sample: Sample, model: Model, spread: Dispersion, errors: HeldOut) -> tuple[str, ...]:
    """Sentences, most limiting first."""
    found: list[str] = []
    found += sample.reading.degeneracies
    found += _loose(base_model(model.fit.chain.robot, sample.reading).undetermined(model.fit))
    found += _without_moment(sample, model)
    if errors.test_after > _EXPLODES * max(errors.train_after, 1.0):
        found.append(
            f"The fitted rows do not determine what the held-out rows depend on: {errors.test_after:.3g} standard "
            f"deviations there against {errors.train_after:.3g}."
        )
    if spread.correlation > ALIKE:
        found.append(
            f"Residuals of consecutive rows are alike (correlation {spread.correlation:.2f}): {spread.rows} rows say "
            f"as much as about {spread.effective_rows:.0f} independent ones; intervals allow for it."
        )
    return tuple(found)


def _without_moment(sample: Sample, model: Model) -> list[str]:
    """Directions about which no load of a body had a moment, where that leaves parameters undetermined.

    The moment of a weight is r × (m g), which has no part along g: with M·g = 0 in all rows C and C + λ·g·gᵀ turn
    alike, and where g is not an axis of O that concerns all elements of C.
    """
    if not model.fit.chain.robot.on_support or model.fit.determined.all():
        return []
    moments = sample.recordings.wrenches[sample.counts, 3:]
    if not np.any(moments):
        return []
    _, sizes, directions = np.linalg.svd(moments, full_matrices=True)
    sizes = np.concatenate([sizes, np.zeros(3 - len(sizes))])
    listed = [
        "(" + ", ".join(f"{x:.4f}" for x in direction * np.sign(direction[np.abs(direction).argmax()])) + ")"
        for direction in directions[sizes < _NO_MOMENT * sizes[0]]
    ]
    if not listed:
        return []
    return [
        f"No load has a moment about {' and '.join(listed)}, as moments of a weight have none along gravity: elements "
        "of a compliance that only such a moment tells from others are not determined, however small the noise."
    ]


def _loose(loose: list[str]) -> list[str]:
    """Parameters that are known no better than beforehand."""
    if not loose:
        return []
    listed = ", ".join(loose[:6]) + (" and others" if len(loose) > 6 else "")
    return [
        f"{len(loose)} parameters are aliased with combinations of others and stay what was assumed, within the "
        f"tolerance assumed for them: {listed}. Single values among them mean nothing; their sum does."
    ]

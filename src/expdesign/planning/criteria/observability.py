"""The observability indices O1 to O5 of geometric calibration (theory.md 7), functions of the singular values μ of Ã.

O1 is of Borm & Menq (1989/91), O2 of Driels & Pathre (1990), O3 and O4 of Nahvi & Hollerbach (1994, 1996), O5 of Sun &
Hollerbach (2008), who compare them all.

μ_L = min over unit vectors v of ‖Ã·v‖ and μ_1 = max of the same. Where two singular values coincide neither is
differentiable: any v in the space of their vectors gives a subgradient, that of ‖Ã·v‖ with v held (Lewis & Overton
1996, Eigenvalue optimization, Acta Numerica 5). Some vectors of the space of the three outermost are pieces beside the
value itself, so that steps and optimality conditions see the convex hull of their subgradients, as for any other
maximum (`TargetVariances.largest`).
"""

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.mechanics.differentiation import square_root, sum_of_squares
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.criterion import Criterion

_TWO = ((0.0, 1.0), (1.0, 1.0), (1.0, -1.0))
_THREE = (
    *((*each, 0.0) for each in _TWO),
    (0.0, 0.0, 1.0),
    *((1.0, 0.0, 1.0), (1.0, 0.0, -1.0), (0.0, 1.0, 1.0), (0.0, 1.0, -1.0)),
)
"""Vectors beside that of the value itself, in the basis of the two or three that may coincide."""


def smallest_singular_value(assessment: Assessment, first: int = 1) -> FloatArray:
    """μ_L of b designs, shape (b,); its further pieces have the places from `first` on."""
    return _extreme(assessment, first, (-1, -2, -3))


def largest_singular_value(assessment: Assessment, first: int = 1) -> FloatArray:
    """μ_1 of b designs, shape (b,); its further pieces have the places from `first` on."""
    return _extreme(assessment, first, (0, 1, 2))


def after(assessment: Assessment, first: int = 1) -> int:
    """The place after the pieces of one value whose pieces begin at `first`."""
    return first + len(_directions(assessment))


def _directions(assessment: Assessment) -> tuple[tuple[float, ...], ...]:
    return ((), (), _TWO, _THREE)[min(assessment.parameters, 3)]


def _extreme(assessment: Assessment, first: int, order: tuple[int, ...]) -> FloatArray:
    values, directions = assessment.singular_values, _directions(assessment)
    assessment.pieces = max(assessment.pieces, after(assessment, first))
    piece = assessment.place - first
    if not 0 <= piece < len(directions):
        return values[:, order[0]]
    whitened, right = assessment.whitened, assessment.right_singular_vectors
    vector = sum(part * right[:, place] for part, place in zip(directions[piece], order, strict=False))
    vector = vector / np.linalg.norm(vector, axis=1, keepdims=True)
    along: FloatArray = square_root(sum_of_squares((whitened @ vector[..., None])[..., 0], -1))
    return along


class O1(Criterion):
    """(μ_1 ⋯ μ_L)^{1/L} / √m over the singular values of the whitened observation matrix."""

    name = "o1"
    title = "O1 (D-optimality)"
    unit = "N/m"
    maximise = True

    def values(self, assessment: Assessment) -> FloatArray:
        with np.errstate(divide="ignore"):
            log_mean = np.log(assessment.singular_values).mean(axis=1)
        values: FloatArray = np.exp(log_mean) / np.sqrt(assessment.number)
        return values


class O2(Criterion):
    """μ_min / μ_max."""

    name = "o2"
    title = "O2 (inverse condition)"
    maximise = True

    def values(self, assessment: Assessment) -> FloatArray:
        if assessment.place == 0:
            smallest_singular_value(assessment), largest_singular_value(assessment, after(assessment))
            return 1.0 / assessment.condition
        values: FloatArray = smallest_singular_value(assessment) / largest_singular_value(assessment, after(assessment))
        return values


class O3(Criterion):
    """μ_min."""

    name = "o3"
    title = "O3 (smallest singular value)"
    unit = "N/m"
    maximise = True

    def values(self, assessment: Assessment) -> FloatArray:
        return smallest_singular_value(assessment)


class O4(Criterion):
    """μ_min² / μ_max."""

    name = "o4"
    title = "O4 (noise amplification)"
    unit = "N/m"
    maximise = True

    def values(self, assessment: Assessment) -> FloatArray:
        if assessment.place == 0:
            smallest_singular_value(assessment), largest_singular_value(assessment, after(assessment))
            return assessment.singular_values[:, -1] / assessment.condition
        values: FloatArray = smallest_singular_value(assessment) ** 2 / largest_singular_value(
            assessment, after(assessment)
        )
        return values


class O5(Criterion):
    """1 / Σ(1/μ_i)."""

    name = "o5"
    title = "O5 (harmonic singular values)"
    unit = "N/m"
    maximise = True

    def values(self, assessment: Assessment) -> FloatArray:
        with np.errstate(divide="ignore"):
            values: FloatArray = 1.0 / (1.0 / assessment.singular_values).sum(axis=1)
        return values

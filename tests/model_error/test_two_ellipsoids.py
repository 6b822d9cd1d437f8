"""The largest quadratic form on the intersection of two ellipsoids, against search, known answers and its own bound."""

import numpy as np
import pytest

from expdesign.arrays import FloatArray
from expdesign.assurance.model_error.two_ellipsoids import Largest, largest_along_axes


def largest(forms: FloatArray, visible: FloatArray) -> Largest:
    """The problems of C (b, q, d) and H (b, d, d), in the axes of H."""
    values, axes = np.linalg.eigh(visible)
    found = largest_along_axes(forms @ axes, np.maximum(values, 0.0))
    return Largest(found.bound, found.value, (axes @ found.point[..., None])[..., 0])


def test_primal_meets_dual_in_every_dimension() -> None:
    generator = np.random.default_rng(1)
    for d in (1, 2, 3, 5, 21):
        for q in (1, 2, 10):
            forms = generator.normal(size=(60, q, d))
            columns = 10.0 ** generator.uniform(-2.0, 2.0, size=(60, 1, d))
            roots = generator.normal(size=(60, max(1, d - 1), d)) * columns  # singular for d > 1
            visible = roots.swapaxes(-1, -2) @ roots
            found = largest(forms, visible)
            assert np.allclose(found.value, found.bound, rtol=1e-9)
            seen = np.einsum("bd,bde,be->b", found.point, visible, found.point)
            assert seen.max() <= 1.0 + 1e-7
            assert (found.point**2).sum(axis=1).max() <= 1.0 + 1e-9


def test_two_unknowns_against_all_angles() -> None:
    generator = np.random.default_rng(2)
    angles = np.linspace(0.0, np.pi, 200_001)
    circle = np.stack([np.cos(angles), np.sin(angles)])
    for _ in range(20):
        form = generator.normal(size=(3, 2))
        root = generator.normal(size=(2, 2)) * np.array([3.0, 0.3])
        visible = root.T @ root
        scale = np.maximum(1.0, np.einsum("ia,ij,ja->a", circle, visible, circle))
        best = (((form @ circle) ** 2).sum(axis=0) / scale).max()
        assert largest(form[None], visible[None]).value[0] == pytest.approx(best, rel=1e-4)


def test_no_point_does_better() -> None:
    generator = np.random.default_rng(3)
    form, root = generator.normal(size=(4, 5)), generator.normal(size=(5, 5)) * np.geomspace(0.1, 10.0, 5)
    visible = root.T @ root
    points = generator.normal(size=(5, 100_000))
    points /= np.sqrt(np.maximum((points**2).sum(axis=0), np.einsum("ia,ij,ja->a", points, visible, points)))
    assert ((form @ points) ** 2).sum(axis=0).max() <= largest(form[None], visible[None]).bound[0]


def test_known_answers() -> None:
    # Nothing visible: the unit ball; all plainly visible: the ellipsoid.
    form = np.diag([3.0, 2.0])[None]
    assert largest(form, np.zeros((1, 2, 2))).value[0] == pytest.approx(9.0)
    assert largest(form, np.diag([4.0, 400.0])[None]).value[0] == pytest.approx(9.0 / 4.0)
    # Several directions that are equally bad: the eigenvalue at the best multiplier is multiple.
    found = largest(np.eye(3)[None], np.diag([0.25, 0.25, 4.0])[None])
    assert found.value[0] == pytest.approx(1.0)
    assert np.einsum("d,de,e->", found.point[0], np.diag([0.25, 0.25, 4.0]), found.point[0]) <= 1.0 + 1e-9


def test_multiple_eigenvalue_at_the_optimum() -> None:
    # D(μ) = diag(1 + μ, 1 − μ/2); C = diag(1, 1): both eigenvalues of C·D⁻¹·Cᵀ never cross inside, but for
    # C = diag(√1.5, √0.75) they meet at μ = 0.5, where each alone violates one of the constraints.
    visible = np.diag([2.0, 0.5])
    found = largest(np.diag(np.sqrt([1.5, 0.75]))[None], visible[None])
    assert found.bound[0] == pytest.approx(1.0)
    assert found.value[0] == pytest.approx(1.0)
    assert (found.point[0] ** 2).sum() == pytest.approx(1.0)
    assert found.point[0] @ visible @ found.point[0] == pytest.approx(1.0)


def test_one_constraint_for_both_is_within_a_factor_of_two() -> None:
    generator = np.random.default_rng(4)
    form, root = generator.normal(size=(50, 3, 6)), generator.normal(size=(50, 6, 6))
    visible = root.swapaxes(-1, -2) @ root
    exact = largest(form, visible).value
    inner = np.linalg.norm(form @ np.linalg.inv(np.linalg.cholesky(visible + np.eye(6))).swapaxes(-1, -2), 2, (-2, -1))
    assert (inner**2 <= exact * (1.0 + 1e-9)).all()
    assert (exact <= 2.0 * inner**2 * (1.0 + 1e-9)).all()

"""Elastic bodies and walls that warm, by finite elements (scikit-fem), reduced to what a machine feels of them."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import skfem
from scipy import sparse
from scipy.sparse.linalg import SuperLU, splu
from skfem.helpers import dd, ddot, div, dot, grad, sym_grad, trace
from skfem.models.elasticity import lame_parameters

from ..hexapods import Array

POISSON = 0.3


def _factor(matrix: Any) -> SuperLU:
    """A symmetric definite matrix in its factors."""
    return splu(
        sparse.csc_matrix(matrix), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    )


class Plate:
    """A circular plate of unit bending stiffness D (N m) in Kirchhoff's theory, by Argyris elements.

    Held where `hub` (m) is the radius of a disc that is clamped, or at the vertices next to the `bolts` (n × 2, m).
    """

    def __init__(self, radius: float, hub: float = 0.0, bolts: Array | None = None) -> None:
        mesh = skfem.MeshTri.init_circle(3).scaled(radius)
        self._basis, self._radius = skfem.Basis(mesh, skfem.ElementTriArgyris(), intorder=8), radius

        @skfem.BilinearForm
        def energy(u, v, w):  # type: ignore[no-untyped-def]
            return (1 - POISSON) * ddot(dd(u), dd(v)) + POISSON * trace(dd(u)) * trace(dd(v))

        if bolts is None:
            inside = self._basis.get_dofs(elements=lambda x: np.hypot(*x) < hub)
            held = inside.flatten() if hub else self._basis.get_dofs().all(["u"])
        else:
            nearest = np.array([np.argmin(np.hypot(*(mesh.p - bolt[:, None]))) for bolt in bolts])
            held = self._basis.get_dofs(nodes=nearest).all(["u", "u_x", "u_y"])
        free = np.setdiff1d(np.arange(self._basis.N), held)
        self._solve, self._free = _factor(energy.assemble(self._basis)[free][:, free]), free

    def compliance(self, points: Array) -> Array:
        """Displacements per force (3n × 3n, m/N) at points (n × 3, m) that stand rigidly at z above the mid-plane."""
        step = 1e-4 * self._radius
        deflect = self._at(points[:, :2])
        slopes = [(self._at(points[:, :2] + e) - self._at(points[:, :2] - e)) / (2 * step) for e in step * np.eye(2)]
        height = points[:, 2:3]
        rows = np.stack([-height * slopes[0], -height * slopes[1], deflect], axis=1).reshape(3 * len(points), -1)
        return np.asarray(rows @ self._solve.solve(rows.T))

    def _at(self, points: Array) -> Array:
        return np.asarray(self._basis.probes(points.T).toarray()[:, self._free])


@cache
def block(length: float, width: float, depth: float, taper: float) -> Array:
    """Compliance (6 × 6, E = 1 Pa) of a block held at one end: twist of the other, rigid one per wrench at its centre.

    The block extends along z; its section narrows from `width` × `depth` (m) by the factor `taper`.
    """
    mesh = skfem.MeshHex.init_tensor(*(np.linspace(-0.5, 0.5, 3),) * 2, np.linspace(0, 1, 9))
    narrow = 1 - (1 - taper) * mesh.p[2]
    mesh = skfem.MeshHex(np.array([width * narrow * mesh.p[0], depth * narrow * mesh.p[1], length * mesh.p[2]]), mesh.t)
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementHexS2()), intorder=4)
    lame, shear = lame_parameters(1.0, POISSON)

    @skfem.BilinearForm
    def energy(u, v, w):  # type: ignore[no-untyped-def]
        return 2 * shear * ddot(sym_grad(u), sym_grad(v)) + lame * div(u) * div(v)

    stiffness = energy.assemble(basis).tocsc()
    foot, top = (basis.get_dofs(lambda x, at=at: np.isclose(x[2], at)).flatten() for at in (0.0, length))
    motions, arms = np.zeros((basis.N, 6)), basis.doflocs.T - [0.0, 0.0, length]
    for axis, along in enumerate(basis.split_indices()):
        own = np.intersect1d(along, top)
        motions[own, axis] = 1.0
        for turn in range(3):
            motions[own, 3 + turn] = np.cross(np.eye(3)[turn], arms[own])[:, axis]
    free = np.setdiff1d(np.arange(basis.N), np.concatenate([foot, top]))
    moved = motions.copy()
    moved[free] = _factor(stiffness[free][:, free]).solve(-(stiffness @ motions)[free])
    return np.asarray(np.linalg.inv(moved.T @ (stiffness @ moved)))


def wall(times: Array, room: Array, diffusion: float, pieces: int = 24) -> tuple[Array, Array]:
    """Mean warming and 12 ∫ θ (y − ½) dy (K) of a wall of unit thickness, one face of which follows the room.

    The other face gives no heat away; `diffusion` is thickness² over diffusivity (s); all is at rest at the first time.
    """
    basis = skfem.Basis(skfem.MeshLine(np.linspace(0, 1, pieces + 1)), skfem.ElementLineP1())
    mass = skfem.BilinearForm(lambda u, v, w: u * v).assemble(basis)
    flow = skfem.BilinearForm(lambda u, v, w: dot(grad(u), grad(v))).assemble(basis) / diffusion
    moment = skfem.LinearForm(lambda v, w: 12 * (w.x[0] - 0.5) * v).assemble(basis)
    mean = skfem.LinearForm(lambda v, w: v).assemble(basis)
    steps = max(400, int(np.ptp(times) / (diffusion / 200)))
    fine = np.linspace(times[0], times[-1], steps + 1)
    outside, step = np.interp(fine, times, room - room[0]), float(fine[1] - fine[0])
    implicit, held = (mass + step * flow).tocsc(), int(np.argmin(basis.doflocs[0]))
    free = np.setdiff1d(np.arange(basis.N), [held])
    solve, warmth, found = _factor(implicit[free][:, free]), np.zeros(basis.N), np.zeros((steps + 1, 2))
    for index in range(1, steps + 1):
        right = mass @ warmth - implicit[:, [held]].toarray().ravel() * outside[index]
        warmth[held], warmth[free] = outside[index], solve.solve(right[free])
        found[index] = mean @ warmth, moment @ warmth
    return np.interp(times, fine, found[:, 0]), np.interp(times, fine, found[:, 1])

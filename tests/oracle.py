"""The method once more, written straightforwardly by hand in NumPy: what the tests compare the package with.

Formulas are those of theory.md (sections are named), derived by hand where the package differentiates, and with
explicit normal equations and dense matrices where the package factorises.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from expdesign.mechanics.robots.hexapod import Hexapod
from expdesign.mechanics.robots.parallel import ParallelRobot

Array = np.ndarray[Any, Any]


def central_difference(function: Callable[[Array], Array], at: Array, step: float) -> Array:
    """∂f/∂x at x (..., n) for f to (..., k), shape (..., k, n)."""
    shifts = step * np.eye(at.shape[-1])
    return np.stack([(function(at + shift) - function(at - shift)) / (2.0 * step) for shift in shifts], axis=-1)


def skew(vectors: Array) -> Array:
    """[v]ₓ of vectors (..., 3), shape (..., 3, 3)."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    zero = np.zeros_like(x)
    rows = [[zero, -z, y], [z, zero, -x], [-y, x, zero]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def about(axis: int, angles: Array) -> Array:
    """Rotation matrices (..., 3, 3) about a coordinate axis by Rodrigues' formula."""
    cross = skew(np.eye(3)[axis])
    sine, versine = np.sin(angles)[..., None, None], (1.0 - np.cos(angles))[..., None, None]
    return np.eye(3) + sine * cross + versine * (cross @ cross)


def rotation(angles: Array, orientation: str) -> Array:
    """R from (rx, ry, rz) (file-formats.md, Conventions)."""
    x, y, z = (about(axis, angles[..., axis]) for axis in range(3))
    return z @ y @ x if orientation == "fixed-xyz" else x @ y @ z


def angular_velocity_map(angles: Array, orientation: str) -> Array:
    """E with ω = E·α̇ by the columns of theory.md 2.2."""
    x, y, z = (about(axis, angles[..., axis]) for axis in range(3))
    e = np.eye(3)
    if orientation == "fixed-xyz":
        columns = [(z @ y) @ e[0], z @ e[1], np.broadcast_to(e[2], angles.shape)]
    else:
        columns = [np.broadcast_to(e[0], angles.shape), x @ e[1], (x @ y) @ e[2]]
    return np.stack(columns, axis=-1)


@dataclass(frozen=True)
class Kinematics:
    """Legs and Jacobians of a batch of poses (theory.md 2.1, 2.2)."""

    lengths: Array
    directions: Array
    arms: Array
    rotation: Array
    rates: Array
    forward: Array
    pose: Array


def kinematics(robot: ParallelRobot, poses: Array) -> Kinematics:
    """By hand: u_i, b_i, T, J and J̌ at poses (..., n)."""
    position = robot.home + poses[..., : len(robot.home)]
    dimension = len(robot.home)
    if isinstance(robot, Hexapod):
        turned = rotation(poses[..., 3:], robot.orientation)
        arms = np.einsum("...ij,kj->...ki", turned, robot.platform_joints)
        inner = np.linalg.inv(angular_velocity_map(poses[..., 3:], robot.orientation))
        rates = np.zeros((*poses.shape[:-1], 6, 6))
        rates[..., :3, :3] = np.eye(3)
        rates[..., 3:, 3:] = inner
    else:
        turned = np.broadcast_to(np.eye(2), (*poses.shape[:-1], 2, 2))
        arms = np.zeros((*poses.shape[:-1], 2, 2))
        rates = np.broadcast_to(np.eye(2), (*poses.shape[:-1], 2, 2))
    legs = position[..., None, :] + arms - robot.base_joints  # type: ignore[attr-defined]
    lengths = np.linalg.norm(legs, axis=-1)
    directions = legs / lengths[..., None]
    inverse = directions if dimension == 2 else np.concatenate([directions, np.cross(arms, directions)], axis=-1)
    forward = np.linalg.inv(inverse)
    return Kinematics(lengths, directions, arms, turned, rates, forward, rates @ forward)


def observation(robot: ParallelRobot, poses: Array, wrenches: Array) -> Array:
    """A_ij = J̌_ij Σ_r J_rj ΔF_r (thesis 1.18)."""
    kin = kinematics(robot, poses)
    return np.einsum("...ij,...rj,...r->...ij", kin.pose, kin.forward, wrenches)


def compliance(robot: ParallelRobot, poses: Array) -> Array:
    """D = J̌·K⁻¹·Jᵀ."""
    kin = kinematics(robot, poses)
    return np.einsum("...ij,j,...rj->...ir", kin.pose, 1.0 / robot.stiffness, kin.forward)


def geometric_stiffness(robot: ParallelRobot, poses: Array, forces: Array) -> Array:
    """K_G by the formulas of theory.md 2.3, in pose columns."""
    kin = kinematics(robot, poses)
    dimension = len(robot.home)
    u, b = kin.directions, kin.arms
    projector = (np.eye(dimension) - u[..., :, None] * u[..., None, :]) / kin.lengths[..., None, None]
    if dimension == 2:
        return np.einsum("...k,...kij->...ij", forces, projector)
    cross = skew(b)
    blocks = np.block(
        [
            [projector, -projector @ cross],
            [cross @ projector, -cross @ projector @ cross + skew(u) @ cross],
        ]
    )
    return np.einsum("...k,...kij->...ij", forces, blocks) @ np.linalg.inv(kin.rates)


def payload_wrench(parameters: Array, turned: Array) -> Array:
    """[m·g; (R·c) × m·g] of load parameters (mass, centre of mass, gravity)."""
    dimension = turned.shape[-1]
    force = parameters[..., :1] * parameters[..., -dimension:]
    if dimension == 2:
        return force
    centre = np.einsum("...ij,...j->...i", turned, parameters[..., 1:4])
    return np.concatenate([force, np.cross(centre, force)], axis=-1)


def load_wrench(kind: str, parameters: Array, turned: Array) -> Array:
    """Wrench of a payload or of a wrench's own components."""
    return payload_wrench(parameters, turned) if kind == "payload" else parameters


def tilted(vectors: Array, tilt: Array) -> Array:
    """Vectors turned by finite rotation vectors (tilt_x, tilt_y, 0), or by an angle in the plane."""
    if vectors.shape[-1] == 2:
        c, s = np.cos(tilt[..., 0]), np.sin(tilt[..., 0])
        x, y = vectors[..., 0], vectors[..., 1]
        return np.stack([c * x - s * y, s * x + c * y], axis=-1)
    axis = np.concatenate([tilt, np.zeros_like(tilt[..., :1])], axis=-1)
    angle = np.linalg.norm(axis, axis=-1)[..., None, None]
    cross = skew(axis)
    turn = np.eye(3) + np.sinc(angle / np.pi) * cross + 0.5 * np.sinc(angle / (2.0 * np.pi)) ** 2 * (cross @ cross)
    return np.einsum("...ij,...j->...i", turn, vectors)


def disturbed_wrench(source: str, kind: str, parameters: Array, turned: Array, delta: Array) -> Array:
    """The wrench with a finite load error δ (..., d), exactly."""
    dimension = turned.shape[-1]
    if source == "wrench":
        return load_wrench(kind, parameters, turned) + delta
    parameters = np.broadcast_to(
        parameters, (*np.broadcast_shapes(parameters.shape[:-1], delta.shape[:-1]), parameters.shape[-1])
    ).copy()
    if source == "mass":
        parameters[..., :1] += delta
    elif source == "com":
        parameters[..., 1:4] += delta
    elif kind == "payload":
        parameters[..., -dimension:] = tilted(parameters[..., -dimension:], delta)
    else:
        for start in range(0, parameters.shape[-1], dimension):
            part = slice(start, start + dimension)
            parameters[..., part] = tilted(parameters[..., part], delta)
    return load_wrench(kind, parameters, turned)


def sensitivity(source: str, kind: str, parameters: Array, turned: Array) -> Array:
    """L = ∂F/∂δ by the formulas of theory.md 5.2 for one load (k,), shape (n, d)."""
    dimension = turned.shape[-1]
    wrench = load_wrench(kind, parameters, turned)
    if source == "wrench":
        return np.eye(len(wrench))
    if source == "mass":
        return (wrench / parameters[0])[:, None]
    if source == "direction" and dimension == 2:
        return np.array([[-wrench[1]], [wrench[0]]])
    force = skew(wrench[:3])
    if source == "com":
        return np.vstack([np.zeros((3, 3)), -force @ turned])
    if kind == "wrench":
        return np.vstack([-force, -skew(wrench[3:])])[:, :2]
    centre = skew(turned @ parameters[1:4])
    return np.vstack([-force, centre @ -force])[:, :2]


def noise_covariance(covariance: Array, series: Array, shared_reference: bool) -> Array:
    """Full covariance of all readings: every deflection is a loaded minus an unloaded reading of half its variance."""
    m, k = len(series), len(covariance)
    full = np.zeros((m * k, m * k))
    for i in range(m):
        for j in range(m):
            part = 0.5 * (i == j) + 0.5 * ((series[i] == series[j]) if shared_reference else (i == j))
            full[i * k : (i + 1) * k, j * k : (j + 1) * k] = part * covariance
    return full


@dataclass(frozen=True)
class Dense:
    """One design evaluated with dense matrices and normal equations (theory.md 3-5, 7)."""

    information: Array
    noise: list[Array]
    sensitivity: list[Array]
    force: list[Array]
    singular_values: Array


def dense(
    observations: Array,
    compliances: Array,
    covariance: Array,
    axes: Array,
    series: Array,
    shared_reference: bool,
    errors: list[tuple[Array, bool]],
    targets: Array,
) -> Dense:
    """U, Z and Z·Σ_F·Zᵀ of one design.

    Args:
        observations: A_i, (m, n, n_p).
        compliances: D_i, (m, n, n).
        covariance: V of the measured axes, (k, k).
        axes: measured axes, (k,).
        series: of each measurement, (m,).
        shared_reference: whether a series shares its unloaded reading.
        errors: per source, L_i·diag(σ) of each measurement (m, n, d) and whether δ is shared.
        targets: A_D, (t, n, n_p).
    """
    m, n, parameters = observations.shape
    stacked = observations[:, axes].reshape(-1, parameters)
    weight = np.linalg.inv(noise_covariance(covariance, series, shared_reference))
    # Balanced before it is solved: the normal equations of the compliances themselves are needlessly ill-conditioned.
    scale = 1.0 / np.sqrt(np.diag(stacked.T @ weight @ stacked))
    scaled = stacked * scale
    information = scaled.T @ weight @ scaled
    gain = scale[:, None] * np.linalg.solve(information, scaled.T @ weight)
    blocks = np.zeros((m * len(axes), m * n))
    for i in range(m):
        blocks[i * len(axes) : (i + 1) * len(axes), i * n : (i + 1) * n] = compliances[i][axes]
    force_covariance = np.zeros((m * n, m * n))
    for error, shared in errors:
        if shared:
            stack = error.reshape(m * n, -1)
            force_covariance += stack @ stack.T
        else:
            for i in range(m):
                part = slice(i * n, (i + 1) * n)
                force_covariance[part, part] += error[i] @ error[i].T
    inverse = np.outer(scale, scale) * np.linalg.inv(information)
    noise = [target @ inverse @ target.T for target in targets]
    z = [-target @ gain @ blocks for target in targets]
    force = [matrix @ force_covariance @ matrix.T for matrix in z]
    values = np.sqrt(np.linalg.eigvalsh(stacked.T @ weight @ stacked)[::-1])
    return Dense(stacked.T @ weight @ stacked, noise, z, force, values)

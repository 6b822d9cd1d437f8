"""Deflections from points of the platform that were measured unloaded and loaded, with their covariance.

Seen from O, the points p_i (levers from the platform's origin) move by δt + δθ × p_i. The motion that fits the loaded
points to the unloaded ones best is found by rigid registration (`chain/readings/registration.py`), and with
B_i = [I, −[p_i]ₓ], A = (Σ B_iᵀ·B_i)⁻¹·Bᵀ and the covariance Σ of all coordinates, the sum of both measurements',

    Cov(δt, δθ) = A·Σ·Aᵀ,        ΔX = T·(δt, δθ),   Cov(ΔX) = T·Cov(δt, δθ)·Tᵀ,

T taking twists to rates of the pose coordinates. Where the points' standard deviations are not stated, one for all of
them is estimated from what the registrations leave over, Σr²/Σ(3N − 6), which is that of a difference.

How O lies to the instrument is needed for the directions alone: a deflection of 10 µm is turned by 1e-4 rad into
another 1 nm. It is known from the places of the points on the platform and its commanded pose, or from the instrument's
own pose, or the points were measured in O.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from expdesign.arrays import FloatArray
from expdesign.chain.readings.registration import motion_rows, registered
from expdesign.errors import InputError
from expdesign.estimation.preparation.point_lists import MarkerFit, PointSet, marker_fit, near_names, require_own_names
from expdesign.estimation.preparation.states import RecordedState

SUSPICIOUS = 25.0
"""χ² of 3 degrees of freedom (exceeded once in 65,000) above which a point moved, or was taken for another."""


@dataclass(frozen=True)
class InstrumentFrame:
    """Where the platform is: T_OP (rotation and origin) and T with Ẋ = T·η, at the command of a row."""

    rotation: FloatArray
    origin: FloatArray
    rates: FloatArray


@dataclass(frozen=True)
class RegisteredDeflection:
    """The deflection of one row.

    Attributes:
        deflection: ΔX (m, rad), shape (6,).
        sensitivity: of ΔX to the coordinates' differences, T·A, shape (6, N, 3).
        variances: covariance of every point's difference along O (m²), shape (N, 3, 3), or None where not stated.
        residuals: of the registration (m), shape (N, 3).
        redundancy: I − B_i·(Σ BᵀB)⁻¹·B_iᵀ, what of a point's error its residual shows, shape (N, 3, 3).
        points: names of the points.
        markers: how the unloaded points fit the robot's markers; None where these are not known.
    """

    deflection: FloatArray
    sensitivity: FloatArray
    variances: FloatArray | None
    residuals: FloatArray
    redundancy: FloatArray
    points: tuple[str, ...]
    markers: MarkerFit | None = None

    def covariance(self, variance: float) -> FloatArray:
        """Cov(ΔX) (m², m·rad, rad²), shape (6, 6); `variance` of a difference where the points state none."""
        own = np.eye(3) * variance if self.variances is None else self.variances
        spread = np.broadcast_to(own, (len(self.points), 3, 3))
        covariance: FloatArray = np.einsum("ani,nij,bnj->ab", self.sensitivity, spread, self.sensitivity)
        return covariance


def registered_deflection(
    state: RecordedState,
    frame: InstrumentFrame,
    *,
    markers: Mapping[str, FloatArray],
    instrument: tuple[FloatArray, FloatArray] | None,
    deviation: float | None,
) -> RegisteredDeflection:
    """The deflection of one row.

    Args:
        state: its points.
        frame: where the platform is by its command.
        markers: known places of points on the platform (m); at least three of the measured ones fix the frame.
        instrument: rotation and origin of the instrument in O, where markers do not fix it; None where unknown.
        deviation: standard deviation of every coordinate (m), where the list states none.

    Raises:
        InputError: fewer than three common points, points on one line, or a frame that nothing fixes.
    """
    names = tuple(name for name in state.reference.points if name in state.loaded.points)
    before, after = (_positions(one, names) for one in (state.reference, state.loaded))
    _require_spread(before, state)
    require_own_names(before, after, names, f"{state.loaded.source}, {state.loaded.name}")
    fit = marker_fit(state.reference, markers)
    rotation, origin = _to_base(state, names, before, frame, markers, instrument)
    levers, moved = (points @ rotation.T + origin - frame.origin for points in (before, after))
    turn, shift = registered(levers, moved)
    twist = np.concatenate([shift, Rotation.from_matrix(turn).as_rotvec()])
    rows = motion_rows(levers)
    estimator = np.linalg.pinv(rows.reshape(-1, 6))
    sensitivity = (frame.rates @ estimator).reshape(6, -1, 3)
    variances = _variances(state, names, deviation)
    if variances is not None:  # along the instrument's axes
        variances = np.einsum("ai,ni,bi->nab", rotation, variances, rotation)
    residuals = moved - levers @ turn.T - shift
    redundancy = np.eye(3) - rows @ np.linalg.pinv(np.einsum("nij,nik->jk", rows, rows)) @ rows.swapaxes(-1, -2)
    return RegisteredDeflection(frame.rates @ twist, sensitivity, variances, residuals, redundancy, names, fit)


def difference_variance(found: list[RegisteredDeflection]) -> float | None:
    """Variance of a coordinate's difference (m²) from what all registrations leave over; None without redundancy."""
    squares = sum(float((one.residuals**2).sum()) for one in found)
    freedom = sum(one.residuals.size - 6 for one in found)
    return squares / freedom if freedom > 0 and squares > 0.0 else None


def suspicion(one: RegisteredDeflection, variance: float | None) -> str | None:
    """The point that moved differently from the others, in words, or None.

    An error of one point spreads over all residuals; r_iᵀ·Q_i⁺·r_i, Q_i being the covariance of its residual, is
    largest at the point that has it (Baarda's test for gross errors, 1968).
    """
    if one.variances is not None:
        own = np.linalg.eigvalsh(one.variances)[:, -1]
    elif variance is not None:
        own = np.full(len(one.points), variance)
    else:
        return None
    moved = np.einsum("nij,nj->ni", np.linalg.pinv(one.redundancy, rcond=1e-6, hermitian=True), one.residuals)
    statistic = (one.residuals * moved).sum(axis=1) / own
    worst = int(np.argmax(statistic))
    if statistic[worst] <= SUSPICIOUS:
        return None
    size = float(np.linalg.norm(moved[worst]))
    return f"point {one.points[worst]} moved differently from the others, by {size * 1e6:.3g} µm"


def _positions(points: PointSet, names: tuple[str, ...]) -> FloatArray:
    return np.array([points.points[name].position for name in names]).reshape(-1, 3)


def _variances(state: RecordedState, names: tuple[str, ...], deviation: float | None) -> FloatArray | None:
    total = np.zeros((len(names), 3))
    for one in (state.reference, state.loaded):
        stated = [one.points[name].deviation for name in names]
        if deviation is not None:
            total += deviation**2
        elif any(item is None for item in stated):
            return None
        else:
            total += np.array([item for item in stated if item is not None]) ** 2
    return total


def _require_spread(points: FloatArray, state: RecordedState) -> None:
    where = f"{state.loaded.source}, {state.loaded.name}"
    if len(points) < 3:
        what = f"only {len(points)} points have the same name as in {state.reference.name}"
        near = near_names(list(state.loaded.points), list(state.reference.points))
        remedy = near or "At least three are needed, with the same names in both states."
        raise InputError(what, where=where, remedy=remedy)
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if spread[1] < 1e-3 * spread[0]:
        raise InputError("the points lie on one line", where=where, remedy="Measure three that do not.")


def _to_base(
    state: RecordedState,
    names: tuple[str, ...],
    before: FloatArray,
    frame: InstrumentFrame,
    markers: Mapping[str, FloatArray],
    instrument: tuple[FloatArray, FloatArray] | None,
) -> tuple[FloatArray, FloatArray]:
    """Rotation and origin that take measured points to O."""
    known = [index for index, name in enumerate(names) if name in markers]
    if len(known) >= 3:
        places = np.array([markers[names[index]] for index in known])
        rotation, position = registered(places, before[known])  # of the platform in the instrument's frame
        turn = frame.rotation @ rotation.T
        return turn, frame.origin - turn @ position
    if instrument is None:
        what = "nothing says how the instrument's frame lies to the robot's"
        remedy = (
            "Give the points' places on the platform (`markers`) or the `instrument` in the robot file, or say that "
        )
        remedy += "the points were measured in the robot's base frame (argument `base_frame`)."
        near = near_names(names, list(markers))
        if near:
            what, remedy = f"only {len(known)} of the points are among the robot's `markers`", near
        raise InputError(what, where=state.reference.source, remedy=remedy)
    return instrument

"""Measured poses freed of thermal deflection, and what the correction costs in noise (theory.md 9.H, C12).

The references X_R^k show how the legs have grown, Δq^k = IK(X_R^k) − IK(X_R^0), and a pose measured after them is
corrected to FK(IK(X^k) − Δq^k). To first order that is X^k − T·(X_R^k − X_R^0) with T = J̌(X)·J̌(X_R)⁻¹, so that every
result is a known linear combination of independent readings, and its covariance follows.

Forward kinematics of parallel robots: the pose at given leg lengths, by Newton's method from a pose nearby.

q(X + δX) = q(X) + ∂q/∂X·δX (thesis 1.13); from within the workspace it converges quadratically, and where it does not,
the lengths belong to no pose near the start.

Tables of absolute measured poses, with a reference pose before each of them (theory.md 9.H).

The columns are those of recordings without deflections, and besides:

    kind                      `reference` (always the same command, without load) or `pose`
    measured_x_m …            the pose as it was measured, in the coordinates of the commanded one
    sx_m …                    standard deviations of the measured pose (optional)
"""

from dataclasses import dataclass
from functools import lru_cache

import casadi as ca
import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.chain.recordings.measured import FARTHEST, KINDS, read_deviations
from expdesign.chain.recordings.points import order_in_time, points_from_table, require_one_command
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.errors import ConvergenceError, InputError
from expdesign.io.table import Table
from expdesign.mechanics.robots.parallel import ParallelRobot
from expdesign.mechanics.symbolic import BatchFunction

_TOLERANCE = 1e-14
"""m of leg length; rounding of lengths below a metre is 1e-16."""
_PASSES = 30


class ForwardKinematics:
    """X(q; g) of a parallel robot.

    Args:
        robot: the robot; its own geometry holds where none is given.
    """

    def __init__(self, robot: ParallelRobot) -> None:
        self._robot = robot
        pose, geometry = ca.SX.sym("X", robot.coordinates.n), ca.SX.sym("g", len(robot.geometry))
        lengths = robot.actuator_lengths(pose, geometry)
        self._rates = BatchFunction("rates", [pose, geometry], [lengths, ca.jacobian(lengths, pose)])

    def pose(self, lengths: FloatArray, start: FloatArray, geometry: FloatArray | None = None) -> FloatArray:
        """Poses (..., n) with the given leg lengths (m), near `start` (..., n).

        Args:
            lengths: shape (..., n_p).
            start: poses nearby, shape (..., n).
            geometry: joint coordinates in the order of `geometry_names` (m), shape (..., n_g); the robot's own if None.

        Raises:
            ConvergenceError: no pose near the start has these lengths.
        """
        coordinates = self._robot.geometry if geometry is None else geometry
        batch = np.broadcast_shapes(lengths.shape[:-1], start.shape[:-1], coordinates.shape[:-1])
        pose: FloatArray = np.broadcast_to(start, (*batch, start.shape[-1])).copy()
        for _ in range(_PASSES):
            reached, rates = self._rates(pose, coordinates)
            missing = lengths - reached
            if not np.isfinite(rates).all():
                break
            pose += np.linalg.solve(rates, missing[..., None])[..., 0]
            if np.abs(missing).max() < _TOLERANCE * max(1.0, float(np.abs(lengths).max()) / 0.1):
                return pose
        what = "there is no pose with these leg lengths near the one that is expected"
        raise ConvergenceError(what, remedy="Check the lengths, or the geometry in the robot file.")


@lru_cache(maxsize=32)
def forward_kinematics(robot: ParallelRobot) -> ForwardKinematics:
    """The forward kinematics of a robot; its expressions are made once."""
    return ForwardKinematics(robot)


@dataclass(frozen=True)
class MeasuredPoses:
    """Measured poses in the order of their sequence.

    Attributes:
        points: commands and loads of N rows.
        reference: which rows are references, shape (N,).
        poses: as measured (m, rad), shape (N, n).
        deviations: standard deviations of `poses`, shape (N, n), or None where they are not stated.
    """

    points: LoadedPoints
    reference: BoolArray
    poses: FloatArray
    deviations: FloatArray | None


def measured_poses(table: Table, robot: ParallelRobot) -> MeasuredPoses:
    """Read measured poses.

    Raises:
        InputError: a column is missing, a reference is loaded or not where the others are, or none stands before the
            first pose.
    """
    names = tuple(f"measured_{name}" for name in robot.coordinates.pose)
    table.require(("sequence", "series", "kind", *names))
    points = points_from_table(table, robot)
    order = order_in_time(table)
    reference: BoolArray = table.words("kind", KINDS, "`{}` is neither `reference` nor `pose`", order) == "reference"
    poses = table.numbers(names)[order]
    what = f"{{:g}} is more than {FARTHEST:g} away from the commanded pose"
    remedy = "Check the unit (m, rad) and the frame: measured and commanded poses are in the same coordinates."
    table.refuse(np.abs(poses - points.configurations) > FARTHEST, names, what, remedy, order, poses)
    _require_references(points, reference)
    rows = np.flatnonzero(~reference)
    require_one_command(table, robot.configuration, points.configurations[rows], points.series[rows], order[rows])
    axes = np.arange(robot.coordinates.n)
    return MeasuredPoses(points, reference, poses, read_deviations(table, robot.coordinates, axes, order))


def _require_references(points: LoadedPoints, reference: BoolArray) -> None:
    rows = np.flatnonzero(reference)
    if not rows.size or not reference[0]:
        what = "there is no reference before the first pose"
        raise InputError(what, where=points.where(0, "kind"), remedy="Measure the reference pose first.")
    if not np.any(~reference):
        raise InputError("there are references alone", where=points.source, remedy="Add rows of the kind `pose`.")
    loaded = rows[np.any(points.wrenches[rows] != 0.0, axis=1)]
    if loaded.size:
        what = "a reference has a load, and would take its deflection for thermal"
        raise InputError(what, where=points.where(int(loaded[0])), remedy="Measure references without load.")
    moved = np.abs(points.configurations[rows] - points.configurations[rows[0]]).max(axis=1) > 1e-9
    if moved.any():
        what = "the reference pose differs from the first one"
        raise InputError(what, where=points.where(int(rows[np.argmax(moved)])), remedy="Use one reference pose.")


@dataclass(frozen=True)
class CorrectedPoses:
    """N poses (references left out) before and after the correction.

    Attributes:
        rows: of the measured poses, shape (N,).
        before: as measured (m, rad), shape (N, n).
        after: corrected, shape (N, n).
        weights: of the K references in each correction, minus one for the first, shape (N, K).
        transfer: T, shape (N, n, n).
        own: covariance of the measured pose, shape (N, n, n), or None where no deviations are stated.
        references: covariance of every reference, shape (K, n, n), or None.
    """

    rows: IntArray
    before: FloatArray
    after: FloatArray
    weights: FloatArray
    transfer: FloatArray
    own: FloatArray | None
    references: FloatArray | None

    def covariance(self, first: FloatArray, second: FloatArray) -> FloatArray | None:
        """Covariance of Σ_i first_i·X_i and Σ_i second_i·X_i over corrected poses; coefficients (N,), shape (n, n)."""
        if self.own is None or self.references is None:
            return None
        total: FloatArray = np.einsum("i,i,iab->ab", first, second, self.own)
        left = np.einsum("i,ik,iab->kab", first, self.weights, self.transfer)
        right = np.einsum("i,ik,iab->kab", second, self.weights, self.transfer)
        total += np.einsum("kab,kbc,kdc->ad", left, self.references, right)
        return total


def correct_poses(robot: ParallelRobot, measured: MeasuredPoses, *, interpolate: bool = False) -> CorrectedPoses:
    """Correct every pose by the reference before it, or interpolated in time between those before and after it.

    Where `interpolate` finds no reference after a pose, the one before it holds.

    Raises:
        ConvergenceError: lengths belong to no pose.
    """
    times = measured.points.sequence.astype(float) if measured.points.time is None else measured.points.time
    rows, references = np.flatnonzero(~measured.reference), np.flatnonzero(measured.reference)
    weights = np.zeros((len(rows), len(references)))
    for index, row in enumerate(rows):
        last = int(np.searchsorted(references, row)) - 1
        share = 0.0
        if interpolate and last + 1 < len(references):
            start, end = times[references[last]], times[references[last + 1]]
            share = float((times[row] - start) / (end - start)) if end > start else 0.5
            weights[index, last + 1] += share
        weights[index, last] += 1.0 - share
        weights[index, 0] -= 1.0
    grown = robot.lengths(measured.poses[references])
    lengths = robot.lengths(measured.poses[rows]) - weights @ grown
    after = forward_kinematics(robot).pose(lengths, measured.poses[rows])
    at_reference = robot.jacobians(measured.points.configurations[references[0]]).pose
    transfer = robot.jacobians(measured.points.configurations[rows]).pose @ np.linalg.inv(at_reference)
    own = spread = None
    if measured.deviations is not None:
        covariance = measured.deviations[..., None] ** 2 * np.eye(measured.deviations.shape[1])
        own, spread = covariance[rows], covariance[references]
    return CorrectedPoses(rows, measured.poses[rows], after, weights, transfer, own, spread)


@dataclass(frozen=True)
class CorrectedDeflections:
    """Deflections of M loaded rows.

    Attributes:
        index: of each in the corrected poses, shape (M,).
        before: without the correction (m, rad), shape (M, n).
        after: with it, shape (M, n).
        covariance: of `after`, shape (M, n, n), or None where no deviations are stated.
        noise_before: covariance of `before`, likewise.
    """

    index: IntArray
    before: FloatArray
    after: FloatArray
    covariance: FloatArray | None
    noise_before: FloatArray | None


def deflections(measured: MeasuredPoses, corrected: CorrectedPoses) -> CorrectedDeflections:
    """Deflections of every series against its first unloaded pose.

    Raises:
        InputError: a series has no unloaded pose at its beginning.
    """
    points = measured.points
    series = points.series[corrected.rows]
    loaded = np.any(points.wrenches[corrected.rows] != 0.0, axis=1)
    pairs: list[tuple[int, int]] = []
    for number in dict.fromkeys(series.tolist()):
        members = np.flatnonzero(series == number)
        if loaded[members[0]]:
            what = f"series {number} does not begin with an unloaded pose, against which its deflections are"
            where = points.where(int(corrected.rows[members[0]]), "series")
            raise InputError(what, where=where, remedy="Measure every series without load first.")
        pairs += [(int(member), int(members[0])) for member in members[1:]]
    index, first = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
    covariance = noise = None
    if corrected.own is not None and corrected.references is not None:
        noise = corrected.own[index] + corrected.own[first]
        # The poses of a series have one command, and with it one T.
        weights, transfer = corrected.weights[index] - corrected.weights[first], corrected.transfer[index]
        shared = np.einsum("mk,kbc->mbc", weights**2, corrected.references)
        covariance = noise + transfer @ shared @ transfer.swapaxes(-1, -2)
    before, after = (poses[index] - poses[first] for poses in (corrected.before, corrected.after))
    return CorrectedDeflections(index, before, after, covariance, noise)


@dataclass(frozen=True)
class Repeatability:
    """RMS scatter of poses that were measured more than once at the same command and load, about their means.

    Attributes:
        groups: how many such commands and loads there are.
        freedom: rows less groups, over which the squares are averaged.
        before: without the correction (m, rad), shape (n,).
        after: with it, shape (n,).
        noise_before: what noise alone makes of it without the correction, shape (n,), or None.
        noise_after: likewise with it: the price of the correction is in it.
    """

    groups: int
    freedom: int
    before: FloatArray
    after: FloatArray
    noise_before: FloatArray | None
    noise_after: FloatArray | None


def repeatability(measured: MeasuredPoses, corrected: CorrectedPoses) -> Repeatability | None:
    """Scatter of repeated poses before and after the correction, or None where no pose is repeated."""
    points, rows = measured.points, corrected.rows
    keys = np.round(np.concatenate([points.configurations[rows], points.wrenches[rows]], axis=1), 9)
    _, index = np.unique(keys, axis=0, return_inverse=True)
    members = [np.flatnonzero(index == group) for group in np.unique(index)]
    members = [group for group in members if len(group) > 1]
    if not members:
        return None
    freedom = sum(len(group) - 1 for group in members)
    n = corrected.before.shape[1]
    squares = np.zeros((2, n))
    noise = np.zeros((2, n))
    for group in members:
        for which, values in enumerate((corrected.before, corrected.after)):
            squares[which] += ((values[group] - values[group].mean(axis=0)) ** 2).sum(axis=0)
        if corrected.own is None or corrected.references is None:
            continue
        centring = np.eye(len(group)) - 1.0 / len(group)
        noise[0] += np.einsum("i,iaa->a", np.diag(centring), corrected.own[group])
        spread = np.einsum(
            "iab,kbc,iac->ika", corrected.transfer[group], corrected.references, corrected.transfer[group]
        )
        # One command has one T: the references' part of the covariance of two rows i, j is Σ_k w_ik·w_jk·T·V_k·Tᵀ.
        shared = np.einsum("ij,ik,jk,ika->a", centring, corrected.weights[group], corrected.weights[group], spread)
        noise[1] += np.einsum("i,iaa->a", np.diag(centring), corrected.own[group]) + shared
    rms = np.sqrt(squares / freedom)
    expected = None if corrected.own is None else np.sqrt(noise / freedom)
    return Repeatability(len(members), freedom, *rms, *((None, None) if expected is None else expected))

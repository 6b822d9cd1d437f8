"""Measured poses freed of thermal deflection, and what the correction costs in noise (theory.md 9.H, C12).

The references X_R^k show how the legs have grown, Δq^k = IK(X_R^k) − IK(X_R^0), and a pose measured after them is
corrected to FK(IK(X^k) − Δq^k). To first order that is X^k − T·(X_R^k − X_R^0) with T = J̌(X)·J̌(X_R)⁻¹, so that every
result is a known linear combination of independent readings, and its covariance follows.

Tables hold absolute measured poses with a reference pose before each. The columns are those of recordings without
deflections, and besides:

    kind                      `reference` (always the same command, without load) or `pose`
    measured_x_m …            the pose as it was measured, in the coordinates of the commanded one
    sx_m …                    standard deviations of the measured pose (optional)
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.chain.recordings.measured import FARTHEST, KINDS, read_measured
from expdesign.chain.recordings.points import points_from_table, require_one_command
from expdesign.chain.recordings.recordings import POSES, LoadedPoints, in_order
from expdesign.errors import InputError
from expdesign.io.table import Table
from expdesign.mechanics.robots.parallel import ParallelRobot


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
    table, points = in_order(table), points_from_table(table, robot)
    reference: BoolArray = table.words("kind", KINDS, "`{}` is neither `reference` nor `pose`") == "reference"
    _, poses, deviations = read_measured(table, POSES, robot.coordinates)
    what = f"{{:g}} is more than {FARTHEST:g} away from the commanded pose"
    remedy = "Check the unit (m, rad) and the frame: measured and commanded poses are in the same coordinates."
    table.refuse(np.abs(poses - points.configurations) > FARTHEST, names, what, remedy, poses)
    _require_references(points, reference)
    rows = np.flatnonzero(~reference)
    require_one_command(table.rows(rows), robot.configuration, points.configurations[rows], points.series[rows])
    return MeasuredPoses(points, reference, poses, deviations)


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

    def covariances(self, combinations: FloatArray) -> tuple[FloatArray, FloatArray] | None:
        """Covariances of Σ_i a_i·X_i before and after the correction, for combinations a (M, N); (M, n, n) each."""
        if self.own is None or self.references is None:
            return None
        before: FloatArray = np.einsum("mi,iab->mab", combinations**2, self.own)
        after = before.copy()
        for index, combination in enumerate(combinations):
            poses = np.flatnonzero(combination)
            seen = np.flatnonzero(self.weights[poses].any(axis=0))
            weights = combination[poses, None] * self.weights[np.ix_(poses, seen)]
            through = np.einsum("ik,iab->kab", weights, self.transfer[poses])
            after[index] += np.einsum("kab,kbc,kdc->ad", through, self.references[seen], through)
        return before, after


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
    after = robot.pose_of(lengths, measured.poses[rows])
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
    differences = np.eye(len(series))[index] - np.eye(len(series))[first]
    noise, covariance = corrected.covariances(differences) or (None, None)
    return CorrectedDeflections(index, differences @ corrected.before, differences @ corrected.after, covariance, noise)


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
    about_mean = np.eye(len(rows))
    for group in members:
        about_mean[np.ix_(group, group)] -= 1.0 / len(group)
    about_mean = about_mean[np.concatenate(members)]

    def rms(squares: FloatArray) -> FloatArray:
        found: FloatArray = np.sqrt(squares.sum(axis=0) / freedom)
        return found

    covariances = corrected.covariances(about_mean)
    noise = (None, None) if covariances is None else [rms(np.einsum("maa->ma", each)) for each in covariances]
    scatter = (rms((about_mean @ poses) ** 2) for poses in (corrected.before, corrected.after))
    return Repeatability(len(members), freedom, *scatter, *noise)

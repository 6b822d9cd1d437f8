"""What whole plans are made of, where the poses are finitely many: columns of an integer program (theory.md 10.7).

A column is a pose and, for each measurement taken there, a box in the range of the load: one measurement, or a series
that shares its reference. What a column can tell at most, for a given Q, is bounded at the corners of the boxes,
because it is convex in every load; a bound over columns therefore holds for every load in the boxes.
"""

from dataclasses import dataclass, replace

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.design.optimality.information import MeasurementInformation
from expdesign.design.optimality.load_boxes import Boxes, LoadRange
from expdesign.design.optimality.measurement_pool import enumerated
from expdesign.design.optimality.series import Multisets, SeriesInformation, longer, quadratic
from expdesign.design.optimality.series_pool import takes_series
from expdesign.design.optimality.weights import Dual

_MAPS, _AT_ONCE = 20_000_000, 2_000_000
_FORMS, _GATHERED = 1e10, 1e8
"""Multiplications per second of large forms, and entries per second that are gathered for columns."""


@dataclass(frozen=True)
class Sites:
    """The poses, and the maps at the corners of the load's range.

    Attributes:
        variables: of every pose with the load's corners, shape (p, v, g).
        maps: [R, H], shape (p, v, k, q + k); R alone, (p, v, k, q), for measurements that are independent.
        boxes: in the range of the load.
        series: whether measurements at a pose are one series.
    """

    variables: FloatArray
    maps: FloatArray
    boxes: Boxes
    series: bool

    def quadratic(self, dual: Dual, n: int, among: IntArray) -> tuple[FloatArray, FloatArray]:
        """Forms G and S (p', v, v): a mixture λ of corners tells λᵀGλ by itself, and n measurements with the sum s of
        their mixtures lose sᵀSs to the reference that they share.
        """
        maps = self.maps[among]
        products = maps[..., : dual.matrix.shape[0]] @ dual.matrix
        flat = products.reshape(*products.shape[:2], -1)
        gram = flat @ flat.swapaxes(-1, -2)
        return gram, quadratic(dual, maps)[1](n) if self.series else np.zeros_like(gram)


@dataclass(frozen=True)
class Columns:
    """J columns of n measurements each.

    Attributes:
        sites: poses and maps.
        pose: of a column, shape (J,).
        boxes: numbers of its measurements' boxes, shape (J, n).
    """

    sites: Sites
    pose: IntArray
    boxes: IntArray

    def __len__(self) -> int:
        return len(self.pose)

    @property
    def size(self) -> int:
        """N."""
        return self.boxes.shape[1]

    @property
    def seconds(self) -> float:
        """Of a processor, as estimated, that it takes to see what they tell by one Q (`by_corner`)."""
        boxes, corners, vertices = self.sites.boxes.mixtures.shape
        forms = len(np.unique(self.pose)) * boxes * corners * vertices**2 / _FORMS
        return forms + len(self) * self.size * corners * (vertices if self.sites.series else 1) / _GATHERED

    def take(self, keep: IntArray) -> "Columns":
        return replace(self, pose=self.pose[keep], boxes=self.boxes[keep])

    def most(self, dual: Dual) -> FloatArray:
        """What tr(Qᵀ·N·Q) of a column is at most, shape (J,)."""
        return self.by_corner(dual)[1]

    def by_corner(self, dual: Dual) -> tuple[FloatArray, FloatArray]:
        """What each measurement adds at every corner of its box (J, n, c), with the reference that is best where all
        are at the first corner of theirs, and the sum of the largest, (J,).
        """
        poses, group = np.unique(self.pose, return_inverse=True)
        mixtures = self.sites.boxes.mixtures
        gram, shared = self.sites.quadratic(dual, self.size, poses)
        alone = ((mixtures @ gram[:, None]) * mixtures).sum(axis=3)
        if not self.sites.series:
            by_themselves = alone[group[:, None], self.boxes]
            return by_themselves, by_themselves.max(axis=2).sum(axis=1)
        added = np.empty((len(self.pose), self.size, mixtures.shape[1]))
        total = np.empty(len(self.pose))
        together = max(1, _AT_ONCE // (self.size * mixtures.shape[1] * mixtures.shape[2]))
        for start in range(0, len(self.pose), together):
            part = slice(start, start + together)
            at, boxes = group[part], self.boxes[part]
            centre = mixtures[boxes, 0].sum(axis=1)
            along = (shared[at] @ centre[..., None])[..., 0]
            added[part] = alone[at[:, None], boxes] - 2.0 * (mixtures[boxes] @ along[:, None, :, None])[..., 0]
            total[part] = added[part].max(axis=2).sum(axis=1) + (along * centre).sum(axis=1)
        return added, total

    def information(self, parameters: int) -> FloatArray:
        """N of the columns with the load at the first corner of every box, shape (J, q, q)."""
        maps = np.einsum("jnv,jvka->jnka", self.sites.boxes.mixtures[self.boxes, 0], self.sites.maps[self.pose])
        total = np.einsum("jnka,jnkb->jab", maps, maps)
        if not self.sites.series:
            return total
        q, k = parameters, maps.shape[-2]
        inner = np.linalg.inv(2.0 * np.eye(k) + total[:, q:, q:])
        found: FloatArray = total[:, :q, :q] - total[:, :q, q:] @ inner @ total[:, q:, :q]
        return found

    def measurements(self, column: int) -> FloatArray:
        """Those of a column, with the load at the first corner of every box, shape (n, g)."""
        found = self.sites.variables[np.full(self.size, self.pose[column]), 0]
        boxes = self.sites.boxes
        for one, box in zip(found, self.boxes[column], strict=True):
            one[boxes.loads.index] = boxes.outermost(int(box))
        return found

    def every_measurement(self) -> FloatArray | None:
        """The measurements (j, g) of the columns at all loads in their boxes; None where they are infinitely many."""
        pairs = np.stack([np.repeat(self.pose, self.size), self.boxes.ravel()], axis=1)
        found = [self.sites.variables[:0, 0]]
        for pose, box in np.unique(pairs, axis=0):
            loads = self.sites.boxes.loads_in(int(box))
            if loads is None:
                return None
            listed = np.repeat(self.sites.variables[[pose], 0], len(loads), axis=0)
            listed[:, self.sites.boxes.loads.index] = loads
            found.append(listed)
        return np.unique(np.concatenate(found), axis=0)

    def split(self, column: int, dual: Dual) -> "Columns | None":
        """A column in two, where its bound for Q is not that of the loads that stand for it; else None."""
        added = self.take(np.array([column])).by_corner(dual)[0][0]
        slack = added.max(axis=1) - added[:, 0]
        which = int(slack.argmax())
        halves = self.sites.boxes.split(int(self.boxes[column, which]), int(added[which].argmax()))
        if not halves:
            return None
        boxes = np.repeat(self.boxes[[column]], len(halves), axis=0)
        boxes[:, which] = halves
        return replace(self, pose=np.repeat(self.pose[column], len(halves)), boxes=boxes)


def sites_of(information: MeasurementInformation) -> Sites | str:
    """The poses of a problem, where they are finitely many; or why whole plans cannot be bounded over them."""
    problem = information.problem
    series = takes_series(information)
    if problem.noise.shared_reference and not series:
        return "measurements that share references are not whole series where information is not convex in the load"
    loads = LoadRange.of(information) if information.convex_in_load else LoadRange(np.zeros(0, dtype=np.int64), (), ())
    poses = enumerated(problem, loads.index)
    if poses is None:
        return "not all poses and loads can be listed"
    axes = len(problem.noise.axes)
    size = axes * (len(problem.loaded.scale) + len(problem.shared_errors) + axes)
    if len(poses) * len(loads.bits) * size > _MAPS:
        return f"the {len(poses)} poses are too many"
    variables = np.repeat(poses[:, None], len(loads.bits), axis=1)
    variables[..., loads.index] = [loads.variables(bits) for bits in loads.bits]
    flat = variables.reshape(-1, poses.shape[1])
    rows = SeriesInformation(information).reference_rows(flat) if series else information.rows(flat)
    return Sites(variables, rows.reshape(*variables.shape[:2], *rows.shape[1:]), Boxes(loads), series)


def columns_of(
    sites: Sites, count: int, dual: Dual, threshold: float, most: float, limit: float
) -> list[Columns] | str:
    """The columns of which a plan can be made that is better than one that is known; or why they are not listed.

    Args:
        sites: the poses.
        count: m.
        dual: a Q, by which columns are left out.
        threshold: the least Σ tr(QᵀNQ) of a plan that is better.
        most: the largest tr(QᵀNQ)/n of any column.
        limit: number of columns that may be looked at.
    """
    halves = np.array([sites.boxes.add(box) for box in sites.boxes.loads.halves()])
    lists = [halves[:, None]]
    if sites.series:
        multisets = Multisets(len(halves), count, len(sites.maps))
        lists = [halves[members] for members in multisets.members]
        n = multisets.longest + 1
        if n <= count:
            gains, interactions = quadratic(dual, sites.maps)
            if n * longer(gains, interactions(n), n).max() + (count - n) * most >= threshold:
                return f"series of {n} and more measurements are too many to be listed"
        sensitive = multisets.best(dual, sites.maps).bound
    else:
        sensitive = sites.quadratic(dual, 1, np.arange(len(sites.maps)))[0].diagonal(axis1=1, axis2=2).max(axis=1)
    # No plan with even one measurement at the other poses is better.
    everywhere = np.flatnonzero(sensitive + (count - 1) * most >= threshold)
    number = len(everywhere) * sum(len(members) for members in lists)
    if number > limit:
        return f"{number} series at {len(everywhere)} poses are too many for the time"
    found = []
    for members in lists:
        n, together, kept = (
            members.shape[1],
            max(1, 100_000 // len(members)),
            [Columns(sites, everywhere[:0], members[:0])],
        )
        for start in range(0, len(everywhere), together):
            poses = everywhere[start : start + together]
            columns = Columns(sites, np.repeat(poses, len(members)), np.tile(members, (len(poses), 1)))
            kept.append(columns.take(np.flatnonzero(columns.most(dual) + (count - n) * most >= threshold)))
        pose, boxes = (np.concatenate([getattr(part, name) for part in kept]) for name in ("pose", "boxes"))
        found.append(Columns(sites, pose, boxes))
    return found

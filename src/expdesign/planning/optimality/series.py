"""Information of whole series: measurements at one pose that share their reference reading (theory.md 10.6).

With the reference's reading ρ as a nuisance of its own, whose prior information is 2·I in whitened units, the readings
of a series are independent, and the information of n of them is the Schur complement

    N_s = Σ R_iᵀR_i − (Σ H_iᵀR_i)ᵀ·(2·I + Σ H_iᵀH_i)⁻¹·(Σ H_iᵀR_i) ,

so that n + 1 readings about their mean are what tells. For any Q, tr(QᵀN_sQ) = min_B Σ‖R_i·Q − H_i·B‖² + 2‖B‖².
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations_with_replacement
from math import comb

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.planning.optimality.weights import Dual

_ENTRIES = 4_000_000
"""Of arrays of series that are valued together."""


def sizes(series: FloatArray) -> IntArray:
    """Number of measurements of series (j, n, g), whose missing ones are NaN, shape (j,)."""
    found: IntArray = (~np.isnan(series[..., 0])).sum(axis=1)
    return found


@dataclass(frozen=True)
class BestSeries:
    """The most sensitive series at each of p poses.

    Attributes:
        values: tr(QᵀN_sQ)/n of the best series found, shape (p,).
        chosen: its measurements as indices of options, −1 for missing ones, shape (p, n).
        bound: what no series of up to m measurements at that pose exceeds, shape (p,).
    """

    values: FloatArray
    chosen: IntArray
    bound: FloatArray


class Multisets:
    """All ways to choose 1 … n of v options with repetition, as far as they can be listed.

    Args:
        options: v.
        measurements: m, the largest n that is asked for.
        poses: number of poses at which they are to be valued.
    """

    def __init__(self, options: int, measurements: int, poses: int) -> None:
        self.options, self.measurements = options, measurements
        self.members: list[IntArray] = []
        total = 0
        for n in range(1, measurements + 1):
            total += comb(options + n - 1, n)
            if n > 1 and total * max(options**2 * poses, 200) > 100 * _ENTRIES:
                break
            listed = list(combinations_with_replacement(range(options), n))
            self.members.append(np.array(listed, dtype=np.int64))

    @property
    def longest(self) -> int:
        """Largest n of which all are listed."""
        return len(self.members)

    @cached_property
    def counts(self) -> list[FloatArray]:
        """How often each option occurs, shape (s, v) for each n."""
        found: list[FloatArray] = []
        for members in self.members:
            counts = np.zeros((len(members), self.options))
            np.add.at(counts, (np.arange(len(members))[:, None], members), 1.0)
            found.append(counts)
        return found

    def best(self, dual: Dual, rows: FloatArray) -> BestSeries:
        """The best series at every pose, options with maps [R, H] (p, v, k, q + k), H the same for all of a pose and
        left out where no reference is shared.
        """
        largest = max(len(members) for members in self.members)
        together = max(1, _ENTRIES // max(largest, self.options**2))
        parts = [self._best(dual, part) for part in np.split(rows, range(together, len(rows), together))]
        return BestSeries(
            *(np.concatenate([getattr(part, name) for part in parts]) for name in ("values", "chosen", "bound"))
        )

    def _best(self, dual: Dual, rows: FloatArray) -> BestSeries:
        gains, interactions = quadratic(dual, rows)
        poses, shared = len(rows), rows.shape[-1] > len(dual.matrix)
        values = np.full(poses, -np.inf)
        chosen = np.full((poses, self.longest), -1, dtype=np.int64)
        for n, (members, counts) in enumerate(zip(self.members, self.counts, strict=True), start=1):
            found = gains @ counts.T / n
            if shared:
                pairs = (counts[:, :, None] * counts[:, None, :]).reshape(len(counts), -1)
                found -= interactions(n).reshape(poses, -1) @ pairs.T / n
            best = found.argmax(axis=1)
            value = found[np.arange(poses), best]
            better = value > values
            values = np.where(better, value, values)
            chosen[better] = -1
            chosen[better, :n] = members[best[better]]
        bound = values
        if self.longest < self.measurements:
            bound = np.maximum(values, longer(gains, interactions(self.longest + 1), self.longest + 1))
        return BestSeries(values, chosen, bound)


def quadratic(dual: Dual, rows: FloatArray) -> tuple[FloatArray, Callable[[int], FloatArray]]:
    """What series at p poses are worth: with counts c (v,) of the options, tr(QᵀN_sQ) = a·c − cᵀ·B_n·c.

    Args:
        dual: Q.
        rows: maps [R, H] of the options, shape (p, v, k, q + k), H the same for all options of a pose.

    Returns:
        a, shape (p, v), and B_n as a function of n = Σc, shape (p, v, v).
    """
    q = dual.matrix.shape[0]
    k = rows.shape[-1] - q
    products = rows[..., :q] @ dual.matrix
    whitener = rows[:, 0, :, q:]
    turned = (whitener.swapaxes(-1, -2)[:, None] @ products).reshape(*products.shape[:2], k, products.shape[-1])
    gram = whitener.swapaxes(-1, -2) @ whitener

    def interactions(n: int) -> FloatArray:
        inverse = np.linalg.inv(2.0 * np.eye(k) + n * gram)
        weighted = inverse[:, None] @ turned
        flat = (len(rows), rows.shape[1], -1)
        found: FloatArray = weighted.reshape(flat) @ turned.reshape(flat).swapaxes(-1, -2)
        return found

    gains: FloatArray = (products**2).sum(axis=(-2, -1))
    return gains, interactions


def longer(gains: FloatArray, interactions: FloatArray, n: int) -> FloatArray:
    """Bound (p,) on tr(QᵀN_sQ)/n' of series of n' ≥ n measurements, whose shares of the options need not be whole.

    a·p − n·pᵀB_n·p is concave in the shares p and falls with n; the bound is that of its tangents (Frank & Wolfe 1956).
    """
    shares = np.full(gains.shape, 1.0 / gains.shape[1])
    bound = np.full(len(gains), np.inf)
    everyone = np.arange(len(gains))
    for _ in range(60):
        along = n * (interactions @ shares[..., None])[..., 0]
        slope = gains - 2.0 * along
        value = ((gains - along) * shares).sum(axis=1)
        best = slope.argmax(axis=1)
        rise = slope[everyone, best] - (slope * shares).sum(axis=1)
        bound = np.minimum(bound, value + rise)
        direction = -shares
        direction[everyone, best] += 1.0
        curvature = n * np.einsum("pi,pij,pj->p", direction, interactions, direction)
        length = np.clip(rise / np.maximum(2.0 * curvature, 1e-300), 0.0, 1.0)
        shares = shares + length[:, None] * direction
    return bound

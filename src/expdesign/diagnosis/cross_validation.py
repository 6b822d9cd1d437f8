"""Which rows are left out together, whatever is judged by rows that were not fitted, and what they speak against.

Whether laws may be predicted with: blocks of rows that were left out have to be predicted better, and nearly all.

A law that takes much away in a few series and adds a little in all others lowers the left-out sum of squares, and is
still worse than the base model wherever the few do not come again. So the gain is judged block by block: blocks must be
better more often than not, and the mean fall of the logarithm of a block's mean square error must stand out of its
scatter over the blocks (a one-sided paired t test). Logarithms, because squares of a few blocks with large loads would
make any gain look uncertain, however sure it is.
"""

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
import pandas as pd
from scipy.special import stdtr

from expdesign.arrays import BoolArray, FloatArray, IntArray, rms
from expdesign.diagnosis.options import OPTIONS
from expdesign.estimation.fit import Data

Values = TypeVar("Values", IntArray, BoolArray)
STATION = "station"
"""Column of recordings that numbers groups of rows which were measured together (file-formats.md, Recordings)."""
_NOTHING = 1e-9


def blocks_of(sample: Data, most: int | None = None) -> IntArray:
    """Block of every row: stations where the recordings state them, else series, else consecutive rows, shape (N,).

    Rows of one station are alike, so that a law which only describes the rows it has seen shows in another station.

    Args:
        sample: the rows that count; the others belong to some block as well.
        most: how many blocks there are, each of several groups; one for every group if left out.
    """
    fewest = OPTIONS.groups if most is None else most
    for groups in (_stations(sample), sample.rows.series):
        if groups is not None and len(np.unique(groups[sample.counts])) >= fewest:
            ranks = np.unique(groups, return_inverse=True)[1].astype(np.int64)
            return ranks if most is None else ranks % most
    before = np.maximum(np.cumsum(sample.counts) - 1, 0)
    return np.asarray(before * fewest // max(int(sample.counts.sum()), 1), dtype=np.int64)


def last_part(sample: Data, parts: int) -> tuple[BoolArray, BoolArray]:
    """The last of so many parts of the rows that count, whole series where there are several, and those before it.

    What depends on time or history is judged by what came later: between rows that it has seen, anything smooth
    predicts.
    """
    rows, series = np.flatnonzero(sample.counts), sample.rows.series
    last: BoolArray = np.zeros(len(series), dtype=bool)
    last[rows[-(len(rows) // parts) :] if len(rows) >= parts else []] = True
    whole: BoolArray = sample.counts & np.isin(series, np.unique(series[last]))
    before: BoolArray = sample.counts & ~whole
    if before.sum() < (1.0 - 2.0 / parts) * len(rows):
        whole, before = last, sample.counts & ~last
    return whole, before


def readings_of(values: Values, sample: Data) -> Values:
    """Values of rows (N,) for every reading that counts, shape (M,)."""
    found: Values = np.repeat(values[sample.counts], len(sample.recordings.axes))
    return found


def _stations(sample: Data) -> FloatArray | None:
    extra = sample.recordings.extra
    if STATION not in extra.columns:
        return None
    numbers = pd.to_numeric(extra[STATION], errors="coerce").to_numpy(dtype=float)
    return numbers if np.isfinite(numbers).all() else None


@dataclass(frozen=True)
class LeftOut:
    """Errors of readings predicted without the block that they belong to, in standard deviations of the noise.

    Attributes:
        before, after: without and with laws, shape (M,).
        blocks: of every reading, shape (M,).
    """

    before: FloatArray
    after: FloatArray
    blocks: IntArray

    def widened(self, variances: FloatArray, priors: FloatArray, form: float | None = None) -> tuple[float, float]:
        """Factor k ≥ 1 on the variance by weights, and share q of the laws' prior variance that stays beside it.

        A law is its kernel's and what the kernel lacks. The posterior variance v − 1 of the first shrinks with the
        rows; the second is no smaller between many rows than between few, and large where the law may be large: q of
        its prior variance p. With e the errors of blocks that were left out both are the posterior means under

            e_i ~ N(0, 1 + k·(v_i − 1) + q·p_i),   ln k ~ |N(0, 1)|,   ln q uniform from ln 10⁻⁶ to 0,

        so that blocks which tell little leave a law no surer than nature usually lets it be. Of named physics p is the
        square of what it does, and the form is wrong by a share √q ~ |N(0, form²)| of that.

        Args:
            variances: v of `after`, 1 of which is noise, shape (M,).
            priors: p, the prior variance by all laws, shape (M,).
            form: what √q usually is for named physics; None for laws.
        """
        own, squares = np.maximum(variances - 1.0, 0.0), self.after**2
        logs, shares = np.linspace(0.0, np.log(OPTIONS.most_inflated), 14), np.logspace(-6.0, 0.0, 19)
        fit = np.empty((len(logs), len(shares)))
        for i, k in enumerate(np.exp(logs)):
            total = 1.0 + k * own + shares[:, None] * priors
            fit[i] = -0.5 * (np.log(total) + squares / total).sum(axis=1) - 0.5 * logs[i] ** 2
        if form is not None:
            fit += 0.5 * np.log(shares) - 0.5 * shares / form**2  # as a density of ln q
        weights = np.exp(fit - fit.max())
        weights[[0, -1]] *= 0.5  # trapezoids of ln k; shares are a list, alike beforehand
        weights /= weights.sum()
        return float(weights.sum(axis=1) @ np.exp(logs)), float(weights.sum(axis=0) @ shares)

    @property
    def rms_before(self) -> float:
        """RMS without laws."""
        return rms(self.before)

    @property
    def rms_after(self) -> float:
        """RMS with laws."""
        return rms(self.after)

    @property
    def p_value(self) -> float:
        """That the mean fall of the logarithm is none (paired t test, one-sided)."""
        before, after = self._squares(self.before), self._squares(self.after)
        gains = np.log(np.maximum(before, _NOTHING) / np.maximum(after, _NOTHING))
        scatter = float(gains.std(ddof=1)) / np.sqrt(len(gains)) if len(gains) > 1 else float("inf")
        if scatter == 0.0:
            return 0.0 if gains.mean() > 0.0 else 1.0
        return float(stdtr(max(len(gains) - 1, 1), -float(gains.mean()) / scatter))

    @property
    def better(self) -> float:
        """Share of the blocks with a visible change that are predicted better; 0 where there is none."""
        gains = self._squares(self.before) - self._squares(self.after)
        visible = gains[np.abs(gains) > OPTIONS.listed]
        return float((visible > 0.0).mean()) if visible.size else 0.0

    @property
    def doubt(self) -> str:
        """Why the base model predicts instead; empty where laws may."""
        left = max(self.rms_after**2 - 1.0, 0.0) / max(self.rms_before**2 - 1.0, 1e-9)
        if left > OPTIONS.half:
            return f"they leave {100.0 * left:.0f} % of the excess of left-out rows"
        if self.better < (OPTIONS.half if left <= 1.0 - OPTIONS.nearly else OPTIONS.nearly):
            return f"only {100.0 * self.better:.0f} % of the blocks that were left out are predicted better"
        if self.p_value > OPTIONS.gain_level:
            return f"the gain does not stand out of its scatter over blocks that were left out (p = {self.p_value:.2g})"
        return ""

    def _squares(self, errors: FloatArray) -> FloatArray:
        """Mean square error by block."""
        return np.array([(errors[self.blocks == block] ** 2).mean() for block in np.unique(self.blocks)])

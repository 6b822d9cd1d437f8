"""The next measurements: which would most improve the accuracy at the targets, given what is known (theory.md 10.3).

With the information R₀ᵀR₀ = P₀⁻¹ of the recordings, measurements j added to them give P = (P₀⁻¹ + Σ A_jᵀV_j⁻¹A_j)⁻¹,
and the error to expect after compensation is, as for the criterion `total`,

    total² = Σ_t w_t tr(W_t A_D (P + P·(B·Bᵀ + N)·P) A_Dᵀ) / Σ_t w_t,

where B = Σ A_iᵀV_i⁻¹D_iL_i collects the load errors that all measurements share and N = Σ A_iᵀV_i⁻¹D_iΣ_iD_iᵀV_i⁻¹A_i
those that each has for itself. All of it is a sum over measurements, so that thousands of candidates cost one batch.
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import BoolArray, FloatArray
from expdesign.criteria.target_variances import GivenVariances
from expdesign.criteria.targets import Targets
from expdesign.criteria.total import Total
from expdesign.design.problem import DesignProblem
from expdesign.design.start import reachable_measurements

CANDIDATES = 4000
_FEW = 8
"""Parameters up to which as many candidates are drawn; more of them cost more each, and are drawn fewer times."""
_RANK = 1e-9
"""Singular values below this fraction of the largest are zero."""
_LOST = 1e-6
"""Part of a target's row that may lie along lost directions, as rounding."""
_ROUNDS = 10
_BROOD, _STEPS = 200, 40


@dataclass(frozen=True)
class Knowledge:
    """What measurements say, with any batch dimensions in front; sums of measurements are sums of `Knowledge`.

    Attributes:
        root: rows G·A (in units of 1/apK) of the whitened readings, shape (..., r, p).
        shared: B, shape (..., p, d).
        own: N, shape (..., p, p).
    """

    root: FloatArray
    shared: FloatArray
    own: FloatArray

    def plus(self, other: "Knowledge") -> "Knowledge":
        """Both together; the rows are reduced to a triangle, which keeps the condition number."""
        batch = np.broadcast_shapes(self.root.shape[:-2], other.root.shape[:-2])
        rows = [np.broadcast_to(part, (*batch, *part.shape[-2:])) for part in (self.root, other.root)]
        stacked = np.concatenate(rows, axis=-2)
        reduced: FloatArray = stacked
        if stacked.shape[-2] > stacked.shape[-1]:
            reduced = np.asarray(np.linalg.qr(stacked, mode="r"))
        return Knowledge(reduced, self.shared + other.shared, self.own + other.own)

    def part(self, index: int) -> "Knowledge":
        """One member of a batch."""
        return Knowledge(self.root[index], self.shared[index], self.own[index])


def knowledge_of(problem: DesignProblem, decisions: FloatArray) -> Knowledge:
    """What each of the measurements (c, g) of the design space would say by itself, batch shape (c,)."""
    rows, errors = problem.whitened(*problem.space.decode(decisions))
    return _with_errors(rows * problem.loaded.scale, errors, problem.shared_errors)


def _with_errors(root: FloatArray, errors: FloatArray, shared: BoolArray) -> Knowledge:
    """Knowledge from whitened rows (..., r, p) and whitened deflections per load error (..., r, d)."""
    seen = root.swapaxes(-1, -2) @ errors
    own = seen[..., ~shared]
    return Knowledge(root, seen[..., shared], own @ own.swapaxes(-1, -2))


def together(parts: list[Knowledge]) -> Knowledge:
    """The sum of several."""
    total = parts[0]
    for part in parts[1:]:
        total = total.plus(part)
    return total


def expected_total(knowledge: Knowledge, targets: Targets, scale: FloatArray) -> FloatArray:
    """√total² of a batch, in tolerances, shape (...); infinite where a target depends on parameters not determined.

    Args:
        knowledge: of all measurements.
        targets: where accuracy is wanted.
        scale: units of the parameters in `knowledge`, shape (p,).
    """
    root = knowledge.root
    missing = root.shape[-1] - root.shape[-2]
    if missing > 0:
        root = np.concatenate([root, np.zeros((*root.shape[:-2], missing, root.shape[-1]))], axis=-2)
    _, singular, right = np.linalg.svd(root, full_matrices=False)
    kept = singular > _RANK * singular[..., :1]
    inverse = right.swapaxes(-1, -2) / np.where(kept, singular, np.inf)[..., None, :]
    covariance = inverse @ inverse.swapaxes(-1, -2)
    biased = covariance @ knowledge.shared
    load_errors = biased @ biased.swapaxes(-1, -2) + covariance @ knowledge.own @ covariance
    rows = targets.observation * scale
    # What a target needs and the measurements leave out: its part along the directions that are lost.
    lost = np.linalg.norm(np.einsum("tip,...kp->...tik", rows, right * ~kept[..., None]), axis=-1)
    usable = ~((lost > _LOST * np.linalg.norm(rows, axis=-1)) & (targets.importance > 0.0)).any(axis=(-2, -1))
    noise, force = (np.einsum("tip,...pq,tiq->...ti", rows, part, rows) for part in (covariance, load_errors))
    total = Total().values(GivenVariances(targets, noise, force))
    result: FloatArray = np.where(usable, total, np.inf)
    return result


@dataclass(frozen=True)
class NextMeasurements:
    """Measurements to add, and what they promise.

    Attributes:
        decisions: of the design space, shape (k, g).
        before: expected total error of the recordings alone, in tolerances (infinite where undetermined).
        after: of the recordings with the first 1, 2, ... k of the measurements, shape (k,).
    """

    decisions: FloatArray
    before: float
    after: FloatArray


def next_measurements(
    problem: DesignProblem, known: Knowledge, *, count: int, accuracy: float | None, seed: int
) -> NextMeasurements:
    """Up to `count` measurements that most improve the accuracy at the targets, in the order of their use.

    One at a time from a sample of the design space (greedy), then each in turn replaced by the best candidate for its
    place until none is better (exchange), then refined in their continuous variables.

    Args:
        problem: what can be measured, and where accuracy is wanted.
        known: what the recordings say.
        count: the most that may be added.
        accuracy: total error (in tolerances) at which to stop adding; None to add all.
        seed: of the sample.

    Raises:
        InfeasibleError: no measurement is within the robot's limits.
    """
    generator = np.random.default_rng(seed)
    pool = reachable_measurements(problem, round(CANDIDATES * _fewer(problem)), generator)
    candidates = knowledge_of(problem, pool)
    scale, targets = problem.loaded.scale, problem.targets

    def totals(base: Knowledge, added: Knowledge) -> FloatArray:
        return expected_total(base.plus(added), targets, scale)

    before = float(expected_total(known, targets, scale))
    chosen: list[FloatArray] = []
    base = known
    while len(chosen) < count:
        scores = totals(base, candidates)
        if not np.isfinite(scores).any():
            # Too little is known for any single one to determine all: take what adds most information.
            scores = -_information(base.plus(candidates))
        best = int(np.argmin(scores))
        chosen.append(pool[best])
        base = base.plus(candidates.part(best))
        if accuracy is not None and float(expected_total(base, targets, scale)) <= accuracy:
            break
    decisions = _exchanged(problem, known, np.array(chosen), pool, candidates, generator)
    decisions = _ordered(problem, known, decisions)
    after, base = [], known
    for row in decisions:
        base = base.plus(knowledge_of(problem, row[None]).part(0))
        after.append(float(expected_total(base, targets, scale)))
        if accuracy is not None and after[-1] <= accuracy:
            # Exchange and refinement may reach with fewer what the first choice needed more for.
            break
    return NextMeasurements(decisions[: len(after)], before, np.array(after))


def _fewer(problem: DesignProblem) -> float:
    """Share of the usual number of candidates."""
    return min(1.0, _FEW / len(problem.loaded.scale))


def _information(knowledge: Knowledge) -> FloatArray:
    """Product of the non-zero singular values, in logarithms, of a batch; more rank comes first."""
    singular = np.linalg.svd(knowledge.root, compute_uv=False)
    kept = singular > 1e-9 * singular[..., :1]
    logs: FloatArray = np.where(kept, np.log(np.where(kept, singular, 1.0)) + 1e3, 0.0).sum(axis=-1)
    return logs


def _exchanged(
    problem: DesignProblem,
    known: Knowledge,
    decisions: FloatArray,
    pool: FloatArray,
    candidates: Knowledge,
    generator: np.random.Generator,
) -> FloatArray:
    """Measurements (k, g) after exchange with the pool and refinement of the continuous variables."""
    scale, targets, space = problem.loaded.scale, problem.targets, problem.space
    robot = problem.loaded.robot
    decisions = decisions.copy()

    def others(place: int) -> Knowledge:
        rest = np.delete(decisions, place, axis=0)
        if len(rest) == 0:
            return known
        each = knowledge_of(problem, rest)
        return together([known, *(each.part(i) for i in range(len(rest)))])

    def score(base: Knowledge, place: int) -> float:
        return float(expected_total(base.plus(knowledge_of(problem, decisions[place][None]).part(0)), targets, scale))

    for _ in range(_ROUNDS if len(decisions) > 1 else 1):
        improved = False
        for place in range(len(decisions)):
            base = others(place)
            now = score(base, place)
            scores = expected_total(base.plus(candidates), targets, scale)
            best = int(np.argmin(scores))
            if scores[best] < now * (1.0 - 1e-9):
                decisions[place], improved = pool[best], True
        if not improved:
            break
    span = (space.upper - space.lower) * ~space.discrete
    brood_size = round(_BROOD * _fewer(problem))
    for place in range(len(decisions)):
        base, size = others(place), 0.1
        now = score(base, place)
        for _ in range(_STEPS if span.any() else 0):
            moves = generator.standard_normal((brood_size, space.decisions)) * size * span
            brood = np.clip(decisions[place] + moves, space.lower, space.upper)
            brood = brood[robot.usable(space.decode(brood)[0])]
            scores = expected_total(base.plus(knowledge_of(problem, brood)), targets, scale)
            size *= 1.2 if len(brood) and (scores < now).mean() > 0.1 else 0.7
            if len(brood) and scores.min() < now:
                decisions[place], now = brood[int(np.argmin(scores))], float(scores.min())
    return decisions


def _ordered(problem: DesignProblem, known: Knowledge, decisions: FloatArray) -> FloatArray:
    """The same measurements, the most useful first."""
    scale, targets = problem.loaded.scale, problem.targets
    left, ordered, base = list(range(len(decisions))), [], known
    each = knowledge_of(problem, decisions)
    while left:
        scores = [float(expected_total(base.plus(each.part(i)), targets, scale)) for i in left]
        best = left.pop(int(np.argmin(scores)))
        ordered.append(best)
        base = base.plus(each.part(best))
    return decisions[ordered]

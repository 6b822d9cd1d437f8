"""Many small effects at once: start with everything, and let the evidence switch groups off.

Greedy growth ends early on a machine in which ten things are a little wrong. Here all effects are there from the start,
with prior deviations of physical size times one factor per group, and MacKay's fixed point (1992, section 4) sets the
factors and the noise on the linearised problem:

    γ_g = Σ_(i in g) (1 − C_ii/d_i²),   f_g² = Σ (θ_i/δ_i)²/γ_g,   s² = |r|²/(M − Σγ − rank of what has no factor),

d_i = f_g·δ_i being the prior deviation of parameter i and C the posterior covariance. The problem is linearised again
after every damped Gauss-Newton step. Where the data do not identify a group its factor would grow without end: it is
held at `MOST`.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy.linalg import cho_solve, solve_triangular
from scipy.linalg.lapack import dtrtri

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.chain.ports.guard import LeftOut

MOST = 3.0
"""Largest factor on deviations of physical size."""
GONE = 0.02
"""Factor below which a group is not there."""
_LEAST = 1e-3
_ROUNDS, _FIXED = 12, 30
_SETTLED = 1e-2
_HELD = 20
"""Times that parameters are held at their bounds."""

_ABSENT = 1e-8
"""Factor on the deviations of what is left out."""
_ALONE = 1.0 + 1e-9
"""Diagonal of I − H, so that a reading that nothing else predicts leaves it regular."""
_DEAD = 1e-10
"""Share of a parameter's prior precision below which the readings say nothing of it."""
BETTER = 0.995
"""Factor on the left-out error that a group has to bring, or it is left out; likewise what series share as noise."""

Linearised = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
"""Whitened residuals (M,) and derivatives of the prediction (M, p) at parameters (p,)."""


@dataclass(frozen=True)
class Priors:
    """What is known beforehand.

    Attributes:
        mean, deviation: of every parameter, shape (p,); infinite where nothing is known.
        group: of every parameter, shape (p,); −1 where the deviation stays as it is.
        low, high: bounds, shape (p,).
    """

    mean: FloatArray
    deviation: FloatArray
    group: IntArray
    low: FloatArray
    high: FloatArray


@dataclass(frozen=True)
class Sizes:
    """What evidence says of the sizes.

    Attributes:
        factors: on the deviations of the groups, shape (G,).
        noise: standard deviation of the whitened readings.
        determined: γ_g, how many parameters of each group the data determine, shape (G,).
    """

    factors: FloatArray
    noise: float
    determined: FloatArray = field(default_factory=lambda: np.zeros(0))


@dataclass(frozen=True)
class Linear:
    """A linear problem y = A·θ + e.

    Attributes:
        readings: y as they are with all parameters at their means, whitened, shape (M,).
        slopes: A, shape (M, p).
    """

    readings: FloatArray
    slopes: FloatArray

    @cached_property
    def gram(self) -> FloatArray:
        """AᵀA, shape (p, p)."""
        return self.slopes.T @ self.slopes

    @cached_property
    def right(self) -> FloatArray:
        """Aᵀy, shape (p,)."""
        return self.slopes.T @ self.readings


@dataclass(frozen=True)
class Everything:
    """All effects, fitted together.

    Attributes:
        values: shape (p,).
        covariance: with the noise as it was learnt, shape (p, p).
        factors: of the groups.
        determined: γ_g, how many parameters of each group the data determine.
        noise: standard deviation of the whitened residuals.
        residuals, slopes: at the values, shapes (M,) and (M, p).
    """

    values: FloatArray
    covariance: FloatArray
    factors: FloatArray
    determined: FloatArray
    noise: float
    residuals: FloatArray
    slopes: FloatArray

    def known_as(self, priors: Priors) -> "Everything":
        """The same values, as certain as other priors make them."""
        precision = prior_precision(priors, self.factors, self.noise)
        return replace(self, covariance=self.noise**2 * posterior_covariance(self.slopes.T @ self.slopes, precision))

    def without(self, rows: BoolArray, priors: Priors) -> "Everything":
        """The linear problem solved with fewer readings, `rows` (M,) being true for those that go, and sized anew."""
        readings = (self.residuals + self.slopes @ (self.values - priors.mean))[~rows]
        fewer = replace(self, residuals=self.residuals[~rows], slopes=self.slopes[~rows])
        sizes = sized(Linear(readings, fewer.slopes), priors, Sizes(self.factors, self.noise))
        return _again(replace(fewer, factors=sizes.factors, noise=sizes.noise), priors)

    def left_out(self, blocks: IntArray, priors: Priors) -> FloatArray:
        """Errors of readings predicted without their block, e_B = (I − H_BB)⁻¹·r_B of the linear problem, (M,)."""
        live, lower = _factored(self.slopes.T @ self.slopes, prior_precision(priors, self.factors, self.noise))
        root = solve_triangular(lower, self.slopes[:, live].T, lower=True, check_finite=False).T
        errors = np.empty_like(self.residuals)
        for block in np.unique(blocks):
            inside = np.flatnonzero(blocks == block)
            own = root[inside]
            errors[inside] = _left_out(own, self.residuals[inside])
        return errors


def everything(linearised: Linearised, priors: Priors, start: FloatArray, *, known_noise: bool = False) -> Everything:
    """All effects at once; see the module.

    Args:
        linearised: residuals and derivatives.
        priors: what is known beforehand.
        start: parameters to start from, shape (p,).
        known_noise: whether the noise is 1 and must not grow.
    """
    sizes = Sizes(np.full(int(priors.group.max()) + 1, 0.3), 1.0 if known_noise else 3.0)
    values = np.clip(start, priors.low, priors.high)
    residuals, slopes = linearised(values)
    for _ in range(_ROUNDS):
        problem = Linear(residuals + slopes @ (values - priors.mean), slopes)
        sizes = sized(problem, priors, sizes, known_noise=known_noise)
        precision = prior_precision(priors, sizes.factors, sizes.noise)
        target = priors.mean + _bounded(_regular(problem.gram, precision), problem.right, priors)
        cost = _cost(residuals, values, priors, precision)
        share, moved = 1.0, False
        while share > 1e-3:
            trial = values + share * (target - values)
            fresh, steeper = linearised(trial)
            lower = _cost(fresh, trial, priors, precision)
            if np.isfinite(lower) and lower <= cost * (1.0 + 1e-12):
                moved = cost - lower > 1e-4 * cost
                values, residuals, slopes, cost = trial, fresh, steeper, lower
                break
            share *= 0.5
        if not moved:
            break
    precision = prior_precision(priors, sizes.factors, sizes.noise)
    covariance = sizes.noise**2 * posterior_covariance(slopes.T @ slopes, precision)
    return Everything(values, covariance, sizes.factors, sizes.determined, sizes.noise, residuals, slopes)


def sized(problem: Linear, priors: Priors, start: Sizes, *, known_noise: bool = False) -> Sizes:
    """MacKay's fixed point for the factors of the groups and the noise of a linear problem; see the module.

    Args:
        problem: linearised.
        priors: what is known beforehand.
        start: sizes to start from.
        known_noise: whether the noise is as in `start`.
    """
    factors, noise, determined = start.factors.copy(), start.noise, np.zeros(len(start.factors))
    groups = [priors.group == group for group in range(len(factors))]
    for _ in range(_FIXED):
        before = factors.copy()
        precision = prior_precision(priors, factors, noise)
        step, variances = _posterior(problem.gram, problem.right, precision)
        gamma = 1.0 - variances * precision
        sizes = step / priors.deviation
        for group, own in enumerate(groups):
            if not own.any():
                factors[group], determined[group] = _LEAST, 0.0
                continue
            determined[group] = max(float(gamma[own].sum()), 1e-9)
            factors[group] = np.clip(np.sqrt(float((sizes[own] ** 2).sum()) / determined[group]), _LEAST, MOST)
        if not known_noise:
            left = problem.readings - problem.slopes @ step
            noise = float(np.sqrt(left @ left / max(len(left) - gamma.sum(), 1.0)))
        if np.abs(np.log(np.maximum(factors, GONE) / np.maximum(before, GONE))).max(initial=0.0) < _SETTLED:
            break
    return Sizes(factors, noise, determined)


def log_evidence(problem: Linear, priors: Priors, sizes: Sizes) -> float:
    """Log of the marginal likelihood of the readings, up to a constant that depends on the flat priors alone."""
    precision = prior_precision(priors, sizes.factors, sizes.noise)
    live, lower = _factored(problem.gram, precision)
    reduced = solve_triangular(lower, problem.right[live], lower=True, check_finite=False)
    proper = live & (precision > 0.0)
    volume = 2.0 * float(np.log(lower.diagonal()).sum()) - float(np.log(precision[proper]).sum())
    scatter = float(problem.readings @ problem.readings - reduced @ reduced) / sizes.noise**2
    freedom = len(problem.readings) - int((live & ~proper).sum())
    return -0.5 * (scatter + volume + 2.0 * freedom * float(np.log(sizes.noise)))


def chosen_groups(
    linearised: Linearised, priors: Priors, start: FloatArray, blocks: IntArray, *, rounds: int = 2
) -> tuple[Everything, Priors]:
    """Everything, less the groups that evidence switches off or without which left-out blocks are predicted better.

    Where rows are alike evidence counts them all as independent, and keeps what only describes the blocks that were
    seen. Groups are left out one at a time on the linearised problem with the other factors as they are, the most
    harmful first, and the rest is fitted again.

    Args:
        linearised: residuals and derivatives.
        priors: what is known beforehand.
        start: parameters to start from, shape (p,).
        blocks: block of every reading, shape (M,).
        rounds: of linearising and choosing.
    """
    found = everything(linearised, priors, start)
    for _ in range(rounds):
        current = priors
        for group in np.unique(priors.group[priors.group >= 0]).tolist():
            if found.factors[group] <= GONE:
                current = without_group(current, group)
        error = _rms(found.left_out(blocks, current))
        while len(groups := np.unique(current.group[current.group >= 0])) > 1:
            trials = []
            for group in groups.tolist():
                smaller = without_group(current, group)
                trials.append((_rms(_again(found, smaller).left_out(blocks, smaller)), group, smaller))
            least = min(trials, key=lambda item: item[0])
            if least[0] * BETTER > error:
                break
            error, _, current = least
        if (current.group == priors.group).all():
            break
        gone = (priors.group >= 0) & (current.group < 0)
        priors = current
        found = everything(linearised, priors, np.where(gone, priors.mean, found.values))
    return found, priors


def group_gains(found: Everything, priors: Priors, blocks: IntArray) -> dict[int, float]:
    """For every group the p-value that left-out blocks are predicted no better with it (`guard.LeftOut`)."""
    after = found.left_out(blocks, priors)
    gains = {}
    for group in np.unique(priors.group[priors.group >= 0]).tolist():
        smaller = without_group(priors, group)
        gains[group] = LeftOut(_again(found, smaller).left_out(blocks, smaller), after, blocks).p_value
    return gains


def few_suffice(found: Everything, priors: Priors, blocks: IntArray, *, most: int = 2, within: float = 1.15) -> bool:
    """Whether one or two groups alone predict left-out blocks nearly as well as all do together.

    Then little is wrong with the machine, and to name it is the better way. Groups are added one at a time to the
    linearised problem, each time the one with the least left-out error.
    """
    goal = within * max(_rms(found.left_out(blocks, priors)), found.noise)
    current = priors
    every = np.unique(priors.group[priors.group >= 0]).tolist()
    for group in every:
        current = without_group(current, group)
    for _ in range(min(most, len(every))):
        trials = []
        for group in every:
            own = priors.group == group
            more = Priors(
                priors.mean, np.where(own, priors.deviation, current.deviation), np.where(own, group, current.group),
                priors.low, priors.high,
            )  # fmt: skip
            trials.append((_rms(_again(found, more).left_out(blocks, more)), group, more))
        error, group, current = min(trials, key=lambda item: item[0])
        every.remove(group)
        if error <= goal:
            return True
    return False


def _again(found: Everything, priors: Priors) -> Everything:
    """The linearised problem solved with other groups, factors and noise as they are."""
    precision = prior_precision(priors, found.factors, found.noise)
    readings = found.residuals + found.slopes @ (found.values - priors.mean)
    gram, right = found.slopes.T @ found.slopes, found.slopes.T @ readings
    (live, lower), step = _factored(gram, precision), np.zeros_like(right)
    step[live] = cho_solve((lower, True), right[live])
    return replace(found, values=priors.mean + step, residuals=readings - found.slopes @ step)


def _left_out(root: FloatArray, residuals: FloatArray) -> FloatArray:
    """(I − R·Rᵀ)⁻¹·r of a block (n, p), by the smaller of both matrices (Woodbury's identity)."""
    rows, parameters = root.shape
    if rows <= parameters:
        found: FloatArray = np.linalg.solve(_ALONE * np.eye(rows) - root @ root.T, residuals)
        return found
    inner = np.linalg.solve(_ALONE * np.eye(parameters) - root.T @ root, root.T @ residuals)
    return (residuals + root @ inner) / _ALONE


def _factored(gram: FloatArray, precision: FloatArray) -> tuple[BoolArray, FloatArray]:
    """Which parameters the readings move at all, shape (p,), and L with G + P = L·Lᵀ of these.

    Of the others, held beforehand, nothing is learnt. Columns in different units make the matrix look ill-conditioned;
    Cholesky's factors do not mind the scaling.
    """
    live: BoolArray = gram.diagonal() > _DEAD * precision
    return live, np.linalg.cholesky(_regular(gram[np.ix_(live, live)], precision[live]))


def _posterior(gram: FloatArray, right: FloatArray, precision: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(G + P)⁻¹·b and the diagonal of (G + P)⁻¹, both (p,), from L⁻¹ with G + P = L·Lᵀ."""
    live, lower = _factored(gram, precision)
    root, _ = dtrtri(lower, lower=1)
    step, variances = np.zeros_like(right), 1.0 / np.where(live, 1.0, np.maximum(precision, 1e-300))
    step[live], variances[live] = root.T @ (root @ right[live]), (root**2).sum(axis=0)
    return step, variances


def posterior_covariance(gram: FloatArray, precision: FloatArray) -> FloatArray:
    """(G + P)⁻¹, shape (p, p), as L⁻ᵀ·L⁻¹: symmetric to the last bit and positive semidefinite however ill-conditioned.

    Infinite on the diagonal where neither the readings nor anything beforehand says something of a parameter.

    Args:
        gram: G, products of the derivatives, shape (p, p).
        precision: diagonal of P, shape (p,).
    """
    live, lower = _factored(gram, precision)
    root, _ = dtrtri(lower, lower=1)
    with np.errstate(divide="ignore", over="ignore"):
        covariance: FloatArray = np.diag(np.where(live, 0.0, 1.0 / precision))
    covariance[np.ix_(live, live)] = root.T @ root
    return covariance


def _bounded(regular: FloatArray, right: FloatArray, priors: Priors) -> FloatArray:
    """Solution of regular·z = right within the bounds: what leaves them is held there, and the rest is solved again.

    To clip a solution instead would leave the others where they made up for what is clipped.
    """
    low, high = priors.low - priors.mean, priors.high - priors.mean
    solution: FloatArray = np.linalg.solve(regular, right)
    free = np.ones(len(right), dtype=bool)
    for _ in range(_HELD):
        beyond = free & ((solution < low) | (solution > high))
        if not beyond.any():
            break
        free &= ~beyond
        solution[beyond] = np.clip(solution[beyond], low[beyond], high[beyond])
        rest = right[free] - regular[np.ix_(free, ~free)] @ solution[~free]
        solution[free] = np.linalg.solve(regular[np.ix_(free, free)], rest)
    return np.clip(solution, low, high)


def without_group(priors: Priors, group: int) -> Priors:
    """The same with one group held at what it is known to be beforehand."""
    own = priors.group == group
    deviation = np.where(own, _ABSENT * priors.deviation, priors.deviation)
    return Priors(priors.mean, deviation, np.where(own, -1, priors.group), priors.low, priors.high)


def _rms(errors: FloatArray) -> float:
    return float(np.sqrt((errors**2).mean()))


def prior_precision(priors: Priors, factors: FloatArray, noise: float) -> FloatArray:
    """Prior precisions in units of the noise, shape (p,)."""
    # Where evidence has switched every group off there are no factors.
    scale = np.where(priors.group >= 0, np.append(factors, 1.0)[priors.group], 1.0)
    precision: FloatArray = (noise / (scale * priors.deviation)) ** 2
    return precision


def _cost(residuals: FloatArray, values: FloatArray, priors: Priors, precision: FloatArray) -> float:
    return float(residuals @ residuals + ((values - priors.mean) ** 2 * precision).sum())


def _regular(gram: FloatArray, precision: FloatArray) -> FloatArray:
    """G + P with a rounding's worth added to the diagonal."""
    matrix, diagonal = gram.copy(), gram.diagonal() + precision
    np.fill_diagonal(matrix, diagonal + 1e-12 * np.maximum(diagonal, 1e-300))
    return matrix

"""The interior-point method for many quadratic programs: optimality conditions, and an independent solver."""

import numpy as np

from expdesign.planning.optimality.quadratic import Programs, solve

BATCH, VARIABLES, PIECES, LIMITS = 5, 12, 3, 6


def random_programs(seed: int) -> Programs:
    generator = np.random.default_rng(seed)
    n = VARIABLES
    root = generator.normal(size=(BATCH, n, n)) / np.sqrt(n)
    level = np.broadcast_to(np.arange(PIECES + LIMITS) < PIECES, (BATCH, PIECES + LIMITS)).astype(float)
    pieces, limits = 0.1 * generator.normal(size=(BATCH, PIECES)), generator.uniform(-0.5, 0.05, (BATCH, LIMITS))
    return Programs(
        hessian=root @ root.swapaxes(1, 2) + 0.1 * np.eye(n),
        values=np.concatenate([pieces, limits], axis=1),
        rows=generator.normal(size=(BATCH, PIECES + LIMITS, n)),
        level=level,
        penalty=np.where(level > 0.0, 2.0, 50.0),
        low=-generator.uniform(0.1, 1.0, (BATCH, n)),
        high=generator.uniform(0.1, 1.0, (BATCH, n)),
    )


def test_solutions_satisfy_the_optimality_conditions() -> None:
    q = random_programs(1)
    d, multipliers = solve(q)
    assert ((d > q.low) & (d < q.high)).all()
    np.testing.assert_allclose(multipliers[:, :PIECES].sum(axis=1), 1.0, atol=1e-8)
    slope = np.einsum("bnk,bk->bn", q.hessian, d) + np.einsum("brn,br->bn", q.rows, multipliers)
    inside = np.minimum(d - q.low, q.high - d) > 1e-5
    assert inside.any()
    assert np.abs(slope[inside]).max() < 1e-5
    assert (slope[d - q.low < 1e-7] > 0.0).all()
    assert (slope[q.high - d < 1e-7] < 0.0).all()
    limits = (q.values + np.einsum("brn,bn->br", q.rows, d))[:, PIECES:]
    assert limits.max() < 1e-6
    assert np.abs(limits[multipliers[:, PIECES:] > 1e-4]).max() < 1e-6


def test_limits_that_cannot_be_kept_are_broken_as_little_as_possible() -> None:
    q = random_programs(3)
    impossible = Programs(**{**vars(q), "values": np.where(q.level > 0.0, q.values, 100.0)})
    assert np.isfinite(solve(impossible)[0]).all()

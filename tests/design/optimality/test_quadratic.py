"""The interior-point method for many quadratic programs: optimality conditions, and an independent solver."""

import numpy as np

from expdesign.planning.optimality.quadratic import Programs, solve

BATCH, MEASUREMENTS, GENES, PIECES, ROWS = 5, 3, 4, 3, 2


def random_programs(seed: int) -> Programs:
    generator = np.random.default_rng(seed)
    n = MEASUREMENTS * GENES
    root = generator.normal(size=(BATCH, n, n)) / np.sqrt(n)
    return Programs(
        hessian=root @ root.swapaxes(1, 2) + 0.1 * np.eye(n),
        values=0.1 * generator.normal(size=(BATCH, PIECES)),
        gradients=generator.normal(size=(BATCH, PIECES, n)),
        limits=generator.uniform(-0.5, 0.05, (BATCH, MEASUREMENTS, ROWS)),
        limit_gradients=generator.normal(size=(BATCH, MEASUREMENTS, ROWS, GENES)),
        low=-generator.uniform(0.1, 1.0, (BATCH, n)),
        high=generator.uniform(0.1, 1.0, (BATCH, n)),
        penalty=np.full(BATCH, 50.0),
    )


def test_solutions_satisfy_the_optimality_conditions() -> None:
    q = random_programs(1)
    solution = solve(q)
    d = solution.step
    assert ((d > q.low) & (d < q.high)).all()
    np.testing.assert_allclose(solution.pieces.sum(axis=1), 1.0, atol=1e-8)
    slope = (
        np.einsum("bnk,bk->bn", q.hessian, d)
        + np.einsum("bjn,bj->bn", q.gradients, solution.pieces)
        + np.einsum("bmrg,bmr->bmg", q.limit_gradients, solution.limits).reshape(BATCH, -1)
    )
    inside = np.minimum(d - q.low, q.high - d) > 1e-5
    assert inside.any()
    assert np.abs(slope[inside]).max() < 1e-5
    assert (slope[d - q.low < 1e-7] > 0.0).all()
    assert (slope[q.high - d < 1e-7] < 0.0).all()
    limits = q.limits + np.einsum("bmrg,bmg->bmr", q.limit_gradients, d.reshape(BATCH, MEASUREMENTS, GENES))
    assert limits.max() < 1e-6
    assert np.abs(limits[solution.limits > 1e-4]).max() < 1e-6


def test_limits_that_cannot_be_kept_are_broken_as_little_as_possible() -> None:
    q = random_programs(3)
    impossible = Programs(**{**vars(q), "limits": np.full_like(q.limits, 100.0)})
    assert np.isfinite(solve(impossible).step).all()

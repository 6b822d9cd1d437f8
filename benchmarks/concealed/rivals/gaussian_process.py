"""Gaussian-process regression of the base model's residuals over pose and load (scikit-learn).

Set up as its documentation advises: inputs scaled, residuals divided by their known standard deviation (`alpha` = 1),
anisotropic kernels, restarts of the optimiser of the marginal likelihood. Beside the plain anisotropic kernels there is
one that knows that a deflection grows with the load: a linear kernel of the load times an anisotropic one of the pose
(Rasmussen and Williams, Gaussian Processes for Machine Learning, 2006, 4.2.4). All outputs share a kernel, as
`GaussianProcessRegressor` has it. The kernel is chosen by the marginal likelihood, and series are left out in groups to
see whether the whole helps; where it does not, the base model predicts.
"""

from __future__ import annotations

import warnings

import numpy as np
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, Kernel, Matern, WhiteKernel
from sklearn.model_selection import GroupKFold

from .question import Array, Question, Reply, main

_RESTARTS = 2
_MOST_ROWS = 130
"""Rows on which hyperparameters are optimised; the regression itself uses all."""


class LinearInLoad(Kernel):  # type: ignore[misc]
    """x_load · y_load: not tunable, to be multiplied by a kernel of everything."""

    def __init__(self, load: tuple[int, ...] = ()) -> None:
        self.load = load

    def __call__(self, X: Array, Y: Array | None = None, eval_gradient: bool = False):  # type: ignore[no-untyped-def]
        left = X[:, list(self.load)]
        values = left @ (left if Y is None else Y[:, list(self.load)]).T
        return (values, np.empty((len(X), len(X), 0))) if eval_gradient else values

    def diag(self, X: Array) -> Array:
        """x_load · x_load."""
        return np.asarray((X[:, list(self.load)] ** 2).sum(axis=1))

    def is_stationary(self) -> bool:
        """Whether it depends on differences alone: no."""
        return False


def kernels(inputs: int, load: tuple[int, ...]) -> list[Kernel]:
    """Anisotropic kernels of growing roughness, each with a further noise."""
    scales, bounds = np.full(inputs, 2.0), (0.1, 1e3)

    def size() -> ConstantKernel:
        return ConstantKernel(10.0, (1e-3, 1e5))

    def noise() -> WhiteKernel:
        return WhiteKernel(1e-2, (1e-5, 1e2))

    return [
        size() * RBF(scales, bounds) + noise(),
        size() * Matern(scales, bounds, nu=1.5) + noise(),
        size() * LinearInLoad(load) * RBF(scales, bounds) + noise(),
    ]


def fitted(inputs: Array, targets: Array, load: tuple[int, ...]) -> GaussianProcessRegressor:
    """The process whose kernel has the largest marginal likelihood."""
    generator = np.random.default_rng(1)
    chosen = np.arange(len(inputs))
    if len(inputs) > _MOST_ROWS:
        chosen = np.sort(generator.choice(len(inputs), _MOST_ROWS, replace=False))
    tried = []
    for kernel in kernels(inputs.shape[1], load):
        process = GaussianProcessRegressor(kernel, alpha=1.0, n_restarts_optimizer=_RESTARTS, random_state=1)
        tried.append(process.fit(inputs[chosen], targets[chosen]))
    best = max(tried, key=lambda each: float(each.log_marginal_likelihood_value_))
    return GaussianProcessRegressor(best.kernel_, alpha=1.0, optimizer=None).fit(inputs, targets)


def solve(question: Question) -> Reply:
    """Base model and process together, unless left-out series are predicted better without the process."""
    warnings.simplefilter("ignore", ConvergenceWarning)
    warnings.simplefilter("ignore", RuntimeWarning)
    base, mismatch = question.base_prediction(), question.mismatch()
    if not mismatch:
        return Reply(base, mismatch)
    count, targets = question.fitted, question.whitened_residuals()
    inputs, load = question.inputs_all()
    process = fitted(inputs[:count], targets, tuple(int(column) for column in load))
    before = after = 0.0
    for train, test in GroupKFold(min(8, len(np.unique(question.groups)))).split(
        inputs[:count], groups=question.groups
    ):
        again = GaussianProcessRegressor(process.kernel_, alpha=1.0, optimizer=None)
        left = again.fit(inputs[:count][train], targets[train]).predict(inputs[:count][test])
        before += float((targets[test] ** 2).sum())
        after += float(((targets[test] - left) ** 2).sum())
    if after >= before:
        return Reply(base, mismatch)
    correction = process.predict(inputs).reshape(len(inputs), -1)
    return Reply(base + correction * question.std_all, mismatch)


if __name__ == "__main__":
    main(solve, __doc__)

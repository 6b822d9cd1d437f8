"""Polynomial correction of the readings: what the base model leaves, as a polynomial of pose and load (scikit-learn).

Degree and ridge penalty are chosen by leaving out series in groups; degree 0 is no correction. Terms are products of
pose, load, time and warming up to the degree, each scaled to mean 0 and deviation 1.
"""

from __future__ import annotations

import numpy as np
from sklearn.linear_model import Ridge
from sklearn.model_selection import GroupKFold
from sklearn.pipeline import Pipeline, make_pipeline
from sklearn.preprocessing import PolynomialFeatures, StandardScaler

from .question import Question, Reply, main

_DEGREES = (1, 2, 3)
_PENALTIES = (1e-1, 1.0, 1e1, 1e2, 1e3, 1e4)


def model(degree: int, penalty: float) -> Pipeline:
    """Ridge regression on the terms of a polynomial."""
    return make_pipeline(
        PolynomialFeatures(degree, include_bias=False), StandardScaler(), Ridge(penalty, solver="cholesky")
    )


def solve(question: Question) -> Reply:
    """The base model with the polynomial whose left-out error is least."""
    base, mismatch = question.base_prediction(), question.mismatch()
    count, targets = question.fitted, question.whitened_residuals()
    inputs, _ = question.inputs_all()
    seen = inputs[:count]
    folds = list(GroupKFold(min(8, len(np.unique(question.groups)))).split(seen, groups=question.groups))
    best, least = None, float((targets**2).sum())
    for degree in _DEGREES:
        for penalty in _PENALTIES:
            error = 0.0
            for train, test in folds:
                left = model(degree, penalty).fit(seen[train], targets[train]).predict(seen[test])
                error += float(((targets[test] - left.reshape(targets[test].shape)) ** 2).sum())
            if error < least:
                best, least = (degree, penalty), error
    if best is None:
        return Reply(base, mismatch)
    correction = model(*best).fit(seen, targets).predict(inputs).reshape(base.shape)
    return Reply(base + correction * question.std_all, mismatch)


if __name__ == "__main__":
    main(solve, __doc__)

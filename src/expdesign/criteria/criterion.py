"""What a criterion is.

DUIR, FEIR, the observability indices and the test-pose criteria are all functions of the same few matrices: the
singular values of the whitened observation matrix, and the variances of the attained pose at the targets. A criterion
is therefore one short class on an `Assessment`; its file in this folder is all that a new one needs, also to be an
objective of a search that uses gradients.
"""

from abc import ABC, abstractmethod
from functools import lru_cache
from typing import ClassVar

from expdesign.arrays import FloatArray
from expdesign.criteria.assessment import Assessment
from expdesign.plugins import implementations


class Criterion(ABC):
    """A number per design by which designs are compared.

    Attributes:
        name: identifier in configurations and results.
        title: for reports.
        unit: of its values.
        maximise: whether larger is better.
        root_mean_square: whether it is the root of a sum of squares, which is at its least, with a kink, where it is 0.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    unit: ClassVar[str] = "1"
    maximise: ClassVar[bool] = False
    root_mean_square: ClassVar[bool] = False

    @abstractmethod
    def values(self, assessment: Assessment) -> FloatArray:
        """Values of b designs, shape (b,); NaN where the design cannot identify what the criterion needs.

        One expression in NumPy, without writing into arrays: gradients and optimality conditions come from it by
        automatic differentiation (`differentiation.py`). A maximum is written with `assessment.largest`.
        """


@lru_cache(maxsize=1)
def known_criteria() -> dict[str, Criterion]:
    """Every criterion by its name, in a fixed order: `duir`, `feir`, `total`, then the others by name."""
    found = {cls.name: cls() for cls in implementations("expdesign.criteria", Criterion)}  # type: ignore[type-abstract]
    first = ("duir", "feir", "total")
    return {name: found[name] for name in (*first, *sorted(set(found) - set(first)))}

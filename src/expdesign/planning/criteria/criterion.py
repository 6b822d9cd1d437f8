"""What a criterion is.

DUIR, FEIR, the observability indices and the test-pose criteria are all functions of the same few matrices: the
singular values of the whitened observation matrix, and the variances of the attained pose at the targets. A criterion
is therefore one short class on an `Assessment`; its file in this folder is all that a new one needs, also to be an
objective of a search that uses gradients.
"""

from abc import ABC, abstractmethod
from functools import lru_cache
from typing import TYPE_CHECKING, ClassVar, Self

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.errors import InputError
from expdesign.mechanics.differentiation import is_recorded, plain
from expdesign.planning.criteria.assessment import Assessment
from expdesign.plugins import implementations

if TYPE_CHECKING:
    from expdesign.planning.problem import DesignProblem
    from expdesign.planning.schema import RunSection


class Criterion(ABC):
    """A number per design by which designs are compared.

    Attributes:
        name: identifier in configurations and results.
        title: for reports.
        unit: of its values.
        maximise: whether larger is better.
        root_mean_square: whether it is the root of a sum of squares, whose gradient jumps where it is 0.
        differentiable: whether its values have gradients; without them no design descends towards it, and designs have
            no KKT proximity.
        of_problem: whether it needs more than an assessment, so that it is made for one problem (`for_problem`).
    """

    name: ClassVar[str]
    title: ClassVar[str]
    unit: ClassVar[str] = "1"
    maximise: ClassVar[bool] = False
    root_mean_square: ClassVar[bool] = False
    differentiable: ClassVar[bool] = True
    of_problem: ClassVar[bool] = False

    @abstractmethod
    def values(self, assessment: Assessment) -> FloatArray:
        """Values of b designs, shape (b,); NaN where the design cannot identify what the criterion needs.

        One expression in NumPy, without writing into arrays: gradients and optimality conditions come from it by
        automatic differentiation (`differentiation.py`). A maximum is written with `assessment.largest`.
        """

    @classmethod
    def for_problem(cls, problem: "DesignProblem", section: "RunSection") -> Self | None:
        """The criterion of one problem, as its configuration says; None where that does not ask for it.

        Raises:
            InputError: the configuration asks for it and does not suit it.
        """
        del problem, section
        return cls()


def criterion_values(criterion: Criterion, assessment: Assessment) -> FloatArray:
    """Values (b,) of a criterion, recorded where the assessment is.

    Raises:
        InputError: its code fails, or gives something else than one number per design.
    """
    where = f"criterion `{criterion.name}`"
    try:
        values = criterion.values(assessment)
        shape = np.shape(plain(values))
    except (ArithmeticError, AttributeError, LookupError, NotImplementedError, TypeError, ValueError) as error:
        what = f"its values cannot be computed{_recorded(assessment)} ({type(error).__name__}: {error})"
        raise InputError(what, where=where, remedy=_REMEDY) from None
    if shape != (assessment.batch,):
        what = f"its values have the shape {shape} for {assessment.batch} designs"
        raise InputError(what, where=where, remedy="`values` gives one number per design.")
    return values


def _recorded(assessment: Assessment) -> str:
    return " and differentiated" if is_recorded(assessment.measurements.observation) else ""


_REMEDY = (
    "Write `values` as one expression of NumPy functions without assignments into arrays, and replace NaN, which marks "
    "what a design cannot identify, before functions that do not pass it on; or leave it out of `objectives`."
)


def kinds() -> list[type[Criterion]]:
    """Every criterion's class."""
    return implementations("expdesign.planning.criteria", Criterion)  # type: ignore[type-abstract]


def criteria_of_problem(problem: "DesignProblem", section: "RunSection") -> tuple[Criterion, ...]:
    """Criteria beside those of every design for which a configuration asks."""
    found = (cls.for_problem(problem, section) for cls in kinds() if cls.of_problem)
    return tuple(criterion for criterion in found if criterion is not None)


def known_criteria() -> dict[str, Criterion]:
    """Every criterion by its name, in a fixed order: `duir`, `feir`, `total`, then the others by name."""
    return dict(_made(tuple(kinds())))


@lru_cache(maxsize=1)
def _made(classes: tuple[type[Criterion], ...]) -> dict[str, Criterion]:
    found = {cls.name: cls() for cls in classes if not cls.of_problem}
    first = ("duir", "feir", "total")
    return {name: found[name] for name in (*first, *sorted(set(found) - set(first)))}

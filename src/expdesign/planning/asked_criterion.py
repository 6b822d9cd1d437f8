"""Criteria that a configuration has to ask for, because they need more than the linear model of the measurements.

They are found by their place, so that design knows none of them.
"""

from abc import abstractmethod
from typing import Self

from expdesign.io.yaml_reader import YamlDocument
from expdesign.planning.criteria.criterion import Criterion
from expdesign.planning.problem import DesignProblem
from expdesign.planning.schema import RunSection
from expdesign.plugins import implementations

PLACES = ("expdesign.assurance.model_error",)
"""Packages in which they are."""
NAMES = ("meir",)
"""Their names, for a configuration that misspells one."""


class AskedCriterion(Criterion):
    """A criterion of one design problem."""

    @classmethod
    @abstractmethod
    def asked(cls, problem: DesignProblem, section: RunSection, document: YamlDocument) -> Self:
        """The criterion for a problem; raises an `InputError` where the configuration does not suit it."""


def asked_criteria(problem: DesignProblem, section: RunSection, document: YamlDocument) -> tuple[Criterion, ...]:
    """The criteria that a configuration asks for: by name among the objectives, or by a section of their own."""
    if section.model_error is None and not set(NAMES) & set(section.objectives):
        return ()
    kinds = [kind for place in PLACES for kind in implementations(place, AskedCriterion)]  # type: ignore[type-abstract]
    return tuple(kind.asked(problem, section, document) for kind in kinds)

"""MEIR as a run configuration asks for it (file-formats.md, Run configurations)."""

from expdesign.design.problem import DesignProblem
from expdesign.design.schema import ModelErrorSection
from expdesign.errors import InputError
from expdesign.files.yaml_reader import YamlDocument
from expdesign.model_error.impact import ModelErrorImpact
from expdesign.model_error.meir import Meir
from expdesign.model_error.settings import Assumptions


def meir_of(problem: DesignProblem, section: ModelErrorSection, document: YamlDocument) -> Meir:
    """The criterion for a problem.

    Raises:
        InputError: no physics is left to consider, a name is unknown, a size is not positive, or no test has this level
            and power.
    """
    problem.require_elastostatic("MEIR is defined")
    try:
        return Meir(ModelErrorImpact(problem, assumptions_of(section)), section.form)
    except InputError as error:
        raise InputError(error.what, where=f"{document.source}, {error.where}", remedy=error.remedy) from None


def assumptions_of(section: ModelErrorSection) -> Assumptions:
    """What the section says, with the table of sizes for what it does not."""
    physics = None if section.physics is None else frozenset(section.physics)
    given = Assumptions(section.level, section.power, physics, frozenset(section.without))
    return given.with_sizes(section.sizes)

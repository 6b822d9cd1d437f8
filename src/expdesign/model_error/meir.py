"""MEIR: how far physics that the model leaves out may reach the position without being noticed (theory.md 21)."""

from functools import cached_property
from typing import Self

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.criteria.assessment import Assessment
from expdesign.design.asked_criterion import AskedCriterion
from expdesign.design.problem import DesignProblem
from expdesign.design.schema import ModelErrorsSection, RunSection
from expdesign.differentiation import is_recorded
from expdesign.errors import InputError
from expdesign.files.yaml_reader import YamlDocument
from expdesign.model_error.impact import Form, ModelErrorImpact
from expdesign.model_error.settings import Assumptions


class Meir(AskedCriterion):
    """The largest MEIR_e over the effects that are considered, or their root mean square.

    Args:
        impact: the problem, the physics considered and what is assumed of it.
        form: largest, or root mean square.
        entries: the effects that count, with their starts, in a search; all where left out.
    """

    name = "meir"
    title = "MEIR (what the model leaves out)"
    unit = "tolerances"
    root_mean_square = True
    costly = True

    def __init__(self, impact: ModelErrorImpact, form: Form = "max", entries: IntArray | None = None) -> None:
        self.impact, self.form, self.entries = impact, form, entries

    @classmethod
    def asked(cls, problem: DesignProblem, section: RunSection, document: YamlDocument) -> Self:
        """Raises `InputError`: no physics is left, a name is unknown, a size not positive, or there is no such test."""
        problem.require_elastostatic("MEIR is defined")
        given = section.model_error or ModelErrorsSection()
        try:
            return cls(ModelErrorImpact(problem, _assumptions(given)), given.form)
        except InputError as error:
            raise InputError(error.what, where=f"{document.source}, {error.where}", remedy=error.remedy) from None

    def values(self, assessment: Assessment) -> FloatArray:
        if self.form == "rms" or self.entries is not None:
            return self._used.values(assessment, self.form)
        if is_recorded(assessment.whitened):
            return self.impact.worst(assessment).values(assessment)
        return self.impact.largest(assessment)

    def working(self, assessment: Assessment) -> "Meir":
        """The largest over a working set: what it had, and the effects that are the worst, or nearly, in these designs.

        An exchange method for the semi-infinite program that a maximum over physics is (Blankenship & Falk 1976): with
        few effects a search costs little, and it ends where no effect outside the set is worse. A root mean square has
        no such set.
        """
        if self.form == "rms":
            return self
        active = self.impact.close(assessment)
        known = np.zeros(0, dtype=np.int64) if self.entries is None else self.entries
        entries = np.union1d(known, active)
        return self if self.entries is not None and len(entries) == len(known) else Meir(self.impact, "max", entries)

    @cached_property
    def _used(self) -> ModelErrorImpact:
        return self.impact if self.entries is None else self.impact.restricted(self.entries)


def _assumptions(section: ModelErrorsSection) -> Assumptions:
    """What the section says, with the table of sizes for what it does not."""
    physics = None if section.physics is None else frozenset(section.physics)
    given = Assumptions(section.level, section.power, physics, frozenset(section.without))
    return given.with_sizes(section.sizes)

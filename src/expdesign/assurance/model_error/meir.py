"""MEIR: how far physics that the model leaves out may reach the position without being noticed (theory.md 21).

With Ã the whitened base sensitivities of a plan and B̃_e those of an effect e in units of its prior sizes, the
base model takes up u = Ã⁺B̃_e·x of an effect of size x; R_e·x with R_e = (I − ÃÃ⁺)B̃_e remains in the residuals, and the
compensated robot misses target t by (T_e,t − A_t·Ã⁺B̃_e)·x. Then

    MEIR_e² = max over x of Σ_t w_t·‖W_t^½·(T_e,t − A_t·Ã⁺B̃_e)·x‖²  subject to  ‖R_e·x‖² ≤ λ,  ‖x‖² ≤ 1.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.assurance.model_error.left_out import (
    Directions,
    Omitted,
    left_out,
    offsets,
    plan_points,
    sampled_points,
    sizes_at_targets,
    target_points,
)
from expdesign.assurance.model_error.settings import Assumptions
from expdesign.assurance.model_error.two_ellipsoids import largest_along_axes
from expdesign.chain.chain import Chain
from expdesign.chain.row import RowData, row_data
from expdesign.errors import InputError
from expdesign.io.yaml_reader import YamlDocument
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.criterion import Criterion
from expdesign.planning.criteria.information import Information
from expdesign.planning.problem import DesignProblem
from expdesign.planning.schema import ModelErrorsSection, RunSection

VISIBLE = 1e-6
"""Singular values of R_e below this fraction of the largest of B̃_e are rounding: that direction is not visible."""


@dataclass(frozen=True)
class Hidden:
    """What b designs hide, for E entries of left-out physics.

    Attributes:
        squares: MEIR_e², shape (b, E); NaN where a design does not identify the base model.
        sizes: x of the worst combination of each entry in units of the prior sizes, shape (b, D).
        visible: ‖R_e·x‖²/λ of that combination, shape (b, E): 1 where it is just noticed, 0 where it never is.
        freedom: degrees of freedom of the residuals, shape (b,).
    """

    squares: FloatArray
    sizes: FloatArray
    visible: FloatArray
    freedom: IntArray


class Meir(Criterion):
    """The largest MEIR_e over the effects that are considered.

    Args:
        problem: whose plans are meant.
        assumptions: of MEIR.
        physics: what is left out; everything that the robot can have where it is not given.

    Raises:
        InputError: not the stiffness alone is calibrated, or the assumptions do not suit the robot.
    """

    name = "meir"
    title = "MEIR (what the model leaves out)"
    unit = "tolerances"
    root_mean_square = True
    differentiable = False
    of_problem = True

    def __init__(
        self,
        problem: DesignProblem,
        assumptions: Assumptions | None = None,
        physics: tuple[Omitted, ...] | None = None,
    ) -> None:
        problem.require_elastostatic("MEIR is defined")
        self.problem, self.assumptions = problem, assumptions or Assumptions()
        self.compliance = problem.loaded.robot.compliance
        known = None if problem.found is None else problem.found.physics
        if physics is None:
            slots = [] if known is None else [effect.slot for effect in known.chain.effects]
            physics = left_out(problem, sampled_points(problem), self.assumptions, slots)
        self.physics = physics
        chain = Chain(problem.loaded.robot) if known is None else Chain(known.chain.robot, known.chain.effects)
        self.directions = Directions(chain, chain.start() if known is None else known.values, physics)

    @classmethod
    def for_problem(cls, problem: DesignProblem, section: RunSection, document: YamlDocument) -> Self | None:
        """Raises `InputError`: no physics is left, a name is unknown, a size not positive, or there is no such test."""
        if section.model_error is None and cls.name not in section.objectives:
            return None
        try:
            assumptions = Assumptions(**dict(section.model_error or ModelErrorsSection()))
        except InputError as error:
            raise InputError(error.what, where=f"{document.source}, {error.where}", remedy=error.remedy) from None
        return cls(problem, assumptions)

    @cached_property
    def motions(self) -> FloatArray:
        """How each parameter moves the platform at the targets along the axes of the tolerances, shape (t, n, D)."""
        return self._along_axes(self.directions.at(self._targets, platform=True))

    def moved_by(self, index: int, size: float) -> FloatArray:
        """How physics with a step moves the platform there at a size in its prior ones, shape (t, n)."""
        change = self.directions.change(index, self._targets, size, platform=True)
        return self._along_axes(change[..., None])[..., 0]

    @cached_property
    def _targets(self) -> RowData:
        count, robot = len(self.problem.targets.configurations), self.directions.base.robot
        rows = [row_data(target_points(self.problem, index), robot).values for index in range(count)]
        return RowData(np.concatenate(rows), series=np.arange(count), position=np.zeros(count, dtype=np.int64))

    def _along_axes(self, moved: FloatArray) -> FloatArray:
        axes = self.problem.targets.axes
        return moved if axes is None else axes @ moved

    @cached_property
    def errors(self) -> FloatArray:
        """√(w_t/Σw)·W_t^½·S_t·[A_t·diag(1/apK), T_t], in the blocks of `Targets.blocks`, shape (blocks, q, n_p + D)."""
        targets = self.problem.targets
        return targets.blocks(np.concatenate([targets.observation * self.compliance, self.motions], axis=2))

    @cached_property
    def deviations(self) -> FloatArray:
        """Prior sizes of all columns, shape (D,)."""
        springs, moved = np.split(self.errors.reshape(-1, self.errors.shape[-1]), [len(self.compliance)], axis=1)
        sizes = sizes_at_targets(self.problem, springs)
        pairs = [(entry.effect, entry.effect.parameters[index]) for entry in self.physics for index in entry.free]
        columns = zip(pairs, moved.T, strict=True)
        return np.array([sizes.of(self.assumptions.size(*pair), *pair, column) for pair, column in columns])

    def whitened(self, assessment: Assessment) -> tuple[FloatArray, FloatArray]:
        """Ã in units of 1/apK (b, M, n_p) and B̃ in units of the prior sizes (b, M, D) of b designs."""
        assert assessment.states is not None
        configurations, loads = assessment.states
        flat = (each.reshape(-1, each.shape[-1]) for each in (configurations, loads))
        points = plan_points(self.problem.loaded, *flat)
        rows = self.directions.at(row_data(points, self.directions.base.robot))
        rows = rows.reshape(*configurations.shape[:2], *rows.shape[1:])
        return assessment.whitened * self.compliance, assessment.white(rows) * self.deviations

    def hidden_from(self, base: FloatArray, directions: FloatArray) -> Hidden:
        """What b sets of readings hide.

        Args:
            base: Ã in units of 1/apK, shape (b, M, p); beyond the n_p compliances it has the sensitivities of an
                instrument and its markers, which move no target.
            directions: B̃ in units of the prior sizes, shape (b, M, D).
        """
        batch, readings, parameters = base.shape
        together = np.concatenate([base, directions], axis=2)
        finite: BoolArray = np.logical_and.reduce(np.isfinite(together), axis=(1, 2))
        base, directions = np.split(np.where(finite[:, None, None], together, 0.0), [parameters], axis=2)
        by_base, by_physics = np.split(self.errors, [len(self.compliance)], axis=2)
        by_base = np.pad(by_base, ((0, 0), (0, 0), (0, parameters - by_base.shape[2])))
        model = Information.of_measurements(base[:, None])
        orthogonal = base @ model.inverse
        seen_by_base = orthogonal.swapaxes(-1, -2) @ directions
        remaining = directions - orthogonal @ seen_by_base
        missed = by_physics * self.deviations - by_base @ (model.inverse @ seen_by_base)[:, None]
        scale = (directions**2).sum(axis=1)
        start, entries = offsets(self.physics), (batch, len(self.physics))
        squares, visible = np.zeros(entries), np.zeros(entries)
        sizes = np.zeros((batch, directions.shape[2]))
        for width in np.unique(np.diff(start)):
            chosen = np.flatnonzero(np.diff(start) == width)
            columns = start[chosen][:, None] + np.arange(width)
            seen = remaining[:, :, columns].transpose(0, 2, 1, 3)  # (b, e, M, d)
            values, axes = np.linalg.eigh(seen.swapaxes(-1, -2) @ seen)
            shown = values > VISIBLE**2 * scale[:, columns].sum(axis=-1)[..., None]
            # λ by how many directions are visible; where none is, it does not matter.
            threshold = self.assumptions.noncentrality(np.maximum(np.arange(width + 1), 1))[shown.sum(axis=-1)]
            values = np.where(shown, values, 0.0) / threshold[..., None]
            forms = missed[..., columns].transpose(0, 1, 3, 2, 4) @ axes[:, None]  # (b, blocks, e, q, d)
            shape = forms.shape[:3]
            repeated = np.broadcast_to(values[:, None], (*shape, width))
            solved = largest_along_axes(forms.reshape(-1, *forms.shape[3:]), repeated.reshape(-1, width))
            best: IntArray = solved.value.reshape(shape).argmax(axis=1)
            point = np.take_along_axis(solved.point.reshape(*shape, width), best[:, None, :, None], axis=1)[:, 0]
            squares[:, chosen] = np.take_along_axis(solved.value.reshape(shape), best[:, None], axis=1)[:, 0]
            visible[:, chosen] = (point**2 * values).sum(axis=-1)
            sizes[:, columns] = (axes @ point[..., None])[..., 0]
        squares[~(finite & model.estimable(by_base).all(axis=(1, 2)))] = np.nan
        return Hidden(squares, sizes, visible, readings - model.rank)

    def hidden(self, assessment: Assessment) -> Hidden:
        """What the designs of an assessment by this problem hide."""
        return self.hidden_from(*self.whitened(assessment))

    def values(self, assessment: Assessment) -> FloatArray:
        return np.sqrt(self.hidden(assessment).squares.max(axis=1))


def meir_of_problem(problem: DesignProblem) -> Meir | None:
    """The MEIR that a configuration asks for, or None."""
    return next((criterion for criterion in problem.further if isinstance(criterion, Meir)), None)

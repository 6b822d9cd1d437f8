"""MEIR: how far physics that the model leaves out may reach the position without showing (theory.md 21).

With Ã the base sensitivities of a plan, weighed by noise and load errors as the estimator does, and B̃_e those of an
effect e in units of its prior sizes, the base model takes up u = Ã⁺B̃_e·x of an effect of size x ~ N(0, I);
R_e·x with R_e = (I − ÃÃ⁺)B̃_e remains in the residuals, and the compensated robot misses target t by
(T_e,t − A_t·Ã⁺B̃_e)·x. Of x the readings leave the covariance C_e = (I + R_eᵀR_e)⁻¹, so that what stays hidden is

    MEIR_e² = Σ_t w_t·tr(W_t·(T_e,t − A_t·Ã⁺B̃_e)·C_e·(T_e,t − A_t·Ã⁺B̃_e)ᵀ),

by which the mean square error at the targets rises where the model has the effect (`Gaussian.joined`).
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.assurance.model_error.physics import (
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
from expdesign.chain.chain import Chain
from expdesign.chain.row import RowData, row_data
from expdesign.errors import InputError
from expdesign.estimation.gaussian import left_of
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
        axes: mean squares along every axis of every target, in tolerances², shape (b, E, t, n); NaN where a design
            does not identify the base model.
        squares: MEIR_e², shape (b, E).
        sizes: x of the combination of each entry that adds most to it, at the standard deviation that stays hidden, in
            units of the prior sizes, shape (b, D).
        shown: ‖R_e·x‖², shape (b, E): 1 where the readings alone determine it, 0 where they do not show it.
        visible: the same over λ: noticed with the required power where x grows by 1/√visible.
        freedom: degrees of freedom of the residuals, shape (b,).
    """

    axes: FloatArray
    squares: FloatArray
    sizes: FloatArray
    shown: FloatArray
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
    def for_problem(cls, problem: DesignProblem, section: RunSection) -> Self | None:
        """Raises `InputError`: no physics is left, a name is unknown, a size not positive, or there is no such test."""
        if section.model_error is None and cls.name not in section.objectives:
            return None
        try:
            assumptions = Assumptions(**dict(section.model_error or ModelErrorsSection()))
        except InputError as error:
            raise InputError(error.what, where=f"{problem.source}, {error.where}", remedy=error.remedy) from None
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
    def _rows(self) -> FloatArray:
        """S_t·[A_t·diag(1/apK), T_t], shape (t, n, n_p + D)."""
        return np.concatenate([self.problem.targets.observation * self.compliance, self.motions], axis=2)

    @cached_property
    def errors(self) -> FloatArray:
        """The same of every axis of every target, in tolerances, shape (t·n, n_p + D)."""
        weighted = np.sqrt(self.problem.targets.importance)[..., None] * self._rows
        return weighted.reshape(-1, weighted.shape[-1])

    @cached_property
    def deviations(self) -> FloatArray:
        """Prior sizes of all columns, shape (D,)."""
        rows = self.problem.targets.blocks(self._rows)
        springs, moved = np.split(rows.reshape(-1, rows.shape[-1]), [len(self.compliance)], axis=1)
        sizes = sizes_at_targets(self.problem, springs)
        pairs = [(entry.effect, entry.effect.parameters[index]) for entry in self.physics for index in entry.free]
        columns = zip(pairs, moved.T, strict=True)
        return np.array([sizes.of(self.assumptions.size(*pair), *pair, column) for pair, column in columns])

    def rows(self, configurations: FloatArray, loads: FloatArray) -> FloatArray:
        """Deflections by each parameter at configurations (..., n_q) under loads (..., k), shape (..., n, D)."""
        # Designs that are compared have most measurements in common.
        width = configurations.shape[-1]
        states = np.concatenate([configurations, loads], axis=-1).reshape(-1, width + loads.shape[-1])
        distinct, place = np.unique(states, axis=0, return_inverse=True)
        points = plan_points(self.problem.loaded, *np.split(distinct, [width], axis=1))
        found: FloatArray = self.directions.at(row_data(points, self.directions.base.robot))
        return found[place.reshape(loads.shape[:-1])]

    def whitened(self, assessment: Assessment, rows: FloatArray | None = None) -> tuple[FloatArray, FloatArray]:
        """Ã in units of 1/apK (b, M, n_p) and B̃ in units of the prior sizes (b, M, D) of b designs.

        Args:
            assessment: of the designs.
            rows: of their measurements, shape (b, m, n, D), where they are known.
        """
        assert assessment.states is not None
        rows = self.rows(*assessment.states) if rows is None else rows
        base = assessment.weighed(assessment.measurements.observation) * self.compliance
        return base, assessment.weighed(rows) * self.deviations

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
        by_base, by_physics = np.split(self.errors, [len(self.compliance)], axis=1)
        by_base = np.pad(by_base, ((0, 0), (0, parameters - by_base.shape[1])))
        model = Information.of_measurements(base[:, None])
        orthogonal = base @ model.inverse
        seen_by_base = orthogonal.swapaxes(-1, -2) @ directions
        remaining = directions - orthogonal @ seen_by_base
        missed = by_physics * self.deviations - by_base @ (model.inverse @ seen_by_base)
        start, shape = offsets(self.physics), self.problem.targets.importance.shape
        axes = np.zeros((batch, len(self.physics), *shape))
        shown, sizes = np.zeros(axes.shape[:2]), np.zeros((batch, directions.shape[2]))
        dof = np.ones(axes.shape[:2], dtype=np.int64)
        for width in np.unique(np.diff(start)):
            chosen = np.flatnonzero(np.diff(start) == width)
            columns = start[chosen][:, None] + np.arange(width)
            seen = remaining[:, :, columns].transpose(0, 2, 1, 3)  # (b, e, M, d)
            information = seen.swapaxes(-1, -2) @ seen
            rounding = VISIBLE**2 * (directions**2).sum(axis=1)[:, columns].sum(axis=-1)
            visible = (np.linalg.eigvalsh(information) > rounding[..., None]).sum(axis=-1)
            left = left_of(information)
            root = missed[..., columns].transpose(0, 2, 1, 3) @ left  # (b, e, t·n, d)
            axes[:, chosen] = (root**2).sum(axis=-1).reshape(batch, len(chosen), *shape)
            most = np.linalg.eigh(root.swapaxes(-1, -2) @ root)[1][..., -1:]
            sizes[:, columns] = (left @ most)[..., 0]
            dof[:, chosen] = np.maximum(visible, 1)
            shown[:, chosen] = np.where(visible, ((seen @ left @ most) ** 2).sum(axis=(-2, -1)), 0.0)
        axes[~(finite & model.estimable(by_base[None]).all(axis=(1, 2)))] = np.nan
        noticed = shown / self.assumptions.noncentrality(dof)
        return Hidden(axes, self._aggregated(axes), sizes, shown, noticed, readings - model.rank)

    def _aggregated(self, axes: FloatArray) -> FloatArray:
        """Mean, or largest, over targets of what all axes (..., t, n) add up to."""
        targets, squares = self.problem.targets, axes.sum(axis=-1)
        return (
            squares.max(axis=-1) if targets.aggregate == "max" else squares @ (targets.weights / targets.weights.sum())
        )

    def hidden(self, assessment: Assessment, rows: FloatArray | None = None) -> Hidden:
        """What the designs of an assessment hide, `rows` being as of `whitened`."""
        return self.hidden_from(*self.whitened(assessment, rows))

    def values(self, assessment: Assessment) -> FloatArray:
        return np.sqrt(self.hidden(assessment).squares.max(axis=1))


def meir_of_problem(problem: DesignProblem) -> Meir | None:
    """The MEIR that a configuration asks for, or None."""
    return next((criterion for criterion in problem.further if isinstance(criterion, Meir)), None)

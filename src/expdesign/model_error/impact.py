"""MEIR of plans: the error at the targets that left-out physics could cause without being noticed (theory.md 21)."""

from functools import cached_property
from typing import Literal, cast
from weakref import WeakKeyDictionary

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.chain.linearised import KnownChain
from expdesign.criteria.assessment import Assessment
from expdesign.criteria.targets import Targets
from expdesign.design.problem import DesignProblem
from expdesign.differentiation import is_recorded, plain, recorded_parts, square_root
from expdesign.model_error.directions import Directions, RowDirections, offsets
from expdesign.model_error.hidden import Hidden, hidden_errors, seeds
from expdesign.model_error.left_out import LeftOut, effects_of_problem, left_out
from expdesign.model_error.prior import prior_deviations, with_steps
from expdesign.model_error.settings import Assumptions

Form = Literal["max", "rms"]
CLOSE = 0.99
"""Part of a design's MEIR from which on an entry counts as nearly the worst: it may be the worst soon."""
_TIES = 3
"""Effects that may be the worst together at an optimum: more than this, and it is a coincidence that costs time."""


class ModelErrorImpact:
    """MEIR of the plans of one design problem.

    Args:
        problem: the problem.
        assumptions: of MEIR.
        physics: what is left out; everything that the robot can have where it is not given.

    Raises:
        InputError: nothing else than the stiffness is calibrated, or the assumptions do not suit the robot.
    """

    def __init__(
        self,
        problem: DesignProblem,
        assumptions: Assumptions | None = None,
        physics: tuple[LeftOut, ...] | None = None,
    ) -> None:
        problem.require_elastostatic("MEIR is defined")
        self.problem = problem
        self.assumptions = Assumptions() if assumptions is None else assumptions
        if physics is None:
            effects, points = effects_of_problem(problem)
            physics = with_steps(problem, left_out(effects, points, self.assumptions), self.assumptions)
        self.physics = physics
        # The pieces of the maximum are asked for one by one.
        self._evaluated: WeakKeyDictionary[Assessment, dict[Form, FloatArray]] = WeakKeyDictionary()
        self._worst: WeakKeyDictionary[Assessment, ModelErrorImpact] = WeakKeyDictionary()
        self._parts: dict[bytes, ModelErrorImpact] = {}
        self._designs: dict[bytes, FloatArray] = {}
        rows = RowDirections(problem.loaded.robot, self.physics, known_chain(problem))
        self.directions = Directions(rows, problem.loaded.load)

    @property
    def n_p(self) -> int:
        """Number of compliances."""
        return len(self.problem.loaded.robot.stiffness)

    @property
    def names(self) -> list[tuple[str, str, str]]:
        """Physics, component and variant of every entry."""
        return [entry.key for entry in self.physics]

    def part(self, entries: IntArray) -> tuple[tuple[LeftOut, ...], IntArray]:
        """Some of the entries, and which of the columns D are theirs."""
        start = offsets(self.physics)
        columns = np.concatenate([np.arange(start[i], start[i + 1]) for i in entries])
        return tuple(self.physics[i] for i in entries), columns

    def restricted(self, entries: IntArray) -> "ModelErrorImpact":
        """MEIR of some of the entries."""
        key = entries.tobytes()
        if key not in self._parts:
            physics, columns = self.part(entries)
            chosen = ModelErrorImpact(self.problem, self.assumptions, physics)
            chosen.directions = self.directions.part(columns)
            n_p = self.n_p
            chosen.__dict__["errors"] = self.errors[..., np.concatenate([np.arange(n_p), n_p + columns])]
            chosen.__dict__["deviations"] = self.deviations[columns]
            self._parts[key] = chosen
        return self._parts[key]

    def active(self, assessment: Assessment, share: float = 0.5) -> IntArray:
        """Entries that matter: in one of b designs MEIR_e is at least this share of the design's MEIR.

        A search that has moved far from these designs has to check its result against all entries.
        """
        squares = self._hidden(*(plain(rows) for rows in self.whitened(assessment)), share=share).squares
        return _at_least(squares, share)

    def close(self, assessment: Assessment) -> IntArray:
        """Entries that are the worst in one of b designs, or nearly."""
        return _at_least(self._leading(assessment), CLOSE)

    def worst(self, assessment: Assessment) -> "ModelErrorImpact":
        """MEIR of those entries alone: the same largest value, and the same derivatives where it has some."""
        if assessment not in self._worst:
            self._worst[assessment] = self.restricted(self.close(assessment))
        return self._worst[assessment]

    def largest(self, assessment: Assessment) -> FloatArray:
        """MEIR of b designs in tolerances as numbers, shape (b,); designs that were asked for before are remembered."""
        found: FloatArray = np.sqrt(self._leading(assessment).max(axis=1))
        return found

    def _leading(self, assessment: Assessment) -> FloatArray:
        """MEIR_e² (b, E); of entries that are not near the worst, lower bounds.

        A search asks for all entries again and again at the designs that it keeps.
        """
        assert assessment.states is not None
        configurations, loads = (plain(part) for part in assessment.states)
        series = assessment.series
        parts = [configurations, loads, *([] if series is None else [series])]
        keys = [b"".join(part[design].tobytes() for part in parts) for design in range(assessment.batch)]
        new = np.array([design for design, key in enumerate(keys) if key not in self._designs], dtype=np.int64)
        if new.size:
            own = self.problem.assess(configurations[new], loads[new], None if series is None else series[new])
            squares = self._hidden(*self.whitened(own), share=CLOSE).squares
            self._designs.update(zip([keys[design] for design in new], squares, strict=True))
        return np.stack([self._designs[key] for key in keys])

    @cached_property
    def errors(self) -> FloatArray:
        """Weighted deflections of the targets per compliance (1/apK) and per parameter, (blocks, q, n_p + D)."""
        return target_errors(self.problem, self.directions.rows)

    @cached_property
    def deviations(self) -> FloatArray:
        """Prior sizes of all columns, shape (D,)."""
        flat = self.errors.reshape(-1, self.errors.shape[-1])
        return prior_deviations(self.problem, self.physics, self.assumptions, flat)

    def whitened(self, assessment: Assessment) -> tuple[FloatArray, FloatArray]:
        """Ã in units of 1/apK (b, M, n_p) and B̃ in the parameters' own units (b, M, D) of b designs."""
        assert assessment.states is not None
        rows = self.directions.at(*assessment.states, assessment.measurements.jacobians)
        return assessment.whitened * self.problem.loaded.robot.compliance, assessment.white(rows)

    def hidden(self, assessment: Assessment) -> Hidden:
        """What the designs of an assessment by this problem hide."""
        return self._hidden(*(plain(rows) for rows in self.whitened(assessment)))

    def _hidden(self, base: FloatArray, directions: FloatArray, *, share: float = 0.0) -> Hidden:
        deviations = self.scales(directions)
        scaled = directions * deviations[..., None, :]
        errors = self._scaled_errors(deviations)
        return hidden_errors(base, scaled, errors, self.physics, self.assumptions, share=share)

    def squares(self, assessment: Assessment, form: Form = "max") -> FloatArray:
        """MEIR_e² of every effect, the worst of its starts, shape (b, effects); for `max`, those far below the largest
        are lower bounds.

        With its adjoint where the assessment is recorded: exact where one combination of an effect's parameters is the
        worst, and prior sizes are those of the table.
        """
        known = self._evaluated.setdefault(assessment, {})
        if form not in known:
            known[form] = self._squares(assessment, form)
        return known[form]

    def _squares(self, assessment: Assessment, form: Form) -> FloatArray:
        base, directions = self.whitened(assessment)
        numbers = plain(base), plain(directions)
        hidden = self._hidden(*numbers, share=1.0 if form == "max" else 0.0)
        by_effect, worst = self._worst_starts(hidden.squares)

        def pull(seed: FloatArray) -> tuple[FloatArray, FloatArray]:
            weights = np.zeros(hidden.squares.shape)
            np.put_along_axis(weights, worst, seed, axis=1)
            errors = self._scaled_errors(self.deviations)
            scaled = numbers[1] * self.deviations
            for_base, for_directions = seeds(hidden, weights, numbers[0], scaled, errors, self.physics)
            return for_base, for_directions * self.deviations

        if not (is_recorded(base) or is_recorded(directions)):
            return by_effect
        (result,) = recorded_parts((by_effect,), (base, directions), lambda found: pull(found[0]))
        return cast(FloatArray, result)

    def values(self, assessment: Assessment, form: Form = "max") -> FloatArray:
        """MEIR of b designs in tolerances, the largest over all physics or the RMS over it, shape (b,).

        The largest is taken with `assessment.largest`, so that the pieces of this maximum can be told apart.
        """
        squares = self.squares(assessment, form)
        return square_root(assessment.largest(squares, _TIES) if form == "max" else squares.mean(axis=1))

    def _worst_starts(self, squares: FloatArray) -> tuple[FloatArray, IntArray]:
        """Squares (b, effects) and entries (b, effects) of each effect's worst start, from those of all entries."""
        ends = [*self._first[1:], squares.shape[1]]
        worst = [start + squares[:, start:end].argmax(axis=1) for start, end in zip(self._first, ends, strict=True)]
        entries = np.stack(worst, axis=1)
        return np.take_along_axis(squares, entries, axis=1), entries

    @cached_property
    def _first(self) -> IntArray:
        """First entry of every effect."""
        keys = self.names
        return np.array([i for i, key in enumerate(keys) if i == 0 or key != keys[i - 1]], dtype=np.int64)

    @property
    def effects(self) -> list[tuple[str, str, str]]:
        """Physics, component and variant of every effect."""
        return [self.names[i] for i in self._first]

    def scales(self, directions: FloatArray) -> FloatArray:
        """Prior sizes, shape (D,), or (b, D) where they are bounds of what the readings show."""
        if self.assumptions.readings is None:
            return self.deviations
        norms = np.linalg.norm(directions, axis=1)
        largest = self.assumptions.readings * np.sqrt(directions.shape[1])
        shown = norms > 1e-12 * np.maximum(norms.max(axis=1, keepdims=True), 1e-300)
        return np.where(shown, largest / np.where(shown, norms, 1.0), 0.0)

    def _scaled_errors(self, deviations: FloatArray) -> FloatArray:
        """`errors` in units of the prior sizes (D,) or (b, D)."""
        n_p = self.n_p
        ones = np.ones((*deviations.shape[:-1], n_p))
        factors = np.concatenate([ones, deviations], axis=-1)
        return self.errors * (factors if factors.ndim == 1 else factors[:, None, None, :])


def _at_least(squares: FloatArray, share: float) -> IntArray:
    """Entries with at least this share of the largest in one of the designs, from squares (b, E)."""
    squares = squares[np.isfinite(squares).all(axis=1)]
    largest = squares.max(axis=1, keepdims=True)
    return np.flatnonzero((squares >= share**2 * largest).any(axis=0))


def known_chain(problem: DesignProblem) -> KnownChain | None:
    """The chain that the robot of a problem was found to have, if any."""
    return None if problem.found is None else problem.found.physics


def target_errors(problem: DesignProblem, directions: RowDirections) -> FloatArray:
    """√(w_t/Σw)·W_t^½·S_t·[A_t·diag(1/apK), T_t] of the axes that matter, shape (blocks, q, n_p + D).

    One block of all targets where their mean counts, a block per target where the worst does.
    """
    targets: Targets = problem.targets
    compliance = problem.loaded.robot.compliance
    rows = []
    for index, (loaded, parameters) in enumerate(problem.target_loads):
        moved = directions.at_target(loaded.load, targets.configurations[index], parameters)
        if targets.axes is not None:
            moved = targets.axes[index] @ moved
        both = np.concatenate([targets.observation[index] * compliance, moved], axis=1)
        rows.append(np.sqrt(targets.importance[index])[:, None] * both)
    stacked = np.array(rows)
    if targets.aggregate == "max":
        return stacked
    weighted = np.sqrt(targets.weights / targets.weights.sum())[:, None, None] * stacked
    flat = weighted.reshape(1, -1, stacked.shape[-1])
    return flat[:, (targets.importance > 0.0).ravel()]

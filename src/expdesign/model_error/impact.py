"""MEIR of plans: the error at the targets that left-out physics could cause without being noticed (docs/meir.md)."""

from functools import cached_property
from typing import Literal

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.criteria.targets import Targets
from expdesign.design.problem import DesignProblem
from expdesign.instrument.deflection_noise import DeflectionNoise, reference_whitener, series_by_pose
from expdesign.model_error.directions import Directions, offsets
from expdesign.model_error.hidden import Hidden, hidden_errors, seeds
from expdesign.model_error.left_out import LeftOut, physics_of_problem
from expdesign.model_error.prior import prior_deviations, with_steps
from expdesign.model_error.settings import Assumptions

Form = Literal["max", "rms"]


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
            physics = with_steps(problem, physics_of_problem(problem, self.assumptions), self.assumptions)
        self.physics = physics
        self.directions = Directions(problem.loaded.robot, problem.loaded.load, self.physics)

    @property
    def names(self) -> list[tuple[str, str, str]]:
        """Physics, component and variant of every entry."""
        return [entry.key for entry in self.physics]

    def restricted(self, entries: IntArray) -> "ModelErrorImpact":
        """MEIR of some of the entries."""
        chosen = ModelErrorImpact(self.problem, self.assumptions, tuple(self.physics[i] for i in entries))
        start = offsets(self.physics)
        columns = np.concatenate([np.arange(start[i], start[i + 1]) for i in entries])
        n_p = self.directions.base
        chosen.__dict__["errors"] = self.errors[..., np.concatenate([np.arange(n_p), n_p + columns])]
        chosen.__dict__["deviations"] = self.deviations[columns]
        return chosen

    def active(self, configurations: FloatArray, loads: FloatArray, share: float = 0.5) -> IntArray:
        """Entries that matter: in one of b designs MEIR_e is at least this share of the design's MEIR.

        A search that has moved far from these designs has to check its result against all entries.
        """
        squares = self.hidden(configurations, loads).squares
        squares = squares[np.isfinite(squares).all(axis=1)]
        largest = squares.max(axis=1, keepdims=True)
        return np.flatnonzero((squares >= share**2 * largest).any(axis=0))

    @cached_property
    def errors(self) -> FloatArray:
        """Weighted deflections of the targets per compliance (1/apK) and per parameter, (blocks, q, n_p + D)."""
        return target_errors(self.problem, self.physics)

    @cached_property
    def deviations(self) -> FloatArray:
        """Prior sizes of all columns, shape (D,)."""
        flat = self.errors.reshape(-1, self.errors.shape[-1])
        return prior_deviations(self.problem, self.physics, self.assumptions, flat)

    def whitened(
        self, configurations: FloatArray, loads: FloatArray, series: IntArray | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """Ã in units of 1/apK (b, M, n_p) and B̃ in the parameters' own units (b, M, D) of b designs.

        Args:
            configurations: (b, m, n_q).
            loads: (b, m, k).
            series: (b, m), where the noise has a shared reference.
        """
        rows = self.directions.at(configurations, loads)
        loaded, noise = self.problem.loaded, self.problem.noise
        measured = loaded.measure(configurations, loads)
        base = measured.observation * loaded.robot.compliance
        if noise.shared_reference and series is None:
            series = series_by_pose(configurations)
        n_p = self.directions.base
        whole = np.concatenate([base, rows[..., n_p:]], axis=-1)
        white = whiten(whole, noise, measured.jacobians.pose, series)
        return white[..., :n_p], white[..., n_p:]

    def hidden(self, configurations: FloatArray, loads: FloatArray, series: IntArray | None = None) -> Hidden:
        """What designs hide; arguments as for `whitened`."""
        base, directions = self.whitened(configurations, loads, series)
        deviations = self.scales(directions)
        errors = self._scaled_errors(deviations)
        scaled = directions * deviations[..., None, :]
        return hidden_errors(base, scaled, errors, self.physics, self.assumptions)

    def values(
        self, configurations: FloatArray, loads: FloatArray, series: IntArray | None = None, form: Form = "max"
    ) -> FloatArray:
        """MEIR of b designs in tolerances, the largest over all physics or the RMS over it, shape (b,)."""
        return combined(self.per_effect(self.hidden(configurations, loads, series).squares), form)

    def per_effect(self, squares: FloatArray) -> FloatArray:
        """Squares (b, effects) by effect, the worst of its starts, from those of the entries (b, E)."""
        return np.maximum.reduceat(squares, self._first, axis=1)

    def values_with_gradients(
        self, configurations: FloatArray, loads: FloatArray, form: Form = "max"
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """MEIR (b,) and its derivatives with respect to configurations (b, m, n_q) and loads (b, m, k).

        Exact where one effect and one combination of its parameters is the worst. The noise has to be the same at all
        poses, each measurement with its own reference, and prior sizes have to be those of the table.
        """
        base, directions = self.whitened(configurations, loads)
        scaled = directions * self.deviations
        errors = self._scaled_errors(self.deviations)
        hidden = hidden_errors(base, scaled, errors, self.physics, self.assumptions)
        value = combined(self.per_effect(hidden.squares), form)
        weights = self._weights(hidden.squares, value, form)
        for_base, for_directions = seeds(hidden, weights, base, scaled, errors, self.physics)
        seed = np.concatenate([for_base, for_directions * self.deviations], axis=-1)
        noise = self.problem.noise
        seed = seed.reshape(*configurations.shape[:2], len(noise.axes), -1)
        whole = np.zeros((*configurations.shape[:2], self.problem.loaded.robot.coordinates.n, seed.shape[-1]))
        whole[:, :, noise.axes] = noise.whitener.T @ seed
        return value, *self.directions.pull(configurations, loads, whole)

    @cached_property
    def _first(self) -> IntArray:
        """First entry of every effect."""
        keys = self.names
        return np.array([i for i, key in enumerate(keys) if i == 0 or key != keys[i - 1]], dtype=np.int64)

    @property
    def effects(self) -> list[tuple[str, str, str]]:
        """Physics, component and variant of every effect."""
        return [self.names[i] for i in self._first]

    def _weights(self, squares: FloatArray, value: FloatArray, form: Form) -> FloatArray:
        """dvalue/dMEIR_e² of every entry, shape (b, E)."""
        half = 0.5 / np.maximum(value, 1e-300)[:, None]
        rows = np.arange(len(squares))
        weights = np.zeros_like(squares)
        if form == "max":
            weights[rows, squares.argmax(axis=1)] = half[:, 0]
            return weights
        for start, stop in zip(self._first, [*self._first[1:], squares.shape[1]], strict=True):
            weights[rows, start + squares[:, start:stop].argmax(axis=1)] = half[:, 0] / len(self._first)
        return weights

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
        n_p = self.directions.base
        ones = np.ones((*deviations.shape[:-1], n_p))
        factors = np.concatenate([ones, deviations], axis=-1)
        return self.errors * (factors if factors.ndim == 1 else factors[:, None, None, :])


def combined(squares: FloatArray, form: Form) -> FloatArray:
    """Root of the largest or of the mean over the effects of squares (b, effects)."""
    total: FloatArray = squares.max(axis=1) if form == "max" else squares.mean(axis=1)
    return np.sqrt(total)


def whiten(rows: FloatArray, noise: DeflectionNoise, pose_map: FloatArray, series: IntArray | None) -> FloatArray:
    """G·rows for sensitivities (b, m, n, D) of whole deflections, shape (b, m·k, D)."""
    white = noise.whitener_at(pose_map) @ rows[:, :, noise.axes]
    if noise.shared_reference and series is not None:
        white = np.einsum("bij,bjkp->bikp", reference_whitener(series), white)
    return white.reshape(rows.shape[0], -1, rows.shape[-1])


def target_errors(problem: DesignProblem, physics: tuple[LeftOut, ...]) -> FloatArray:
    """√(w_t/Σw)·W_t^½·S_t·[A_t·diag(1/apK), T_t] of the axes that matter, shape (blocks, q, n_p + D).

    One block of all targets where their mean counts, a block per target where the worst does.
    """
    targets: Targets = problem.targets
    robot = problem.loaded.robot
    built: dict[str, Directions] = {}
    rows = []
    for index, (loaded, parameters) in enumerate(problem.target_loads):
        kind = loaded.load.kind
        if kind not in built:
            built[kind] = Directions(robot, loaded.load, physics, instrument=False)
        pose = targets.configurations[index]
        moved = built[kind].at(pose[None], parameters[None])[0]
        if targets.axes is not None:
            moved = targets.axes[index] @ moved
        moved[:, : built[kind].base] = targets.observation[index] * robot.compliance
        rows.append(np.sqrt(targets.importance[index])[:, None] * moved)
    stacked = np.array(rows)
    if targets.aggregate == "max":
        return stacked
    weighted = np.sqrt(targets.weights / targets.weights.sum())[:, None, None] * stacked
    flat = weighted.reshape(1, -1, stacked.shape[-1])
    return flat[:, (targets.importance > 0.0).ravel()]

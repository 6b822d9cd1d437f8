"""The design space: m measurements, each with a pose and a load out of the same sets.

A design is coded by its decision variables (`decisions`), m rows of one number per variable: the value itself for a
continuous variable and an index for a discrete one. The quantities that they set are, in order, the configuration of
the robot, the load's own parameters without gravity, and the tilt of the base.
"""

import copy
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.coordinates import Coordinates
from expdesign.mechanics.loads.load import tilted_gravity
from expdesign.mechanics.symbolic import BatchFunction
from expdesign.planning.deflection_noise import series_by_pose
from expdesign.planning.pose_settings import PoseSettings
from expdesign.planning.variables import Choices, Grid, Interval, Quantity, Rows, Variable, variables_for

Poses = tuple[Quantity, ...] | FloatArray
"""Where measurements may be taken: a quantity for each coordinate, or rows of a table of candidates."""


@dataclass(frozen=True)
class Required:
    """Poses and masses that have to occur: decisions (g,) of a measurement, NaN where they do not matter."""

    poses: tuple[FloatArray, ...] = ()
    masses: tuple[FloatArray, ...] = ()


class DesignSpace:
    """The designs that can be chosen, and what their decisions stand for.

    Args:
        measurements: m.
        poses: where measurements may be taken.
        load: quantities of the load's own parameters (mass and centre of mass, or the wrench).
        tilt: quantities of the tilt of the base (payloads only).
        coordinates: names.
        gravity: gravity in the base frame without tilt (m/s²); None for a wrench.
        steps: in which each quantity can be set, shape (n_q,); None where anything can be.
        settings: first and last number of a setting of a pose, the first below 0 where a measurement may be left out
            (`pose_settings.py`); None where there is nothing to choose about them.

    Attributes:
        settings: the decision about settings; None where there is none. Set by who knows the plan's budget.
    """

    def __init__(
        self,
        measurements: int,
        poses: Poses,
        load: tuple[Quantity, ...],
        tilt: tuple[Quantity, ...],
        coordinates: Coordinates,
        gravity: FloatArray | None,
        steps: FloatArray | None = None,
        settings: tuple[int, int] | None = None,
    ) -> None:
        self.measurements = measurements
        self.coordinates = coordinates
        self.gravity = gravity
        self._tilt = tilt
        candidates = poses if isinstance(poses, np.ndarray) else None
        n_pose = len(poses) if candidates is None else candidates.shape[1]
        self.n_pose, self.n_load = n_pose, len(load)
        quantities: dict[int, Quantity] = dict(enumerate((*load, *tilt), start=n_pose))
        variables = [] if candidates is None else [Variable(tuple(range(n_pose)), Rows(candidates))]
        if not isinstance(poses, np.ndarray):
            quantities = dict(enumerate(poses)) | quantities
        # A reading without load is of one pose under one tilt: where settings count, both are the robot's.
        self._placed = [
            *range(n_pose),
            *(range(n_pose + len(load), n_pose + len(load) + len(tilt)) if settings else ()),
        ]
        variables += variables_for({k: v for k, v in quantities.items() if k in self._placed})
        if settings is not None:  # the last quantity, but beside the pose, so that a series stands together
            numbers = np.arange(settings[0], settings[1] + 1.0)[:, None]
            variables.append(Variable((n_pose + len(load) + len(tilt),), Rows(numbers)))
        gene = len(variables) - 1
        variables += variables_for({k: v for k, v in quantities.items() if k not in self._placed})
        self.variables = tuple(variables)
        self._fixed = np.zeros(n_pose + len(load) + len(tilt) + (settings is not None))
        for column, quantity in quantities.items():
            self._fixed[column] = quantity.values[0] if isinstance(quantity, Choices) else quantity.low
        if candidates is not None:
            self._fixed[:n_pose] = candidates[0]
        self.lower = np.array([variable.bounds[0] for variable in variables])
        self.upper = np.array([variable.bounds[1] for variable in variables])
        self.columns = np.array([variable.columns[0] for variable in variables], dtype=np.int64)
        self.discrete: BoolArray = np.array([variable.discrete for variable in variables], dtype=bool)
        self.of_pose: BoolArray = np.array([variable.columns[0] in self._placed for variable in variables], dtype=bool)
        gene_steps = np.array([0.0 if v.discrete or steps is None else steps[v.columns[0]] for v in variables])
        self.grid = Grid(gene_steps, self.lower, self.upper)
        self.required = Required()
        physical = self.of_pose.copy()
        self.settings: PoseSettings | None = None
        if settings is not None:
            self.settings = PoseSettings(gene, physical, self.span, settings[1] > 0, None)
            self.of_pose = physical | (np.arange(len(variables)) == gene)

    @property
    def decisions(self) -> int:
        """Number of decisions of one measurement."""
        return len(self.variables)

    def different(self, quantities: range) -> float:
        """How many different values some quantities can take together; infinite where one of them is continuous."""
        count = 1.0
        for variable in self.variables:
            inside = [place for place, column in enumerate(variable.columns) if column in quantities]
            if inside:
                rows = variable.domain.table[:, inside] if isinstance(variable.domain, Rows) else None
                count *= np.inf if rows is None else len(np.unique(rows, axis=0))
        return count

    @property
    def span(self) -> FloatArray:
        """Range of each decision, 1 where there is none, shape (g,)."""
        return np.where(self.upper > self.lower, self.upper - self.lower, 1.0)

    @property
    def ranges(self) -> tuple[FloatArray, FloatArray]:
        """Smallest and largest value of every quantity, shapes (n_q,)."""
        low, high = self._fixed.copy(), self._fixed.copy()
        for variable in self.variables:
            columns = list(variable.columns)
            rows = variable.domain.table if isinstance(variable.domain, Rows) else np.array([variable.bounds]).T
            low[columns], high[columns] = rows.min(axis=0), rows.max(axis=0)
        return low, high

    @property
    def tilts(self) -> bool:
        """Whether the base is, or can be, tilted."""
        return any(not isinstance(q, Interval) or q.low != 0.0 or q.high != 0.0 for q in self._tilt)

    def alone(self) -> "DesignSpace":
        """The space of single measurements, of which nothing is demanded."""
        other = copy.copy(self)
        other.measurements, other.required, other.settings = 1, Required(), None
        return other

    @property
    def choices(self) -> BoolArray:
        """Which decisions are between values that gradients cannot choose, shape (g,); settings are none."""
        found: BoolArray = self.discrete.copy()
        if self.settings is not None:
            found[self.settings.gene] = False
        return found

    def taken(self, decisions: FloatArray) -> BoolArray:
        """Which measurements (..., g) are taken."""
        if self.settings is None:
            return np.ones(decisions.shape[:-1], dtype=bool)
        return self.settings.taken(decisions)

    def placed(self, quantities: FloatArray) -> FloatArray:
        """What of quantities (..., n_q) a series has in common: the pose, and the tilt where settings count."""
        return quantities[..., self._placed]

    def series(self, quantities: FloatArray) -> IntArray | None:
        """Series numbers (..., m) of measurements with quantities (..., m, n_q), 0 for those that are left out; None
        where there is no decision about settings.
        """
        if self.settings is None:
            return None
        number = quantities[..., -1]
        numbers = series_by_pose(np.concatenate([self.placed(quantities), number[..., None]], axis=-1))
        return np.where(number >= 0.0, numbers, 0)

    def quantities(self, decisions: FloatArray) -> FloatArray:
        """Quantities (..., n_q) that decisions (..., g) stand for; indices are rounded and clipped to their tables."""
        values = np.broadcast_to(self._fixed, (*decisions.shape[:-1], len(self._fixed))).copy()
        for decision, variable in enumerate(self.variables):
            if isinstance(variable.domain, Rows):
                index = np.clip(np.rint(decisions[..., decision]), 0, len(variable.domain.table) - 1).astype(np.int64)
                values[..., list(variable.columns)] = variable.domain.table[index]
            else:
                values[..., variable.columns[0]] = decisions[..., decision]
        return values

    @cached_property
    def _tilted(self) -> BatchFunction:
        return tilted_gravity(np.asarray(self.gravity))

    def decode(self, decisions: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Configurations (..., n) and load parameters with gravity (..., k) that decisions (..., g) stand for."""
        return self.split(self.quantities(decisions))

    def split(self, values: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Configurations (..., n) and load parameters with gravity (..., k) of quantities (..., n_q)."""
        poses = values[..., : self.n_pose]
        loads = values[..., self.n_pose : self.n_pose + self.n_load]
        if self.gravity is None:
            return poses, loads
        gravity = np.broadcast_to(self.gravity, (*loads.shape[:-1], len(self.gravity)))
        if self.tilts:
            start = self.n_pose + self.n_load
            (gravity,) = self._tilted(values[..., start : start + len(self._tilt)])
        return poses, np.concatenate([loads, gravity], axis=-1)

    def sample(self, count: int, generator: np.random.Generator) -> FloatArray:
        """Uniformly drawn measurements, shape (count, g)."""
        uniform = generator.random((count, self.decisions))
        continuous = self.lower + uniform * (self.upper - self.lower)
        indices = np.minimum(np.floor(uniform * (self.upper + 1.0)), self.upper)
        drawn = np.where(self.discrete, indices, continuous)
        if self.settings is not None:
            drawn[:, self.settings.gene] = self.settings.first
        return drawn

    def canonical(self, decisions: FloatArray) -> FloatArray:
        """The same designs (b, m, g) as they can be set: indices and steps rounded, and measurements sorted.

        The order of the measurements carries no information; the pose comes first, so that equal poses stand together.
        """
        return self._sorted(self._rounded(decisions))

    def settable(self, decisions: FloatArray, excess: Callable[[FloatArray], FloatArray]) -> FloatArray:
        """`canonical` designs (b, m, g) which rounding does not take beyond limits.

        Args:
            decisions: shape (b, m, g).
            excess: over the robot's limits, of configurations (..., n_q); at most 0 within.
        """
        rounded = self._rounded(decisions)
        beyond = excess(self.decode(rounded)[0]) > 0.0
        if beyond.any():
            wanted = np.clip(decisions[beyond], self.lower, self.upper)
            within = excess(self.decode(wanted)[0]) <= 0.0
            rows = np.argwhere(beyond)[within]
            moved = self.grid.inward(
                rounded[tuple(rows.T)], wanted[within], self.of_pose, lambda tried: excess(self.decode(tried)[0])
            )
            rounded[tuple(rows.T)] = moved
            rounded = self._arranged(rounded)
        return self._sorted(rounded)

    def _rounded(self, decisions: FloatArray) -> FloatArray:
        rounded = np.where(self.discrete, np.rint(decisions), decisions)
        rounded = self.grid.nearest(np.clip(rounded, self.lower, self.upper))
        whole = decisions.shape[-2] == self.measurements  # a part of a design need not meet what the whole has to
        for demanded in (self.required.poses, self.required.masses) if whole else ():
            rounded = self._with(demanded, rounded)
        return self._arranged(rounded)

    def _arranged(self, decisions: FloatArray) -> FloatArray:
        if self.settings is None or decisions.shape[-2] != self.measurements:
            return decisions
        flat = decisions.reshape(-1, *decisions.shape[-2:])
        return self.settings.arranged(flat).reshape(decisions.shape) if len(flat) else decisions

    def _with(self, demanded: tuple[FloatArray, ...], decisions: FloatArray) -> FloatArray:
        """Designs (..., m, g) in which every demand is met by the nearest measurement that meets no other one."""
        if not demanded or not self.decisions:
            return decisions
        flat = decisions.reshape(-1, *decisions.shape[-2:])
        free = np.ones(flat.shape[:2], dtype=bool)
        designs = np.arange(len(flat))
        for wanted in demanded:
            matters = ~np.isnan(wanted)
            distance = (((flat - np.where(matters, wanted, 0.0)) / self.span)[..., matters] ** 2).sum(axis=-1)
            nearest = np.argmin(np.where(free, distance, np.inf), axis=1)
            flat[designs, nearest] = np.where(matters, wanted, flat[designs, nearest])
            if self.settings is not None:
                gene = self.settings.gene
                flat[designs, nearest, gene] = np.maximum(flat[designs, nearest, gene], self.settings.first)
            free[designs, nearest] = False
        return flat.reshape(decisions.shape)

    def anew(self, decisions: FloatArray) -> FloatArray:
        """Measurements (..., g) at their poses, set anew."""
        found = decisions.copy()
        if self.settings is not None:
            found[..., self.settings.gene] = self.upper[self.settings.gene]
        return found

    def decisions_of(self, wanted: FloatArray, first: int) -> FloatArray | None:
        """Decisions (g,) at which quantities from `first` on are as wanted, NaN for the others; None without any."""
        decisions = np.full(self.decisions, np.nan)
        reached = self._fixed[first : first + len(wanted)].copy()
        for decision, variable in enumerate(self.variables):
            columns = [column for column in variable.columns if first <= column < first + len(wanted)]
            if not columns:
                continue
            values = wanted[[column - first for column in columns]]
            if isinstance(variable.domain, Rows):
                row = int(np.argmin(np.abs(variable.domain.table[:, : len(columns)] - values).max(axis=1)))
                decisions[decision] = row
                reached[[column - first for column in columns]] = variable.domain.table[row, : len(columns)]
            else:
                decisions[decision] = np.clip(values[0], self.lower[decision], self.upper[decision])
                reached[columns[0] - first] = decisions[decision]
        return decisions if np.abs(reached - wanted).max() <= 1e-12 else None

    def _sorted(self, rounded: FloatArray) -> FloatArray:
        if self.decisions:
            order = np.lexsort(np.moveaxis(rounded[..., ::-1], -1, 0), axis=-1)
            rounded = np.take_along_axis(rounded, order[..., None], axis=-2)
        whole = self.settings is not None and rounded.shape[-2] == self.measurements
        return self.settings.closed(rounded) if whole and self.settings is not None else rounded

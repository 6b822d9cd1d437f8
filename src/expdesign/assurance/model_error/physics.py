"""The physics that a plan or recordings might miss: every effect that the robot can have, at every start of its shapes.

`sizes_at_targets` has its sizes on one robot, in the units of the effects' parameters, and `Directions` how it moves
the readings and the targets, to first order. All physics without memory stands on one measurement chain, beside what is
known of the robot: one Jacobian of its reading then holds the directions of all of it. Physics with memory has kinks at
which it would disturb the derivatives of other physics, and stands on a chain of its own.
"""

from collections.abc import Collection, Hashable
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray, IntArray
from expdesign.assurance.model_error.settings import WHERE, Assumptions
from expdesign.chain.chain import Chain
from expdesign.chain.effect import Effect
from expdesign.chain.models.effect_entry import effect_classes
from expdesign.chain.readings.reading import DEFLECTION
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.row import RowData
from expdesign.chain.sizes import PhysicalSizes
from expdesign.errors import InputError
from expdesign.mechanics.elastostatics.maps import actuator_forces
from expdesign.mechanics.elastostatics.measurements import LoadedRobot
from expdesign.planning.problem import DesignProblem

MOST_STARTS = 8
"""Of one effect in a search: a periodic error has hundreds of pitches, of which these are spread over the range."""
_SAMPLE = 256
"""Random measurements that show which ranges the loads and the coordinates of a plan can have."""


@dataclass(frozen=True)
class Omitted:
    """One effect at one start of its shapes.

    Attributes:
        effect: the effect.
        start: its parameters, neutral except for shapes, shape (p,).
        step: of an effect with memory and one parameter, the prior size up to which its mean derivative is taken: much
            friction holds an actuator altogether, which little of it does not tell. 0 for the derivative at neutral.
    """

    effect: Effect
    start: FloatArray
    step: float = 0.0

    @cached_property
    def free(self) -> list[int]:
        """Indices of the parameters that are not shapes."""
        return [i for i, parameter in enumerate(self.effect.parameters) if not parameter.shape]

    @cached_property
    def key(self) -> tuple[str, str, str]:
        """Physics, component and variant."""
        return self.effect.physics, str(self.effect.component), str(self.effect.variant)

    def at(self, values: FloatArray | float) -> FloatArray:
        """Its parameters where those that are not shapes have some values (columns,), shape (p,)."""
        found = self.start.copy()
        found[self.free] += values
        return found


def offsets(physics: tuple[Omitted, ...]) -> IntArray:
    """First column of every entry, and the number of all columns, shape (E + 1,)."""
    return np.cumsum([0, *(len(entry.free) for entry in physics)], dtype=np.int64)


def left_out(
    problem: DesignProblem,
    points: LoadedPoints,
    assumptions: Assumptions,
    known: Collection[tuple[Hashable, ...]] = (),
) -> tuple[Omitted, ...]:
    """The effects that are considered, at their starts.

    Args:
        problem: whose robot may have them.
        points: that may show them.
        assumptions: which are considered, and how large they are.
        known: slots of effects that the model has.

    Raises:
        InputError: nothing is left to consider, or an identifier names physics that the robot cannot have here.
    """
    robot, sizes = problem.loaded.robot, sizes_at_targets(problem)
    effects = [e for kind in effect_classes() for e in kind.candidates(robot, points) if e.slot not in known]
    possible = {effect.physics for effect in effects}
    for name in sorted(set(assumptions.physics or ()) - possible):
        what = f"this robot with these loads cannot have `{name}`"
        remedy = f"Take it out, or choose among {', '.join(sorted(possible))}."
        raise InputError(what, where=f"{problem.source}, {WHERE}.physics", remedy=remedy)
    found = []
    for effect in effects:
        if not assumptions.considers(effect.physics):
            continue
        free = [parameter for parameter in effect.parameters if not parameter.shape]
        stepped = effect.states and len(free) == 1
        step = sizes.of(assumptions.size(effect, free[0]), effect, free[0]) if stepped else 0.0
        starts = effect.starts(points)
        chosen = np.unique(np.linspace(0, len(starts) - 1, min(MOST_STARTS, len(starts))).round().astype(int))
        found += [Omitted(effect, starts[i], step) for i in chosen]
    if not found:
        remedy = "Take entries out of `without`, or name physics under `physics`."
        raise InputError("no physics is left to consider", where=f"{problem.source}, {WHERE}", remedy=remedy)
    return tuple(found)


def sampled_points(problem: DesignProblem) -> LoadedPoints:
    """Points of plans of a design problem, the same for every plan.

    They have no times or temperatures: plans say nothing of effects that depend on these.
    """
    configurations, loads = problem.space.decode(problem.space.sample(_SAMPLE, np.random.default_rng(0)))
    return plan_points(problem.loaded, configurations, loads)


def plan_points(loaded: LoadedRobot, configurations: FloatArray, loads: FloatArray) -> LoadedPoints:
    """Points at configurations (m, n_q) under loads (m, k), each a series of its own."""
    robot, count = loaded.robot, len(configurations)
    wrenches = loaded.load.wrenches(robot.jacobians(configurations).rotation, loads)
    payload, gravity = loaded.load.payloads(loads), loaded.load.gravities(loads, robot.gravity)
    numbers = np.arange(1, count + 1)
    return LoadedPoints(
        source="plan", lines=numbers + 1, sequence=numbers, series=numbers, time=None, configurations=configurations,
        wrenches=wrenches, absolute=wrenches.copy(), payload=payload, gravity=gravity, temperature=None,
        leg_temperature=None, extra=pd.DataFrame(index=range(count)),
    )  # fmt: skip


def target_points(problem: DesignProblem, index: int) -> LoadedPoints:
    """A target as a point of its own series, relaxed and at the temperature of its reference."""
    loaded, parameters = problem.target_loads[index]
    return plan_points(loaded, problem.targets.configurations[index][None], parameters[None])


def sizes_at_targets(problem: DesignProblem, springs: FloatArray | None = None) -> PhysicalSizes:
    """What declared sizes of physics are on the robot of a problem, at its targets.

    Args:
        problem: with the targets.
        springs: weighted deflections of the targets per compliance in units of 1/apK, shape (q, n_p); None where no
            size is a multiple of them.
    """
    robot, targets = problem.loaded.robot, problem.targets.configurations
    forces = actuator_forces(robot.jacobians(targets), problem.target_wrenches)
    pairs = zip(targets, problem.target_loads, strict=True)
    measured = [loaded.measure(pose, load) for pose, (loaded, load) in pairs]
    mean = np.mean([np.diag(m.compliance) for m in measured], axis=0)
    return PhysicalSizes(robot, forces, mean, springs)


class Directions:
    """Derivatives of what a robot does with respect to the parameters of left-out physics that are not shapes.

    Args:
        base: the chain beside which the physics is left out; it ends with the instrument's reading.
        values: its parameters, shape (p,).
        physics: what is left out.
    """

    def __init__(self, base: Chain, values: FloatArray, physics: tuple[Omitted, ...]) -> None:
        self.base, self.values, self.physics = base, values, physics
        self._chains: dict[tuple[tuple[int, ...], bool], Chain] = {}

        def place(index: int) -> int:
            """What shares a number shares a chain: first what does not act on the reading, last physics with memory."""
            effect = physics[index].effect
            return index if effect.states else effect.changes_reading - 2

        ordered = sorted(range(len(physics)), key=place)
        self._groups = [tuple(group) for _, group in groupby(ordered, place)]
        start = offsets(physics)
        self._order: IntArray = np.argsort(np.concatenate([np.arange(start[i], start[i + 1]) for i in ordered]))

    def at(self, rows: RowData, *, platform: bool = False) -> FloatArray:
        """Derivatives of readings, or of the platform's motion, with respect to the physics, shape (N, r, D)."""
        found = [self._of(group, rows, platform=platform) for group in self._groups]
        return np.concatenate(found, axis=-1)[..., self._order]

    def change(self, index: int, rows: RowData, size: float, *, platform: bool) -> FloatArray:
        """What physics with a step changes at a size in its prior ones: readings, or the platform's motion, (N, r)."""
        chain, entry = self._chain((index,), platform=platform), self.physics[index]
        end, start = (
            chain.predict(rows, np.concatenate([self.values, entry.at(moved)])) for moved in (size * entry.step, 0.0)
        )
        return end - start

    def _chain(self, group: tuple[int, ...], *, platform: bool) -> Chain:
        """The chain of a group, which ends with the reading or with the motion of the platform."""
        effects = (*self.base.effects, *(self.physics[index].effect for index in group))
        # Where nothing acts on the reading of a deflection it is the motion of the platform.
        reads = self.base.reading is not DEFLECTION or any(effect.changes_reading for effect in effects)
        key = group, not (platform and reads)
        if key not in self._chains:
            self._chains[key] = Chain(self.base.robot, effects, instrument=key[1], reading=self.base.reading)
        return self._chains[key]

    def _of(self, group: tuple[int, ...], rows: RowData, *, platform: bool) -> FloatArray:
        """Derivatives with respect to the parameters of a group, shape (N, r, columns)."""
        entries, known = [self.physics[index] for index in group], len(self.values)
        if entries[0].step:
            return self.change(group[0], rows, 1.0, platform=platform)[..., None] / entries[0].step
        chain = self._chain(group, platform=platform)
        free = [i for i, parameter in enumerate(chain.parameters) if i >= known and not parameter.shape]
        values = np.concatenate([self.values, *(entry.start for entry in entries)])
        return chain.sensitivities(rows, values)[..., free]

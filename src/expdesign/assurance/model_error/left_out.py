"""The physics that a plan might miss: every effect that the robot can have, at every start of its shapes.

`PriorSizes` has its sizes on one robot, in the units of the effects' parameters, and `Directions` how it moves the
readings and the targets, to first order. All physics without memory stands on one measurement chain, beside what is
known of the robot: one Jacobian of its reading then holds the directions of all of it. Physics with memory has kinks at
which it would disturb the derivatives of other physics, and stands on a chain of its own.
"""

from collections.abc import Hashable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray, IntArray
from expdesign.assurance.model_error.settings import WHERE, Assumptions
from expdesign.chain.chain import Chain
from expdesign.chain.effect import Effect, Parameter
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

    @property
    def stepped(self) -> FloatArray:
        """The parameters up to which the mean derivative is taken, shape (p,)."""
        values = self.start.copy()
        values[self.free] += self.step
        return values

    @cached_property
    def columns(self) -> int:
        """Number of parameters that are not shapes."""
        return len(self.free)

    @cached_property
    def key(self) -> tuple[str, str, str]:
        """Physics, component and variant."""
        return self.effect.physics, str(self.effect.component), str(self.effect.variant)


def offsets(physics: tuple[Omitted, ...]) -> IntArray:
    """First column of every entry, and the number of all columns, shape (E + 1,)."""
    return np.cumsum([0, *(entry.columns for entry in physics)], dtype=np.int64)


def left_out(effects: list[Effect], points: LoadedPoints, assumptions: Assumptions) -> tuple[Omitted, ...]:
    """The effects that are considered, at their starts.

    Raises:
        InputError: nothing is left to consider, or an identifier names physics that the robot cannot have here.
    """
    known = {effect.physics for effect in effects}
    for name in sorted((assumptions.physics or frozenset()) - known):
        what = f"this robot with these loads cannot have `{name}`"
        remedy = f"Take it out, or choose among {', '.join(sorted(known))}."
        raise InputError(what, where=f"{WHERE}.physics", remedy=remedy)
    found = []
    for effect in effects:
        if not assumptions.considers(effect.physics):
            continue
        starts = effect.starts(points)
        chosen = np.unique(np.linspace(0, len(starts) - 1, min(MOST_STARTS, len(starts))).round().astype(int))
        found += [Omitted(effect, starts[i]) for i in chosen]
    if not found:
        remedy = "Take entries out of `without`, or name physics under `physics`."
        raise InputError("no physics is left to consider", where=WHERE, remedy=remedy)
    return tuple(found)


def effects_of_problem(problem: DesignProblem) -> tuple[list[Effect], LoadedPoints]:
    """Effects that plans of a design problem might miss, the same for every plan, and points of such plans.

    Effects that depend on the time or the temperature of a measurement are not among them: plans say nothing of them.
    """
    generator = np.random.default_rng(0)
    configurations, loads = problem.space.decode(problem.space.sample(_SAMPLE, generator))
    points = plan_points(problem.loaded, configurations, loads)
    robot = problem.loaded.robot
    found = None if problem.found is None else problem.found.physics
    known: set[tuple[Hashable, ...]] = set() if found is None else {effect.slot for effect in found.chain.effects}
    effects = [e for kind in effect_classes() for e in kind.candidates(robot, points) if e.slot not in known]
    return effects, points


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


class PriorSizes:
    """Prior sizes on the robot of a problem, at its targets.

    Args:
        problem: whose robot and targets the sizes may be multiples of.
        assumptions: with sizes in place of the declared ones.
        springs: weighted deflections of the targets per compliance in units of 1/apK, shape (q, n_p); none where no
            size is a multiple of them.
    """

    def __init__(self, problem: DesignProblem, assumptions: Assumptions, springs: FloatArray | None = None) -> None:
        robot, targets = problem.loaded.robot, problem.targets.configurations
        forces = actuator_forces(robot.jacobians(targets), problem.target_wrenches)
        pairs = zip(targets, problem.target_loads, strict=True)
        measured = [loaded.measure(pose, load) for pose, (loaded, load) in pairs]
        mean = np.mean([np.diag(m.compliance) for m in measured], axis=0)
        self.assumptions = assumptions
        self._springs = np.zeros((1, len(robot.stiffness))) if springs is None else springs
        self._sizes = PhysicalSizes(robot, forces, mean, self._springs)

    def of(self, effect: Effect, parameter: Parameter, moved: FloatArray | None = None) -> float:
        """σ of one parameter, of which one unit moves the weighted deflections by so much, shape (q,)."""
        moved = np.zeros(len(self._springs)) if moved is None else moved
        return self._sizes.of(self.assumptions.size(effect, parameter), effect, parameter, moved)


def prior_deviations(
    problem: DesignProblem, physics: tuple[Omitted, ...], assumptions: Assumptions, errors: FloatArray
) -> FloatArray:
    """σ of every column of `physics`, shape (D,), from weighted deflections per compliance and column (q, n_p + D)."""
    base, moved = np.split(errors, [len(problem.loaded.robot.stiffness)], axis=1)
    sizes = PriorSizes(problem, assumptions, base)
    parameters = [(entry.effect, entry.effect.parameters[index]) for entry in physics for index in entry.free]
    return np.array([sizes.of(*each, column) for each, column in zip(parameters, moved.T, strict=True)])


def with_steps(problem: DesignProblem, physics: tuple[Omitted, ...], assumptions: Assumptions) -> tuple[Omitted, ...]:
    """The entries, those with memory and one parameter with the prior size of that parameter as their step."""
    sizes = PriorSizes(problem, assumptions)
    return tuple(
        replace(entry, step=sizes.of(entry.effect, entry.effect.parameters[entry.free[0]]))
        if entry.effect.states and entry.columns == 1
        else entry
        for entry in physics
    )


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

    def at(self, rows: RowData) -> tuple[FloatArray, FloatArray]:
        """Derivatives of readings with respect to the base's parameters (N, r, p) and to the physics (N, r, D)."""
        groups = self._groups()
        found = [self._of(group, rows, platform=False) for group in groups]
        return found[0][..., : len(self.values)], self._gathered(groups, found)

    def of_platform(self, rows: RowData) -> FloatArray:
        """Derivatives of the motion of the platform with respect to the physics, shape (N, n, D)."""
        groups = self._groups()
        return self._gathered(groups, [self._of(group, rows, platform=True) for group in groups])

    def change(self, index: int, rows: RowData, size: float, *, platform: bool) -> FloatArray:
        """What physics with a step changes at a size in its prior ones: readings, or the platform's motion, (N, r)."""
        chain, entry = self._chain((index,), platform=platform), self.physics[index]
        start = np.concatenate([self.values, entry.start])
        end = np.concatenate([self.values, entry.start + size * (entry.stepped - entry.start)])
        return chain.predict(rows, end) - chain.predict(rows, start)

    def _groups(self) -> list[tuple[int, ...]]:
        """Indices of physics that stands on one chain, first that without memory which does not act on the reading."""
        plain, read, alone = list[int](), list[int](), list[tuple[int, ...]]()
        for index, entry in enumerate(self.physics):
            if entry.effect.states:
                alone.append((index,))
            else:
                (read if entry.effect.changes_reading else plain).append(index)
        return [tuple(plain), *([tuple(read)] if read else []), *alone]

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
        """Derivatives with respect to the base's parameters and those of a group, shape (N, r, p + columns)."""
        entries, known = [self.physics[index] for index in group], len(self.values)
        if entries and entries[0].step:
            mean = self.change(group[0], rows, 1.0, platform=platform)[..., None] / entries[0].step
            return np.concatenate([np.zeros((*mean.shape[:2], known)), mean], axis=-1)
        chain = self._chain(group, platform=platform)
        values = np.concatenate([self.values, *(entry.start for entry in entries)])
        free = [i for i, parameter in enumerate(chain.parameters) if i < known or not parameter.shape]
        return chain.predict_with_sensitivities(rows, values)[1][..., free]

    def _gathered(self, groups: list[tuple[int, ...]], found: list[FloatArray]) -> FloatArray:
        """The columns of all groups in the order of the physics."""
        start: IntArray = offsets(self.physics)
        whole = np.empty((*found[0].shape[:2], int(start[-1])))
        for group, columns in zip(groups, found, strict=True):
            chosen = [np.arange(start[i], start[i + 1]) for i in group]
            if chosen:
                whole[..., np.concatenate(chosen)] = columns[..., len(self.values) :]
        return whole

"""The physics that a plan might miss: every effect that the robot can have, at every start of its shapes."""

from collections.abc import Hashable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray, IntArray
from expdesign.assurance.model_error.settings import WHERE, Assumptions
from expdesign.chain.effect import Effect
from expdesign.chain.models.effect_entry import effect_classes
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.errors import InputError
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
    wrenches = loaded.wrenches(robot.jacobians(configurations).rotation, loads)[0]
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

"""The library of physics that a diagnosis considers, and what each entry would do to the readings."""

from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, replace
from itertools import compress

import casadi as ca
import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray, as_matrix
from expdesign.chain.chain import Chain
from expdesign.chain.effect import Effect
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.row import RowData
from expdesign.chain.sizes import PhysicalSizes
from expdesign.diagnosis.evidence.columns import Dense, along
from expdesign.errors import InputError
from expdesign.estimation.fit import Data, Fit
from expdesign.mechanics.elastostatics.maps import actuator_forces
from expdesign.mechanics.robots.robot import Robot
from expdesign.mechanics.symbolic import BatchFunction
from expdesign.plugins import implementations

OUTLIER = "outlier"
"""Identifier of single wrong rows, which are no effect of the chain."""
_FEW_STARTS = 1
"""Starts of an effect up to which it is evaluated with those that have one."""


def library(robot: Robot, points: LoadedPoints, *, without: frozenset[str] = frozenset()) -> list[Effect]:
    """Every effect at every place that these recordings could show, in a fixed order.

    Args:
        robot: the robot.
        points: the recordings.
        without: identifiers of physics that are left out.

    Raises:
        InputError: no physics has such an identifier.
    """
    kinds = implementations("expdesign.chain.effects", Effect)
    unknown = without - {kind.physics for kind in kinds} - {OUTLIER}
    if unknown:
        what = f"no physics is called {', '.join(f'`{name}`' for name in sorted(unknown))}"
        raise InputError(what, where="without", remedy="Take identifiers from file-formats.md, Identifiers of physics.")
    return [effect for kind in kinds if kind.physics not in without for effect in kind.candidates(robot, points)]


@dataclass(frozen=True)
class Candidate:
    """An effect and the directions in which it moves the readings, to first order.

    Attributes:
        effect: the effect.
        starts: internal parameters, one row per set of shapes from which a fit would start, shape (G, p).
        directions: of every start whitened derivatives of the M readings with respect to the d parameters that are not
            shapes, at neutral parameters; from a start away from neutral the mean derivative up to it.
        one_sided: which of these parameters cannot be negative, shape (d,).
        places: number of places at which the library looks for the same physics.
    """

    effect: Effect
    starts: FloatArray
    directions: tuple[Dense, ...]
    one_sided: BoolArray
    places: int

    @property
    def idle(self) -> bool:
        """Whether the effect does nothing to the base model, as an effect of the load on a body that does not yield."""
        return not any(np.any(columns.whole) for columns in self.directions)


def physical_sizes(robot: Robot, sample: Data, base: Fit) -> PhysicalSizes:
    """Declared sizes at the recorded poses and loads, beside a base model."""
    recordings = sample.recordings
    jacobians = robot.jacobians(recordings.configurations)
    forces = actuator_forces(jacobians, recordings.wrenches)
    compliance = np.einsum("nij,j,nij->ni", jacobians.pose, robot.compliance, jacobians.pose).mean(axis=0)
    springs = as_matrix(base.sensitivities)[:, : len(robot.stiffness)]
    return PhysicalSizes(robot, forces, compliance, springs[sample.kept])


def candidates(
    effects: list[Effect],
    sample: Data,
    robot: Robot,
    base: FloatArray,
) -> list[Candidate]:
    """Candidates with their directions.

    Args:
        effects: of the library.
        sample: the rows that count.
        robot: the robot.
        base: parameters of the base model, compliances first, shape (b,).
    """
    counts: dict[str, int] = {}
    for effect in effects:
        counts[effect.physics] = counts.get(effect.physics, 0) + 1
    all_starts = [_starts(effect, sample) for effect in effects]
    found = []
    for effect, starts, directions in zip(
        effects, all_starts, _all(effects, all_starts, sample, robot, base), strict=True
    ):
        free = [p for p in effect.parameters if not p.shape]
        one_sided: BoolArray = np.array([p.low >= p.neutral for p in free], dtype=bool)
        usable: BoolArray = np.array([columns.finite for columns in directions], dtype=bool)
        if usable.any():
            # A search over pitches or time constants looks at as many places as it has starts.
            shapes = np.unique(starts[usable][:, [p.shape for p in effect.parameters]], axis=0)
            places = counts[effect.physics] * len(shapes)
            seen = tuple(compress(directions, usable))
            found.append(Candidate(effect, starts[usable], seen, one_sided, places))
    return found


def beside(candidate: Candidate, present: Fit, sample: Data, robot: Robot) -> Candidate:
    """A candidate that is idle beside the base model, with its directions beside the effects of a fitted model."""
    effect = candidate.effect
    starts, chain = candidate.starts, present.chain
    if effect.states or chain.states:
        directions = _with_memory(effect, starts, sample, robot, present.values, chain.effects)
    else:
        (directions,) = _without_memory([effect], [starts], sample, robot, present.values, chain.effects)
    return replace(candidate, directions=tuple(directions))


def _starts(effect: Effect, sample: Data) -> FloatArray:
    """Internal parameters from which a fit would start, shape (G, p)."""
    found = effect.starts(sample.recordings) + effect.large_starts(sample.recordings)
    return np.array(found).reshape(-1, len(effect.parameters))


def _free(effect: Effect) -> BoolArray:
    """Which parameters are no shapes, (p,)."""
    return np.array([not p.shape for p in effect.parameters], dtype=bool)


def _all(
    effects: Sequence[Effect], starts: Sequence[FloatArray], sample: Data, robot: Robot, base: FloatArray
) -> list[list[Dense]]:
    """Directions of all effects at every start.

    Effects without memory that do nothing at their starts do nothing to each other's derivatives there, which one
    chain of all of them gives at once; those with a few starts and with many apart, which all are evaluated as often.
    """
    kinds: dict[Hashable, list[int]] = {}
    found: dict[int, list[Dense]] = {}
    for index, (effect, own) in enumerate(zip(effects, starts, strict=True)):
        if effect.states:
            found[index] = _with_memory(effect, own, sample, robot, base)
            continue
        free = _free(effect)
        rests = bool((own[:, free] == effect.neutral()[free]).all())
        kinds.setdefault(("rests", len(own) > _FEW_STARTS) if rests else index, []).append(index)
    for members in kinds.values():
        chosen, their = [effects[i] for i in members], [starts[i] for i in members]
        directions = _without_memory(chosen, their, sample, robot, base)
        if len(members) > 1 and not all(columns.finite for each in directions for columns in each):
            # What is not finite of one effect spoils the others.
            alone = [_without_memory([e], [s], sample, robot, base) for e, s in zip(chosen, their, strict=True)]
            directions = [one for (one,) in alone]
        found |= dict(zip(members, directions, strict=True))
    return [found[index] for index in range(len(effects))]


def _without_memory(
    effects: Sequence[Effect],
    starts: Sequence[FloatArray],
    sample: Data,
    robot: Robot,
    compliances: FloatArray,
    present: tuple[Effect, ...] = (),
) -> list[list[Dense]]:
    """Whitened directions of each effect at each of its starts (G, p), beside effects that are `present`.

    The parameters of these follow the compliances.
    """
    axes = sample.recordings.axes
    chain, compliances = sample.held(robot, (*present, *effects), compliances)
    frees = [_free(effect) for effect in effects]
    columns = len(compliances) + np.flatnonzero(np.concatenate(frees))
    derivative = _derivative(chain, columns, often=max(map(len, starts)) > 1)
    ends = np.cumsum([free.sum() for free in frees])[:-1]
    found: list[list[Dense]] = [[] for _ in effects]
    vectors: list[FloatArray | None] = [None for _ in effects]
    for number in range(max(map(len, starts))):
        at = [own[min(number, len(own) - 1)] for own in starts]
        slopes = derivative(sample.rows, np.concatenate([compliances, *at]))
        seen = sample.whiten(slopes[:, axes])
        for index, block in enumerate(np.split(seen, ends, axis=2)):
            if number < len(starts[index]):
                several = len(starts[index]) > 1
                directions, vectors[index] = along(block, vectors[index]) if several else (_dense(block), None)
                found[index].append(directions)
    return found


def _dense(block: FloatArray) -> Dense:
    """Columns (N, k, d) as they are."""
    return Dense(block.reshape(-1, block.shape[-1]))


def _derivative(chain: Chain, columns: IntArray, *, often: bool) -> Callable[[RowData, FloatArray], FloatArray]:
    """Derivatives (N, n, d) of a chain without memory with respect to some parameters (d,), asked for once or often."""
    if not often:
        return lambda rows, values: chain.sensitivities(rows, values)[..., columns]
    row, theta = chain.row_symbols(), ca.SX.sym("theta", len(chain.parameters))
    reading, _ = chain.expression(row, ca.SX.zeros(0), theta)
    derivative = ca.jacobian(reading, theta)[:, columns.tolist()]
    function = BatchFunction("directions", [row.flat(), theta], [derivative])
    return lambda rows, values: function(rows.values, values)[0].reshape(len(rows), -1, len(columns))


def _with_memory(
    effect: Effect,
    starts: FloatArray,
    sample: Data,
    robot: Robot,
    compliances: FloatArray,
    present: tuple[Effect, ...] = (),
) -> list[Dense]:
    """The same of one effect at its starts, where it or what is present may remember."""
    axes, free, neutral = sample.recordings.axes, _free(effect), effect.neutral()
    chain, compliances = sample.held(robot, (*present, effect), compliances)
    blocks = []
    for start in starts:
        values = np.concatenate([compliances, start])
        away = start[free] - neutral[free]
        if away.any():
            rest = np.concatenate([compliances, np.where(free, neutral, start)])
            change = chain.predict(sample.rows, values) - chain.predict(sample.rows, rest)
            blocks.append((change[:, axes] / away)[:, :, None])
        else:
            sensitivities = chain.predict_with_sensitivities(sample.rows, values)[1]
            blocks.append(sensitivities[:, axes][:, :, len(compliances) :][:, :, free])
    return [_dense(sample.whiten(block)) for block in blocks]

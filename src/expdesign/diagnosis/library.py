"""The library of physics that a diagnosis considers, and what each entry would do to the readings."""

from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from expdesign.arrays import BoolArray, FloatArray
from expdesign.chain.effect import Effect
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.diagnosis.sample import Sample
from expdesign.errors import InputError
from expdesign.estimation.fit import Fit
from expdesign.mechanics.robots.robot import Robot
from expdesign.mechanics.symbolic import BatchFunction
from expdesign.plugins import implementations

OUTLIER = "outlier"
"""Identifier of single wrong rows, which are no effect of the chain."""


def library(robot: Robot, points: LoadedPoints, *, without: frozenset[str] = frozenset()) -> list[Effect]:
    """Every effect at every place that these recordings could show, in a fixed order.

    Args:
        robot: the robot.
        points: the recordings.
        without: identifiers of physics that are left out.

    Raises:
        InputError: no physics has such an identifier.
    """
    kinds = implementations("expdesign.chain.effects", Effect)  # type: ignore[type-abstract]
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
        directions: whitened derivatives of the readings with respect to the parameters that are not shapes, at neutral
            parameters, shape (G, M, d) with M readings; from a start away from neutral the mean derivative up to it.
        one_sided: which of these parameters cannot be negative, shape (d,).
        places: number of places at which the library looks for the same physics.
    """

    effect: Effect
    starts: FloatArray
    directions: FloatArray
    one_sided: BoolArray
    places: int

    @property
    def idle(self) -> bool:
        """Whether the effect does nothing to the base model, as an effect of the load on a body that does not yield."""
        return not np.any(self.directions)


def candidates(
    effects: list[Effect],
    sample: Sample,
    robot: Robot,
    base: FloatArray,
    basis: FloatArray | None = None,
) -> list[Candidate]:
    """Candidates with their directions.

    Args:
        effects: of the library.
        sample: the rows that count.
        robot: the robot.
        base: parameters of the base model, compliances first, shape (b,).
        basis: of what the base model itself can do (M, r); what it can do as well is not counted as seen.
    """
    counts: dict[str, int] = {}
    for effect in effects:
        counts[effect.physics] = counts.get(effect.physics, 0) + 1
    found = []
    for effect in effects:
        all_starts = effect.starts(sample.recordings) + effect.large_starts(sample.recordings)
        starts = np.array(all_starts).reshape(-1, len(effect.parameters))
        directions = _directions(effect, starts, sample, robot, base)
        free = [p for p in effect.parameters if not p.shape]
        one_sided: BoolArray = np.array([p.low >= p.neutral for p in free], dtype=bool)
        usable = np.isfinite(directions).all(axis=(1, 2))
        if usable.any():
            # A search over pitches or time constants looks at as many places as it has starts.
            shapes = np.unique(starts[usable][:, [p.shape for p in effect.parameters]], axis=0)
            places = counts[effect.physics] * len(shapes)
            found.append(Candidate(effect, starts[usable], directions[usable], one_sided, places))
    return found


def beside(candidate: Candidate, present: Fit, sample: Sample, robot: Robot) -> Candidate:
    """A candidate that is idle beside the base model, with its directions beside the effects of a fitted model."""
    effect = candidate.effect
    directions = _directions(effect, candidate.starts, sample, robot, present.values, present.chain.effects)
    return replace(candidate, directions=directions)


def _directions(
    effect: Effect,
    starts: FloatArray,
    sample: Sample,
    robot: Robot,
    compliances: FloatArray,
    present: tuple[Effect, ...] = (),
) -> FloatArray:
    """Whitened directions (G, M, d) at the starts (G, p), beside effects whose parameters follow the compliances."""
    axes = sample.recordings.axes
    free = np.array([not p.shape for p in effect.parameters])
    chain, compliances = sample.held(robot, (*present, effect), compliances)
    blocks = []
    if chain.states:
        neutral = effect.neutral()
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
    else:
        row = chain.row_symbols()
        theta = ca.SX.sym("theta", len(chain.parameters))
        reading, _ = chain.expression(row, ca.SX.zeros(0), theta)
        columns = [len(compliances) + int(i) for i in np.flatnonzero(free)]
        derivative = ca.jacobian(reading, theta)[:, columns]
        function = BatchFunction("direction", [row.flat(), theta], [derivative])
        for start in starts:
            values = np.concatenate([compliances, start])
            (sensitivities,) = function(sample.rows.values, values)
            blocks.append(sensitivities.reshape(len(sample.rows), -1, len(columns))[:, axes])
    return np.stack([sample.whiten(block).reshape(-1, block.shape[-1]) for block in blocks])

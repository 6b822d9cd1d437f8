"""MEIR of recordings as they were taken: what may still be hidden when the base model explains them.

Unlike a plan, recordings have series, times and temperatures: effects that depend on history are worked through them,
and drift can show. At the targets no time has passed, and what depends on history starts relaxed.
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import BoolArray, FloatArray
from expdesign.assurance.model_error.hidden import hidden_errors
from expdesign.assurance.model_error.left_out import Omitted, left_out, offsets
from expdesign.assurance.model_error.meir import Meir
from expdesign.assurance.model_error.prior import with_steps
from expdesign.assurance.model_error.settings import Assumptions
from expdesign.assurance.model_error.statement import HiddenPhysics, hidden_physics
from expdesign.chain.chain import Chain
from expdesign.chain.models.effect_entry import effect_classes
from expdesign.chain.readings.choice import reading_of
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.row import row_data
from expdesign.estimation.whitening import Whitening
from expdesign.mechanics.robots.robot import Robot
from expdesign.planning.problem import DesignProblem


@dataclass(frozen=True)
class HiddenByRecordings:
    """What recordings hide.

    Attributes:
        physics: every effect that was considered, the largest error first.
        freedom: degrees of freedom of their residuals; where there are none nothing could be noticed.
    """

    physics: tuple[HiddenPhysics, ...]
    freedom: int

    @property
    def meir(self) -> float:
        """The largest error at the targets, in tolerances."""
        return self.physics[0].error


def hidden_by(
    problem: DesignProblem,
    recordings: Recordings,
    deviations: FloatArray,
    assumptions: Assumptions | None = None,
    counts: BoolArray | None = None,
) -> HiddenByRecordings:
    """What physics may be there that recordings do not show, at the targets of a design problem.

    Args:
        problem: whose targets count.
        recordings: of its robot.
        deviations: standard deviations of the readings, shape (N, k).
        assumptions: of MEIR.
        counts: which rows were fitted, shape (N,); all that are not held out where it is not given.
    """
    assumptions = Assumptions() if assumptions is None else assumptions
    robot = problem.loaded.robot
    counts = ~recordings.test if counts is None else counts
    references = None if recordings.references is None else np.where(counts, recordings.references, "")
    whitening = Whitening(deviations, references=references)
    effects = [effect for kind in effect_classes() for effect in kind.candidates(robot, recordings)]
    physics = with_steps(problem, left_out(effects, recordings, assumptions), assumptions)
    base, directions = recorded_sensitivities(robot, recordings, physics, whitening, counts)
    meir = Meir(problem, assumptions, physics)
    errors, sizes, n_p = meir.scaled_errors, meir.deviations, len(robot.stiffness)
    # The instrument and its markers are estimated with the compliances, and move no target.
    beside = np.zeros((*errors.shape[:-1], base.shape[1] - n_p))
    errors = np.concatenate([errors[..., :n_p], beside, errors[..., n_p:]], axis=-1)
    hidden = hidden_errors(base[None], (directions * sizes)[None], errors, physics, assumptions)
    found = hidden_physics(hidden, physics, sizes)
    return HiddenByRecordings(found, int(hidden.freedom[0]))


def recorded_sensitivities(
    robot: Robot,
    recordings: Recordings,
    physics: tuple[Omitted, ...],
    whitening: Whitening,
    counts: BoolArray,
) -> tuple[FloatArray, FloatArray]:
    """Whitened sensitivities of the base model (M, b) and directions of the physics (M, D)."""
    rows, reading = row_data(recordings, robot), reading_of(robot, recordings)
    empty = Chain(robot, reading=reading)

    def rowwise(sensitivities: FloatArray) -> FloatArray:
        return whitening.apply(sensitivities)[counts].reshape(-1, sensitivities.shape[-1])

    def white(effects: tuple[Omitted, ...]) -> FloatArray:
        chain = Chain(robot, tuple(entry.effect for entry in effects), reading=reading)
        values = np.concatenate([empty.start(), *(entry.start for entry in effects)])
        if effects and effects[0].step:
            step = np.concatenate([np.zeros(chain.base), effects[0].stepped - effects[0].start])
            change = chain.predict(rows, values + step) - chain.predict(rows, values)
            mean = change[:, recordings.axes, None] / effects[0].step
            return np.hstack([np.zeros((int(counts.sum()) * mean.shape[1], empty.base)), rowwise(mean)])
        free = [i for i, parameter in enumerate(chain.parameters) if i < chain.base or not parameter.shape]
        sensitivities = chain.predict_with_sensitivities(rows, values)[1][:, recordings.axes][:, :, free]
        return rowwise(sensitivities)

    plain = tuple(entry for entry in physics if not entry.effect.states)
    together = white(plain)
    base, columns = together[:, : empty.base], iter(np.split(together[:, empty.base :], offsets(plain)[1:], axis=1))
    # One effect with memory has kinks at which it would disturb the derivatives of another.
    directions = [next(columns) if not e.effect.states else white((e,))[:, empty.base :] for e in physics]
    knowledge = empty.knowledge()
    stacked = np.concatenate(directions, axis=1)
    if knowledge is not None:
        known = np.diag(1.0 / knowledge[1])
        base = np.concatenate([base, known])
        stacked = np.concatenate([stacked, np.zeros((len(known), stacked.shape[1]))])
    return base, stacked

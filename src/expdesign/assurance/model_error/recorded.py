"""MEIR of recordings as they were taken: what may still be hidden when the base model explains them.

Unlike a plan, recordings have series, times and temperatures: effects that depend on history are worked through them,
and drift can show. At the targets no time has passed, and what depends on history starts relaxed.
"""

from collections.abc import Collection, Hashable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.assurance.model_error.hidden import hidden_errors
from expdesign.assurance.model_error.left_out import Directions, left_out, with_steps
from expdesign.assurance.model_error.meir import Meir, meir_of_problem
from expdesign.assurance.model_error.settings import Assumptions
from expdesign.assurance.model_error.statement import WhatIsHidden, hidden_physics
from expdesign.chain.chain import Chain
from expdesign.chain.models.effect_entry import effect_classes
from expdesign.chain.readings.choice import reading_of
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.row import row_data
from expdesign.estimation.whitening import Whitening
from expdesign.planning.problem import DesignProblem


@dataclass(frozen=True)
class AtSizes:
    """What physics does that is no multiple of its size, at K sizes: friction that holds a leg altogether.

    Attributes:
        shown: whitened changes of the readings, shape (K, M).
        motions: of the targets along the axes of the tolerances (m, rad), shape (K, t, n).
    """

    shown: FloatArray
    motions: FloatArray


@dataclass(frozen=True)
class Shown:
    """What recordings show of physics that a model leaves out.

    Attributes:
        meir: the physics, its prior sizes and what it does at the targets.
        base: whitened sensitivities of the base model, with what is known of its parameters, shape (M, b).
        directions: whitened, of the physics in units of its prior sizes, shape (M, D).
        at_sizes: by its index, physics that is known at the sizes that were asked for.
    """

    meir: Meir
    base: FloatArray
    directions: FloatArray
    at_sizes: Mapping[int, AtSizes] = field(default_factory=dict)

    def hidden(self) -> WhatIsHidden:
        """What the recordings hide, should the base model explain them."""
        meir, n_p = self.meir, len(self.meir.problem.loaded.robot.stiffness)
        # The instrument and its markers are estimated with the compliances, and move no target.
        beside = np.zeros((*meir.scaled_errors.shape[:-1], self.base.shape[1] - n_p))
        errors = np.concatenate([meir.scaled_errors[..., :n_p], beside, meir.scaled_errors[..., n_p:]], axis=-1)
        found = hidden_errors(self.base[None], self.directions[None], errors, meir.physics, meir.assumptions)
        worst = hidden_physics(found, meir.physics, meir.deviations)
        return WhatIsHidden(worst, int(found.freedom[0]), "these recordings")


def shown_by(
    problem: DesignProblem,
    recordings: Recordings,
    whitening: Whitening,
    assumptions: Assumptions | None = None,
    known: Collection[tuple[Hashable, ...]] = (),
    sizes: Sequence[float] = (),
) -> Shown:
    """What recordings show of the physics that a robot may have and a model leaves out.

    Args:
        problem: whose targets count.
        recordings: of its robot, the rows that were fitted.
        whitening: of these rows.
        assumptions: of MEIR; those of the problem where left out.
        known: slots of the physics that the model has.
        sizes: in prior ones, at which physics with memory and one parameter is worked through the recordings.

    Raises:
        InputError: no physics is left to consider.
    """
    robot, asked = problem.loaded.robot, meir_of_problem(problem)
    assumptions = assumptions or (Assumptions() if asked is None else asked.assumptions)
    effects = [e for kind in effect_classes() for e in kind.candidates(robot, recordings) if e.slot not in known]
    physics = with_steps(problem, left_out(effects, recordings, assumptions), assumptions)
    meir, chain = Meir(problem, assumptions, physics), Chain(robot, reading=reading_of(robot, recordings))
    directions = meir.directions if chain.linear and problem.found is None else None
    directions = directions or Directions(chain, chain.start(), physics)
    rows = row_data(recordings, robot)

    def white(readings: FloatArray) -> FloatArray:
        whitened = whitening.apply(readings[:, recordings.axes])
        return whitened.reshape(-1, *whitened.shape[2:])

    base, columns = (white(each) for each in directions.at(rows))
    at_sizes = {
        index: AtSizes(
            np.array([white(directions.change(index, rows, size, platform=False)) for size in sizes]),
            np.array([meir.moved_by(index, size) for size in sizes]),
        )
        for index, entry in enumerate(physics)
        if entry.step and len(sizes)
    }
    columns, knowledge = columns * meir.deviations, chain.knowledge()
    if knowledge is not None:
        prior = np.diag(1.0 / knowledge[1])
        base = np.concatenate([base, prior])
        columns = np.concatenate([columns, np.zeros((len(prior), columns.shape[1]))])
    return Shown(meir, base, columns, at_sizes)

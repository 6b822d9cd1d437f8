"""MEIR of recordings as they were taken: what may still be hidden when the base model explains them.

Unlike a plan, recordings have series, times and temperatures: effects that depend on history are worked through them,
and drift can show. At the targets no time has passed, and what depends on history starts relaxed.
"""

from collections.abc import Collection, Hashable, Sequence

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.assurance.model_error.meir import Meir, meir_of_problem
from expdesign.assurance.model_error.physics import Directions, left_out
from expdesign.assurance.model_error.settings import Assumptions
from expdesign.assurance.model_error.statement import WhatIsHidden
from expdesign.chain.chain import Chain
from expdesign.chain.readings.choice import reading_of
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.row import row_data
from expdesign.estimation.whitening import Whitening
from expdesign.planning.problem import DesignProblem


class Shown:
    """What recordings show of the physics that a robot may have and a model leaves out.

    Args:
        problem: whose targets count.
        recordings: of its robot, the rows that were fitted.
        whitening: of these rows.
        assumptions: of MEIR; those of the problem where left out.
        known: slots of the physics that the model has.

    Attributes:
        meir: the physics, its prior sizes and what it does at the targets.
        base: whitened sensitivities of the base model, with what is known of its parameters, shape (M, b).
        directions: whitened, of the physics in units of its prior sizes, shape (M, D).

    Raises:
        InputError: no physics is left to consider.
    """

    def __init__(
        self,
        problem: DesignProblem,
        recordings: Recordings,
        whitening: Whitening,
        assumptions: Assumptions | None = None,
        known: Collection[tuple[Hashable, ...]] = (),
    ) -> None:
        robot, asked = problem.loaded.robot, meir_of_problem(problem)
        assumptions = assumptions or (Assumptions() if asked is None else asked.assumptions)
        physics = left_out(problem, recordings, assumptions, known)
        self.meir, chain = Meir(problem, assumptions, physics), Chain(robot, reading=reading_of(robot, recordings))
        shared = chain.linear and problem.found is None
        self._directions = self.meir.directions if shared else Directions(chain, chain.start(), physics)
        self._recordings, self._whitening, self._rows = recordings, whitening, row_data(recordings, robot)
        base = self._white(chain.predict_with_sensitivities(self._rows, chain.start())[1])
        directions, knowledge = self._white(self._directions.at(self._rows)), chain.knowledge()
        prior = np.zeros((0, base.shape[1])) if knowledge is None else np.diag(1.0 / knowledge[1])
        self.base = np.concatenate([base, prior])
        beside = np.zeros((len(prior), directions.shape[1]))
        self.directions: FloatArray = np.concatenate([directions * self.meir.deviations, beside])

    def _white(self, readings: FloatArray) -> FloatArray:
        whitened = self._whitening.apply(readings[:, self._recordings.axes])
        return whitened.reshape(-1, *whitened.shape[2:])

    def at_sizes(self, index: int, sizes: Sequence[float]) -> tuple[FloatArray, FloatArray]:
        """What physics with a step does at K sizes in its prior ones, of which it is no multiple: friction that holds a
        leg altogether.

        Returns:
            Whitened changes of the readings, shape (K, M), and motions of the targets along the axes of the tolerances
            (m, rad), shape (K, t, n).
        """
        changes = [self._directions.change(index, self._rows, size, platform=False) for size in sizes]
        motions = [self.meir.moved_by(index, size) for size in sizes]
        return np.array([self._white(change) for change in changes]), np.array(motions)

    def hidden(self) -> WhatIsHidden:
        """What the recordings hide, should the base model explain them."""
        found = self.meir.hidden_from(self.base[None], self.directions[None])
        return WhatIsHidden.of(self.meir, found, "these recordings")

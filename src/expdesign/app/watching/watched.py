"""What is known of a run while it goes on, shared by the search, which writes it, and the page, which reads it.

The two are in different threads. The search only ever adds what it reports anyway, so that a run that is watched gives
the same results as one that is not, unless somebody ends it.
"""

import threading
import time
from typing import Any, Literal

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.planning.problem import DesignProblem
from expdesign.planning.search import Progress
from expdesign.report.design_figures import criterion_title

End = Literal["finished", "ended", "failed"]
"""A run finished by itself, was ended by hand, or has no result."""
_MOST_POINTS = 2000
"""Of the course of the hypervolume; of more, every second one is dropped."""


class Watched:
    """The state of one run.

    Args:
        problem: what is searched.
        folder: where the results will be, for the page to say.
    """

    def __init__(self, problem: DesignProblem, folder: str) -> None:
        self._lock = threading.Lock()
        self._started = time.monotonic()
        self._sign = np.array([-1.0 if one.maximise else 1.0 for one in problem.objectives])
        self._course: list[list[float]] = []
        self._wanted = False
        self._state: dict[str, Any] = {
            "title": problem.loaded.robot.name,
            "configuration": problem.source,
            "folder": folder,
            "objectives": [criterion_title(criterion.name) for criterion in problem.objectives],
            "stage": "starting",
            "done": 0,
            "total": 0,
            "note": "",
            "front": [],
            "hypervolume": None,
            "end": None,
            "message": "",
        }

    def follow(self, state: Progress) -> bool:
        """Take the state of the search; True where somebody wants it to end (for `search`)."""
        front: FloatArray = state.front[np.lexsort(state.front.T[::-1])] * self._sign
        with self._lock:
            self._state |= {"front": front.tolist(), "hypervolume": state.hypervolume}
            self._course.append([round(self._elapsed, 3), state.hypervolume])
            if len(self._course) > _MOST_POINTS:
                del self._course[1:-1:2]
            return self._wanted

    def stage(self, title: str, done: int, total: int, note: str) -> None:
        """Take the stage of the run (for `run`)."""
        with self._lock:
            self._state |= {"stage": title, "done": done, "total": total, "note": note}

    @property
    def wanted(self) -> bool:
        """Whether somebody wants it to end."""
        with self._lock:
            return self._wanted

    def end_it(self) -> None:
        """Somebody wants the search to end with what is there."""
        with self._lock:
            self._wanted = True

    def ended(self, how: End, message: str = "") -> None:
        """The run is over; `message` says why there is no result."""
        with self._lock:
            self._state |= {"end": how, "message": message, "elapsed_s": self._elapsed}

    def state(self) -> dict[str, Any]:
        """What the page shows."""
        with self._lock:
            known = {"elapsed_s": self._elapsed} | self._state
            return known | {"course": list(self._course), "ending": self._wanted}

    @property
    def _elapsed(self) -> float:
        return time.monotonic() - self._started

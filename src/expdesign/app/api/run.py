"""`run`: the Pareto front of a configuration."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Annotated, Any

from expdesign.app.api.arguments import Within
from expdesign.app.api.callbacks import Callback, shows_progress, silent
from expdesign.app.api.configuration import Config, problem_of
from expdesign.app.api.inputs import purpose_of
from expdesign.assurance.acceptance.planned import recommended_acceptance, with_recommended
from expdesign.assurance.model_error.statement import AccuracyStatement, hidden_by_plan
from expdesign.assurance.model_error.unseen import unseen_by
from expdesign.errors import InputError
from expdesign.planning.front import Front
from expdesign.planning.optimality.certificate import Certificate, LowerBound
from expdesign.planning.problem import DesignProblem
from expdesign.planning.result import design_minutes, run_record
from expdesign.planning.search import BY_HAND, Progress, search
from expdesign.planning.spending import spent, what_ends
from expdesign.report.acceptance_texts import acceptance_record
from expdesign.report.design_report import RunResult

Seconds = Annotated[float | None, Within("a time in s", "Use at least 0.", 0.0)]


@shows_progress("searching", "bounding")
def run(
    config: Config,
    *,
    callback: Callback | None = None,
    progress: bool = False,
    ended: Callable[[], bool] | None = None,
    seconds: Seconds = None,
    searched: Callable[[RunResult], None] | None = None,
) -> RunResult:
    """Find the Pareto front of DUIR against FEIR and the recommended plan.

    The front is that of the configuration's objectives; DUIR and the total error are bounded from below.

    Args:
        config: run configuration (YAML).
        callback: called with the stage, the steps done, the steps in all and a note (`Callback`).
        progress: whether progress is shown on standard error.
        ended: whether a person wants no more; asked before every evaluation of designs and in every round of bounding.
        seconds: time limit of the whole command in seconds, writing included; the best plans so far are kept. Without a
            limit, the same input gives the same front.
        searched: called with the plans of the run before they are bounded, so that they can be kept.

    Raises:
        InputError: the configuration is wrong, or leaves nothing to choose; or the search was ended before any plan
            was known.
        InfeasibleError: no pose is within the robot's limits.
        NotIdentifiableError: no design identifies what the targets need.

    Example:
        >>> result = xd.run("configs/bipod.yaml")
        >>> result.pareto.columns[:4].tolist()
        ['design', 'duir', 'feir', 'total']
        >>> bool(result.pareto["total"].min() < 1.13)  # tolerances
        True

    Command:
        Ctrl-C ends the search and keeps the front so far; the plan is written before its bound is computed.

        expdesign run configs/hexapod-h1.yaml --out results/mine
    """
    started = time.perf_counter()
    problem = problem_of(config)
    if problem.space.decisions == 0:
        what = "every pose and every load is fixed, so that there is nothing to choose"
        remedy = "Give an interval or a list of choices; `expdesign evaluate` judges a plan that is given."
        raise InputError(what, where=f"{problem.source}, experiment", remedy=remedy)
    limit = _Limit(seconds, started, ended or (lambda: False), callback or silent)
    problem, front = spent(problem, search(problem, limit.reported, ended=limit.searching))
    front = with_recommended(problem, front)
    purpose = purpose_of("run", config)
    unbounded = LowerBound(None, "not computed yet")
    first = _record(problem, front, unbounded, unbounded, limit.ended)
    (searched or silent)(RunResult(problem, front, first, purpose=purpose))
    duir, total = _bounds(problem, front, callback or silent, limit)
    unseen = None if limit.bounding() else unseen_by(problem, front.decisions[front.recommended])
    record = _record(problem, front, duir, total, limit.ended)
    if unseen is not None:
        record["unseen"] = unseen.record
    record["wall_s"] = time.perf_counter() - started
    return RunResult(problem, front, record, unseen, purpose=purpose)


class _Limit:
    """What ends a run before its own end: a person, or the clock."""

    def __init__(self, seconds: float | None, started: float, ended: Callable[[], bool], callback: Callback) -> None:
        self._started, self._of_processor = started, time.process_time()
        self._wanted, self._callback, self._seconds = ended, callback, seconds
        self._last = "the first designs"
        self.ended = ""

    def reported(self, state: Progress) -> bool:
        """Report; whether a person wants the search to end."""
        best = f"front {len(state.front)}, hypervolume {state.hypervolume:.6g}"
        self._callback("searching", state.generation, 0, f"{state.note}: {best}")
        self._last = f"generation {state.generation}, {state.note}"
        return bool(self.searching())

    def _over(self, kept: float, share: float) -> bool:
        """Whether no more is left of the time than so many seconds of the processor, or a share of it, take."""
        passed = time.perf_counter() - self._started
        if self._seconds is None or passed <= (1.0 - share) * self._seconds:
            return False
        # On a machine that does other things as well, writing takes longer too.
        slower = max(1.0, passed / max(time.process_time() - self._of_processor, 0.1))
        return passed > self._seconds - min(kept * slower, share * self._seconds)

    def searching(self) -> str:
        """Why the search is to end now; empty to go on."""
        by_clock = self._over(_BOUNDING + _WRITING, 0.5)
        if not by_clock and not self._wanted():
            return ""
        self.ended = self._last
        return "its time was over" if by_clock else BY_HAND

    def bounding(self) -> bool:
        """Whether bounds are to end."""
        return self._wanted() or self._over(_WRITING, 0.4)


_BOUNDING, _WRITING = 2.0, 3.0
"""s of the processor that are kept of a limit for bounds, and for writing."""


def _record(problem: DesignProblem, front: Front, duir: LowerBound, total: LowerBound, ended: str) -> dict[str, Any]:
    """The content of `run.json`."""
    record = run_record(problem, front, duir, total)
    record["acceptance"] = acceptance_record(recommended_acceptance(problem, front))
    recommended = problem.assessed(front.decisions[[front.recommended]])
    accuracy = AccuracyStatement.of(recommended, hidden_by_plan(problem, recommended, "the recommended plan"))
    if accuracy is not None:
        record["accuracy"] = accuracy.record
    minutes = design_minutes(problem, front)
    if minutes is not None:
        record["cost_min"] = float(minutes[front.recommended])
        record["measurements"] = int(problem.space.taken(front.decisions[front.recommended]).sum())
    if (ends := what_ends(problem, front)) is not None:
        record["plan_ended"] = ends
    if ended:
        record["ended_by_hand"] = ended
    return record


def _bounds(problem: DesignProblem, front: Front, callback: Callback, limit: _Limit) -> tuple[LowerBound, LowerBound]:
    found = []
    for place, (name, errors) in enumerate((("DUIR", 0.0), ("total", 1.0))):
        callback("bounding", place, 2, name)
        if limit.bounding():
            found.append(LowerBound(None, "not computed: the run was ended before"))
        else:
            found.append(Certificate(problem, errors).bound(front.decisions, limit.bounding))
    callback("bounding", 2, 2, "DUIR and total")
    duir, total = found
    # DUIR is a part of every plan's total, and its relaxation may be the closer one.
    closer = duir.value is not None and total.value is not None and duir.value > total.value
    return duir, duir if closer else total

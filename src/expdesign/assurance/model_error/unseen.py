"""Physics that a plan would not show, and the fewest further measurements that would.

The effect of which the most stays hidden at any axis, in tolerances, is the worst (MEIR's mean squares, theory.md 21).
Further measurements are to show it and every other one: of all effects that are considered, at every component, none
may keep more than a share of a tolerance hidden. They are chosen one by one, each the one of those drawn that leaves
the least sum, over the effects, of what is beyond that share in squares, and of several the least maximum.
"""

from copy import copy
from dataclasses import dataclass, replace

import numpy as np

from expdesign.arrays import BoolArray, FloatArray
from expdesign.assurance.model_error.meir import Meir
from expdesign.assurance.model_error.settings import Assumptions
from expdesign.chain.component import Part
from expdesign.counted import counted
from expdesign.errors import InputError
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.problem import DesignProblem
from expdesign.planning.result import minutes_of_plan, planned
from expdesign.planning.sampling import extreme_measurements

SHARE = 1.0 / 3.0
"""Of a tolerance, that physics which goes unnoticed may take: then U = k·u has room for it and for as much again."""
_LONGEST = 150
"""Measurements of a plan up to which it is judged: of longer ones the matrices are large, and little stays hidden."""
_DRAWN, _FURTHER = 120, 8
"""Measurements drawn, of which each further one is the best, and how many further ones there are at most."""

_LOWER = 0.9
"""Of what stays hidden, the part that counts as lower where it does not fall below `SHARE`."""


@dataclass(frozen=True)
class Extended:
    """The plan with further measurements that show more than it would.

    Attributes:
        problem: with room for them.
        decisions: of the plan and of them, shape (m, g).
        further: how many there are.
        phrase: a machine with the physics of which most stays hidden then, in words.
        left: how much that is, in tolerances.
    """

    problem: DesignProblem
    decisions: FloatArray
    further: int
    phrase: str
    left: float

    @property
    def shows(self) -> bool:
        """Whether no physics keeps more than `SHARE` of a tolerance hidden."""
        return self.left <= SHARE


@dataclass(frozen=True)
class Unseen:
    """The physics of which a plan hides most.

    Attributes:
        phrase: a machine that has it, in words.
        error: standard deviation that stays hidden at the worst axis of any target, in tolerances.
        target: of that axis, from 0.
        axis: its name.
        poor: why the plan can show little: `one pose`, `one load`, or empty.
        plan: its problem and decisions (m, g).
        checked: the plan that shows all of it, or as much as few further measurements show; None where that is nothing.
    """

    phrase: str
    error: float
    target: int
    axis: str
    poor: str
    plan: tuple[DesignProblem, FloatArray]
    checked: Extended | None

    @property
    def sentence(self) -> str:
        """What the plan cannot see, and what it costs to see it."""
        why = f"At {self.poor}" if self.poor == "one pose" else "With one load" if self.poor else "As it stands,"
        text = (
            f"{why} the plan cannot rule out {self.phrase}: at its prior size it would go unnoticed and move target "
            f"{self.target + 1} along {self.axis} by {self.error:.2g} times its tolerance (standard deviation)"
        )
        if self.error <= SHARE:
            return f"{text}; no other physics costs more."
        if self.checked is None:
            return f"{text}; {_FURTHER} further measurements within the limits do not show it either."
        checked, total = self.checked, known_criteria()["total"]
        pairs = self.plan, (checked.problem, checked.decisions)
        before, after = (float(total.values(p.assessed(d[None]))[0]) for p, d in pairs)
        minutes = [minutes_of_plan(p, d) for p, d in pairs]
        cost = "" if minutes[0] is None or minutes[1] is None else f"{minutes[1] - minutes[0]:.4g} min more, "
        most = f"at most {checked.left:.2g} of a tolerance hidden, from {checked.phrase}"
        more = (
            f"{text}. {counted(checked.further, 'further measurement')} (plan-checked.csv: {cost}total {before:.4g} "
            f"becomes {after:.4g}) would leave"
        )
        return f"{more} {most}{'' if checked.shows else ', which is still more than a third'}."

    @property
    def record(self) -> dict[str, object]:
        """As `run.json` has it."""
        checked, further = self.checked, None
        if checked is not None:
            further = {"measurements": checked.further, "left": checked.left, "physics": checked.phrase}
        named = {"physics": self.phrase, "error": self.error, "target": self.target + 1, "axis": self.axis}
        return {**named, "sentence": self.sentence, "checked": further}


def unseen_by(problem: DesignProblem, decisions: FloatArray) -> Unseen | None:
    """What a plan with decisions (m, g) hides most.

    None where every effect shows, and the plan has several poses and loads; where not the stiffness alone is
    calibrated; where nothing may be left out; and where the plan is long or does not identify what the targets need.
    """
    assessment = problem.assessed(decisions[None])
    known = bool(assessment.identifies_targets[0])
    if not problem.loaded.regressor.referenced or len(decisions) > _LONGEST or not known:
        return None
    meir = next((each for each in problem.further if isinstance(each, Meir)), None)
    try:
        meir = meir or Meir(problem, Assumptions())
    except InputError:  # the configuration leaves nothing over to consider
        return None
    # What the declared errors of the load say, no term says again.
    told = bool(problem.loaded.sources)
    counts = np.array([not told or entry.effect.component.part is not Part.PAYLOAD for entry in meir.physics])
    shares, poor = np.sqrt(meir.hidden(assessment).axes[0]), _poor(problem, decisions)
    worst = int(np.where(counts, shares.max(axis=(1, 2)), -1.0).argmax())
    error = float(shares[worst].max())
    if not counts[worst] or (error <= SHARE and not poor):
        return None
    target, axis = np.unravel_index(int(shares[worst].argmax()), shares[worst].shape)
    checked = _checked(problem, decisions, meir, counts, error) if error > SHARE else None
    name = problem.loaded.robot.coordinates.deflection[axis].rsplit("_", 1)[0]
    phrase = meir.physics[worst].effect.phrase
    return Unseen(phrase, error, int(target), name, poor, (problem, decisions), checked)


def _poor(problem: DesignProblem, decisions: FloatArray) -> str:
    """Whether a plan has one pose, or one load."""
    plan = planned(problem, decisions)
    if len(np.unique(plan.configurations, axis=0)) == 1:
        return "one pose"
    return "one load" if len(np.unique(plan.loads, axis=0)) == 1 else ""


def _checked(
    problem: DesignProblem, decisions: FloatArray, meir: Meir, counts: BoolArray, error: float
) -> Extended | None:
    """The plan with the fewest further measurements that show all physics which counts (E,).

    Where there are none, with the fewest of those that lower most what stays hidden, now `error`; None where none does.
    """
    drawn = extreme_measurements(problem, _DRAWN, 0.5, np.random.default_rng([problem.optimiser.seed, 4]))
    alone = problem.space.alone()
    drawn = alone.settable(drawn[:, None], problem.loaded.robot.limit_excess)[:, 0]
    drawn = drawn[problem.reachable(drawn)]
    taken, found = decisions[problem.space.taken(decisions)], []
    rows, of_drawn = (meir.rows(*problem.space.decode(each)) for each in (taken, drawn))
    for further in range(1, _FURTHER + 1):
        space = copy(problem.space)
        space.measurements = len(taken) + 1
        wider = replace(problem, space=space)
        designs = np.concatenate([np.repeat(taken[None], len(drawn), axis=0), drawn[:, None]], axis=1)
        every = np.concatenate([np.repeat(rows[None], len(drawn), axis=0), of_drawn[:, None]], axis=1)
        squares = np.where(counts, meir.hidden(wider.assessed(designs), every).axes.max(axis=(2, 3)), 0.0)
        beyond = np.maximum(squares - SHARE**2, 0.0).sum(axis=1)
        best = int(np.lexsort((squares.max(axis=1), beyond))[0])
        taken, rows, worst = designs[best], every[best], int(squares[best].argmax())
        left = float(np.sqrt(squares[best, worst]))
        found.append(Extended(wider, taken, further, meir.physics[worst].effect.phrase, left))
        if found[-1].shows:
            return found[-1]
    least = min(each.left for each in found)
    return next(each for each in found if _LOWER * each.left <= least) if least < _LOWER * error else None

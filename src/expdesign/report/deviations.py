"""How exactly a plan has to be met, in two sentences."""

import numpy as np

from expdesign.planning.front import Front
from expdesign.planning.optimality.deviations import Deviations, plan_deviations
from expdesign.planning.problem import DesignProblem
from expdesign.report import words

GROWTH = 0.01
"""Part by which the total error may grow where the plan is not met exactly."""
MOST_DESIGNS = 120
"""Longer fronts get this for the recommended design and the knee alone, so that the report does not take long."""


class PlanDeviations:
    """Deviations of the designs of a front, of those for which they are worth the time.

    Args:
        problem: what was searched.
        front: what was found.
    """

    def __init__(self, problem: DesignProblem, front: Front) -> None:
        count = len(front)
        chosen = range(count) if count <= MOST_DESIGNS else sorted({front.recommended, front.knee})
        self._place = {design: place for place, design in enumerate(chosen)}
        self._found: Deviations = plan_deviations(problem, front.decisions[list(chosen)])
        self._n_pose = len(problem.loaded.robot.configuration)

    def sentences(self, design: int) -> list[str]:
        """What random deviations do, and which quantity is the most delicate: the error that costs 1 % by itself."""
        if design not in self._place:
            return ["Computed for the recommended design and the knee only, because the front is long."]
        place, found = self._place[design], self._found
        if not np.isfinite(found.total[place]):
            return ["This design does not determine every stiffness, so that its sensitivity is not determined either."]
        loads = self._stated(slice(self._n_pose, None))
        loads = f", and every load by {loads}" if loads else ""
        mean, spread = (float(part[place]) for part in found.growth(found.stated))
        texts = [
            f"If every pose is off at random by {self._stated(slice(0, self._n_pose))}{loads} (standard deviations), "
            f"the error to expect changes by about ±{words.number(100.0 * spread, 2)}\u00a0%"
            + (f" and grows by {words.number(100.0 * mean, 2)}\u00a0% on average." if mean > 0.0 else ".")
        ]
        allowed = found.allowed(GROWTH)[place] / found.stated
        measurement, quantity = np.unravel_index(int(np.argmin(allowed)), allowed.shape)
        if np.isfinite(allowed[measurement, quantity]):
            column = words.plan_column(found.names[quantity])
            value = found.allowed(GROWTH)[place, measurement, quantity] * column.factor
            texts.append(
                f"The most delicate is the {column.title} of measurement {measurement + 1}: "
                f"{words.number(float(value), 2)}\u00a0{column.unit} off costs 1\u00a0%."
            )
        else:
            texts.append("No single deviation costs 1\u00a0%.")
        return texts

    def _stated(self, part: slice) -> str:
        """Stated deviations of a group of quantities: `0.2 mm and 1 mrad`."""
        texts: dict[str, None] = {}
        for name, value in zip(self._found.names[part], self._found.stated[part], strict=True):
            column = words.plan_column(name)
            # Angles stated in radians are no round numbers of degrees.
            texts[f"{words.given(float(f'{value * column.factor:.4g}'))}\u00a0{column.unit}"] = None
        return words.listed(list(texts)) if texts else ""

"""What stays hidden, by effect, in sentences and in documents: the accuracy to expect at the targets, in three parts.

Noise and load errors add as squares (theory.md 6); what is hidden is stated beside them, of the effect of which the
most is (theory.md 21). All are root mean squares in tolerances.
"""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from expdesign.assurance.model_error.meir import Hidden, Meir, meir_of_problem
from expdesign.assurance.model_error.physics import offsets
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.targets import TargetVariances
from expdesign.planning.problem import DesignProblem


@dataclass(frozen=True)
class HiddenPhysics:
    """What one effect could do without being noticed.

    Attributes:
        physics, component, variant: the effect.
        phrase: a machine that has it, in words: `play in leg 3`.
        error: MEIR_e, the error at the targets in tolerances.
        parameters: the combination of its parameters that adds most to it, at the standard deviation that stays
            hidden, by name with unit; shapes as they were assumed.
        parameter: the one that is largest against its prior size.
        noticed: by which factor that combination has to grow until it is noticed with the required power; infinite
            where the readings do not show it at all.
        shown: how far the readings determine that combination: 1 where its prior size does not matter.
    """

    physics: str
    component: str
    variant: str
    phrase: str
    error: float
    parameters: dict[str, float]
    parameter: str
    noticed: float
    shown: float

    @property
    def tolerable(self) -> float:
        """By which factor it may grow until it uses up the tolerance, below 1 where it already does more."""
        return 1.0 / self.error if self.error > 0.0 else float("inf")

    @property
    def limited_by(self) -> str:
        """What keeps the error from being larger: `detection` where readings say more of it than its prior `size`."""
        return "detection" if self.shown > 0.5 else "size"

    @property
    def record(self) -> dict[str, Any]:
        """As a document has it."""
        names = ("physics", "component", "variant", "error", "parameters", "noticed", "tolerable", "limited_by")
        values = {name: getattr(self, name) for name in names}
        return {name: None if value == float("inf") else value for name, value in values.items()}


@dataclass(frozen=True)
class WhatIsHidden:
    """What a plan or recordings hide.

    Attributes:
        physics: every effect that was considered, the largest error first.
        freedom: degrees of freedom of the residuals; where there are none nothing could be noticed.
        readings: what would have to show it: `this plan`, `these recordings`.
    """

    physics: tuple[HiddenPhysics, ...]
    freedom: int
    readings: str

    @classmethod
    def of(cls, meir: Meir, hidden: Hidden, readings: str) -> Self:
        """What the first of some designs hides: every effect at the worst of its starts."""
        start = offsets(meir.physics)
        worst: dict[tuple[str, str, str], HiddenPhysics] = {}
        for index in map(int, np.argsort(-hidden.squares[0], kind="stable")):
            entry, columns = meir.physics[index], slice(start[index], start[index + 1])
            if entry.key in worst:
                continue
            size, visible = hidden.sizes[0, columns], float(hidden.visible[0, index])
            largest = int(np.abs(size).argmax())
            size = size * np.sign(size[largest])  # its opposite is as bad
            values = entry.at(size * meir.deviations[columns])
            worst[entry.key] = HiddenPhysics(
                *entry.key,
                entry.effect.phrase,
                error=float(np.sqrt(hidden.squares[0, index])),
                parameters={p.name: float(v) for p, v in zip(entry.effect.parameters, values, strict=True)},
                parameter=entry.effect.parameters[entry.free[largest]].name,
                noticed=1.0 / float(np.sqrt(visible)) if visible > 0.0 else float("inf"),
                shown=float(hidden.shown[0, index]),
            )
        return cls(tuple(worst.values()), int(hidden.freedom[0]), readings)

    @property
    def meir(self) -> float:
        """The largest error at the targets, in tolerances."""
        return self.physics[0].error

    @property
    def sentence(self) -> str:
        """The worst of it, for people."""
        worst, readings = self.physics[0], self.readings
        if self.freedom == 0:
            return (
                f"With as many readings as unknowns, {readings} cannot show missing physics: {worst.phrase} of the "
                f"assumed size would cost {worst.error:.3g} tolerances at the targets."
            )
        text = (
            f"The worst that {readings} could hide is {worst.phrase}: {worst.error:.3g} tolerances at the targets "
            "(standard deviation)"
        )
        if worst.limited_by == "detection":
            return f"{text}, as far as the readings leave it open."
        if worst.noticed == float("inf"):
            return f"{text}, at the assumed size; {readings} would not show it at any size."
        times = worst.noticed * float(np.sqrt(1.0 - worst.shown))
        return f"{text}; {readings} would show it from {times:.3g} times the assumed size."

    @property
    def record(self) -> dict[str, Any]:
        """The worst as a sentence, and every effect."""
        return {
            "meir": self.meir,
            "freedom": self.freedom,
            "sentence": self.sentence,
            "effects": [each.record for each in self.physics],
        }


@dataclass(frozen=True)
class AccuracyStatement:
    """Expected errors at the targets, in tolerances.

    Attributes:
        noise, load_errors: DUIR and FEIR.
        hidden: what may be hidden.
    """

    noise: float
    load_errors: float
    hidden: WhatIsHidden

    @classmethod
    def of(cls, variances: TargetVariances, hidden: WhatIsHidden | None) -> Self | None:
        """The statement on the first of some variances at the targets, shape (t, n) or (1, t, n).

        None where these are not determined, or nothing is known of what is hidden.
        """
        parts = (variances.noise_variance, variances.force_variance)
        noise, force = (float(np.ravel(variances.aggregated(variances.weighted(part)))[0]) for part in parts)
        return cls(noise, force, hidden) if hidden is not None and np.isfinite([noise, force]).all() else None

    @property
    def total(self) -> float:
        """What noise and load errors add up to."""
        return float(np.hypot(self.noise, self.load_errors))

    @property
    def sentence(self) -> str:
        """The statement for people."""
        return (
            f"Expected error at the targets: {self.total:.3g} tolerances, {self.noise:.3g} from noise and "
            f"{self.load_errors:.3g} from load errors, if the model is right. {self.hidden.sentence}"
        )

    @property
    def record(self) -> dict[str, Any]:
        """The statement as a document (file-formats.md, evaluate --json)."""
        return {
            "noise": self.noise,
            "load_errors": self.load_errors,
            "total": self.total,
            "hidden": self.hidden.meir,
            "hidden_physics": self.hidden.physics[0].physics,
            "hidden_component": self.hidden.physics[0].component,
            "sentence": self.sentence,
        }


def hidden_by_plan(problem: DesignProblem, assessment: Assessment, plan: str) -> WhatIsHidden | None:
    """What the first design of an assessment hides, `plan` being what sentences call it.

    None where the configuration does not ask for MEIR, or the design does not identify what the targets need.
    """
    meir = meir_of_problem(problem)
    if meir is None:
        return None
    found = meir.hidden(assessment)
    return WhatIsHidden.of(meir, found, plan) if np.isfinite(found.squares[0]).all() else None

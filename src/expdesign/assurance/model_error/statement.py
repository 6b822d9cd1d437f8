"""What stays hidden, by effect, in sentences and in documents: the accuracy to expect at the targets, in three parts.

Noise and load errors are random and add as squares (theory.md 6); what is hidden is a bias, of which the largest that
goes unnoticed is stated beside them (theory.md 21). All are in tolerances.
"""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.assurance.model_error.hidden import Hidden
from expdesign.assurance.model_error.left_out import Omitted, offsets
from expdesign.planning.criteria.targets import GivenVariances, Targets, TargetVariances


@dataclass(frozen=True)
class HiddenPhysics:
    """What one effect could do without being noticed.

    Attributes:
        physics, component, variant: the effect.
        phrase: a machine that has it, in words: `play in leg 3`.
        error: MEIR_e, the error at the targets in tolerances.
        parameters: the worst combination of its parameters, by name with unit; shapes as they were assumed.
        parameter: the one that is largest against its prior size.
        noticed: by which factor that combination has to grow until it is noticed with the required power; 1 where it
            just is, infinite where the readings do not show it at all.
        tolerable: by which factor it may grow until it uses up the tolerance, below 1 where it already does more.
        rank: independent directions in which the effect shows in the residuals.
    """

    physics: str
    component: str
    variant: str
    phrase: str
    error: float
    parameters: dict[str, float]
    parameter: str
    noticed: float
    tolerable: float
    rank: int

    @property
    def limited_by(self) -> str:
        """What keeps the error from being larger: `detection`, `size` or both."""
        return "size" if self.noticed > 1.0 + 1e-6 else "detection"

    @property
    def record(self) -> dict[str, Any]:
        """As a document has it."""
        names = ("physics", "component", "variant", "error", "parameters", "noticed", "tolerable", "limited_by")
        values = {name: getattr(self, name) for name in names}
        return {name: None if value == float("inf") else value for name, value in values.items()}


def hidden_physics(
    hidden: Hidden, physics: tuple[Omitted, ...], deviations: FloatArray, design: int = 0
) -> tuple[HiddenPhysics, ...]:
    """Every effect of one design at the worst of its starts, the largest error first.

    Args:
        hidden: of b designs.
        physics: its entries.
        deviations: prior sizes of all columns, shape (D,).
        design: index of the design.
    """
    start = offsets(physics)
    worst: dict[tuple[str, str, str], HiddenPhysics] = {}
    for index, entry in enumerate(physics):
        error = float(np.sqrt(hidden.squares[design, index]))
        known = worst.get(entry.key)
        if known is not None and known.error >= error:
            continue
        values, size = entry.start.copy(), hidden.sizes[index][design]
        values[entry.free] += size * deviations[start[index] : start[index + 1]]
        visible = float(hidden.visible[design, index])
        worst[entry.key] = HiddenPhysics(
            *entry.key,
            entry.effect.phrase,
            error=error,
            parameters={p.name: float(v) for p, v in zip(entry.effect.parameters, values, strict=True)},
            parameter=entry.effect.parameters[entry.free[int(np.abs(size).argmax())]].name,
            noticed=1.0 / float(np.sqrt(visible)) if visible > 0.0 else float("inf"),
            tolerable=1.0 / error if error > 0.0 else float("inf"),
            rank=int(hidden.rank[design, index]),
        )
    return tuple(sorted(worst.values(), key=lambda each: -each.error))


def sentence(worst: HiddenPhysics, freedom: int, readings: str) -> str:
    """What a plan or recordings (`readings`) hide with so many degrees of freedom, for people."""
    if freedom == 0:
        return (
            f"With as many readings as unknowns, {readings} cannot show missing physics: {worst.phrase} of the assumed "
            f"size would cost {worst.error:.3g} tolerances at the targets."
        )
    text = f"The worst that {readings} could hide is {worst.phrase}: {worst.error:.3g} tolerances at the targets"
    if worst.limited_by == "detection":
        return f"{text}, at the largest size that goes unnoticed."
    if worst.noticed == float("inf"):
        return f"{text}, at the assumed size; {readings} would not show it at any size."
    return f"{text}, at the assumed size; {readings} would show it from {worst.noticed:.3g} times that size."


@dataclass(frozen=True)
class AccuracyStatement:
    """Expected errors at the targets, in tolerances.

    Attributes:
        noise, load_errors: DUIR and FEIR.
        hidden: the worst of what may be hidden, which adds up to `hidden.error`.
        freedom: degrees of freedom of the residuals.
        readings: what would have to show it: `this plan`, `these recordings`.
    """

    noise: float
    load_errors: float
    hidden: HiddenPhysics
    freedom: int
    readings: str

    @classmethod
    def of(
        cls, variances: TargetVariances, physics: tuple[HiddenPhysics, ...], freedom: int, readings: str
    ) -> Self | None:
        """The statement on the first of some variances at the targets; None where these are not determined.

        Args:
            variances: shape (t, n), or (1, t, n).
            physics: what is hidden, the worst first.
            freedom: degrees of freedom of the residuals.
            readings: what would have to show it.
        """
        parts = (variances.noise_variance, variances.force_variance)
        noise, force = (float(np.ravel(variances.aggregated(variances.weighted(part)))[0]) for part in parts)
        if not physics or not (np.isfinite(noise) and np.isfinite(force)):
            return None
        return cls(noise, force, physics[0], freedom, readings)

    @property
    def total(self) -> float:
        """What noise and load errors add up to."""
        return float(np.hypot(self.noise, self.load_errors))

    @property
    def sentence(self) -> str:
        """The statement for people."""
        return (
            f"Expected error at the targets: {self.total:.3g} tolerances, {self.noise:.3g} from noise and "
            f"{self.load_errors:.3g} from load errors, if the model is right. "
            f"{sentence(self.hidden, self.freedom, self.readings)}"
        )

    @property
    def record(self) -> dict[str, Any]:
        """The statement as a document (file-formats.md, evaluate --json)."""
        return {
            "noise": self.noise,
            "load_errors": self.load_errors,
            "total": self.total,
            "hidden": self.hidden.error,
            "hidden_physics": self.hidden.physics,
            "hidden_component": self.hidden.component,
            "sentence": self.sentence,
        }


def given_variances(targets: Targets, noise: FloatArray, load_errors: FloatArray) -> GivenVariances:
    """Variances from standard deviations (m, rad) at the targets, (t, n) each; 0 for axes that do not matter."""
    matters = targets.importance > 0.0
    squares = [np.where(matters, deviation**2, 0.0) for deviation in (noise, load_errors)]
    return GivenVariances(targets, *squares)


def hidden_sentence(physics: tuple[HiddenPhysics, ...], freedom: int, stated: AccuracyStatement | None) -> str:
    """What recordings may still hide, with the accuracy to expect where it is stated."""
    return sentence(physics[0], freedom, "these recordings") if stated is None else stated.sentence


def hidden_record(physics: tuple[HiddenPhysics, ...], freedom: int, readings: str) -> dict[str, Any] | None:
    """What is hidden: the worst as a sentence, and every effect; None where nothing is known of it."""
    if not physics:
        return None
    return {
        "meir": physics[0].error,
        "freedom": freedom,
        "sentence": sentence(physics[0], freedom, readings),
        "effects": [each.record for each in physics],
    }

"""The accuracy to expect at the targets, in three parts: noise, load errors, and what the model may leave out.

The first two are random and add as squares (theory.md 6); what is hidden is a bias, of which the largest that goes
unnoticed is stated beside them (theory.md 21). All are in tolerances.
"""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.criteria.target_variances import GivenVariances, TargetVariances
from expdesign.criteria.targets import Targets
from expdesign.model_error.hidden_physics import HiddenPhysics
from expdesign.model_error.recorded import HiddenByRecordings
from expdesign.model_error.words import sentence


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


def hidden_sentence(found: HiddenByRecordings, stated: AccuracyStatement | None) -> str:
    """What recordings may still hide, with the accuracy to expect where it is stated."""
    return sentence(found.physics[0], found.freedom, "these recordings") if stated is None else stated.sentence

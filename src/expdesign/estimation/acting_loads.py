"""What recordings say of the errors of their loads, and which of these act at a target as well.

A fit of the parameters θ̂ with covariance P leaves r = G·w + S·(θ − θ̂) + e, G being what the shared errors w of the
loads do to the readings, w ~ N(0, M), e ~ N(0, V). With A = (GᵀV⁻¹G + M⁻¹)⁻¹ and B = A·GᵀV⁻¹S

    ŵ = A·GᵀV⁻¹·r,   Cov(ŵ − w) = A + B·P·Bᵀ,   Cov(ŵ − w, θ̂ − θ) = −B·P,

whichever gain made θ̂, since A·GᵀV⁻¹·e − A·M⁻¹·w is independent of θ̂ − θ (theory.md 5.6). Where the thesis' estimator
only propagates load errors, ŵ = 0, and what they did to θ̂ by the gain K goes with them: Cov(ŵ − w, θ̂ − θ) = −M·(K·G)ᵀ.

The direction of gravity acts at every target, which stands on the same base; errors of the weights' mass and centre of
mass act where a target carries these (`compensation/target_loads`). Which of several weights it carries nobody says:
the largest of their errors acts there as it is declared, as what every loading has for itself does.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray, IntArray, as_matrix
from expdesign.chain.component import PAYLOAD
from expdesign.chain.effect import Effect
from expdesign.chain.effects.load.payload import LoadDirectionTilt, PayloadComOffset, PayloadMassError
from expdesign.chain.models.acting import ActingLoads, own_names
from expdesign.chain.recordings.recordings import Recordings
from expdesign.coordinates import Coordinates
from expdesign.estimation.fit import Fit
from expdesign.estimation.load_errors import LoadEffect, shared_parts
from expdesign.estimation.whitening import Whitening
from expdesign.mechanics.robots.robot import Robot


@dataclass(frozen=True)
class EstimatedLoads:
    """Shared errors of the loads as recordings show them, in declared standard deviations, effect after effect.

    Attributes:
        mean: ŵ, shape (d,).
        alone: A, shape (d, d).
        through: B, what they take from errors of the parameters, shape (d, p).
        apart: what their covariance with the parameters is beside −B·P, shape (d, p).
        gain: A·GᵀV⁻¹ per standard deviation of the noise, shape (N, d, k).
    """

    mean: FloatArray
    alone: FloatArray
    through: FloatArray
    apart: FloatArray
    gain: FloatArray

    @classmethod
    def of(
        cls,
        columns: FloatArray,
        sizes: FloatArray,
        noise: Whitening,
        left: tuple[FloatArray, FloatArray],
    ) -> "EstimatedLoads":
        """By what a fit has left.

        Args:
            columns: G of the shared errors, shape (N, k, d).
            sizes: √M, shape (d,).
            noise: of the readings, with the errors that every load has of its own.
            left: residuals (N, k) and sensitivities (N, k, p) of the fit, not whitened.
        """
        white = noise.apply(columns)
        flat = as_matrix(white)
        alone = np.linalg.inv(flat.T @ flat + np.diag(1.0 / sizes**2))
        residuals, sensitivities = noise.apply(left[0]), as_matrix(noise.apply(left[1]))
        gain = (noise.scores(white) @ alone).swapaxes(1, 2)
        through = alone @ (flat.T @ sensitivities)
        return cls(alone @ (flat.T @ residuals.ravel()), alone, through, np.zeros_like(through), gain)

    @classmethod
    def propagated(cls, sizes: FloatArray, moved: FloatArray, readings: tuple[int, int]) -> "EstimatedLoads":
        """Where they are not estimated: what one of `sizes` (d,) each does to parameters (p, d), of (N, k) readings."""
        count, apart = len(sizes), -sizes[:, None] * moved.T
        nothing = np.zeros((readings[0], count, readings[1]))
        return cls(np.zeros(count), np.diag(sizes**2), np.zeros_like(apart), apart, nothing)

    def covariance(self, known: FloatArray, inflation: float = 1.0) -> FloatArray:
        """Cov(ŵ − w) where the parameters have the covariance `known` (p, p), all being inflated, shape (d, d)."""
        found: FloatArray = inflation * self.alone + self.through @ known @ self.through.T
        return found


@dataclass(frozen=True)
class LoadsAtTargets:
    """The errors of the loads that act at targets, as effects of the chain.

    Attributes:
        effects: of the chain.
        columns: which of the shared errors are their parameters, shape (a,).
        units: of the parameters per declared standard deviation, shape (a,).
        own: standard deviations of what acts and is not estimated, in the order of `own_names`, shape (o,).
    """

    effects: tuple[Effect, ...]
    columns: IntArray
    units: FloatArray
    own: FloatArray

    @classmethod
    def of(
        cls, robot: Robot, recorded: Recordings, errors: Sequence[LoadEffect], sizes: FloatArray
    ) -> "LoadsAtTargets":
        """Those of recorded payloads; errors of a wrench that was applied stay with what applied it.

        Args:
            robot: that carries them.
            recorded: what was measured.
            errors: of its loads.
            sizes: of each, in declared standard deviations, shape (e,).
        """
        effects: list[Effect] = []
        columns: list[IntArray] = [np.empty(0, dtype=np.int64)]
        units: list[FloatArray] = [np.empty(0)]
        weight = float(np.linalg.norm(recorded.gravity[0])) if len(recorded) else 0.0
        sources = [error.source for error in errors if error.shared]
        part, own = own_part(robot.coordinates), np.zeros((2, len(own_names(robot.coordinates))))
        for error, size, place in zip(errors, sizes.tolist(), shared_parts(errors), strict=True):
            if recorded.payload is None or error.source not in ACTING:
                continue
            if not error.shared or sources.count(error.source) > 1:
                here = own[int(error.shared), part[error.source]]
                np.maximum(here, size * error.deviation, out=here)
            else:
                effects.append(ACTING[error.source](robot))
                columns.append(np.arange(place.start, place.stop))
                units.append(error.deviation * (weight if error.source == "mass" else 1.0))
        return cls(tuple(effects), np.concatenate(columns), np.concatenate(units), np.hypot(*own))

    def shown(self, estimated: EstimatedLoads, fit: Fit) -> ActingLoads | None:
        """What a model says of them beside a fit's parameters, whose covariance is as it predicts; None for nothing."""
        if not self.effects and not self.own.any():
            return None
        known = fit.estimable.generalised
        own = estimated.covariance(known, fit.inflation)[np.ix_(self.columns, self.columns)]
        own = own * np.outer(self.units, self.units)
        across = fit.inflation * estimated.apart - estimated.through @ known
        across = self.units[:, None] * across[self.columns]
        values = self.units * estimated.mean[self.columns]
        return ActingLoads(self.effects, values, np.hstack([across, own]), np.sqrt(fit.inflation) * self.own)

    def joined(self, estimated: EstimatedLoads, gain: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The gain (N, p, k) of parameters with that of these errors below it, and what these are less than estimated.

        Returns:
            The gain per standard deviation of the noise, (N, p + a, k), and −1 at every error itself, (p + a, d).
        """
        added = self.units[:, None] * (estimated.gain - estimated.through @ gain)[:, self.columns]
        own = np.zeros((gain.shape[1] + len(self.columns), len(estimated.mean)))
        own[gain.shape[1] + np.arange(len(self.columns)), self.columns] = -self.units
        return np.concatenate([gain, added], axis=1), own


ACTING: dict[str, Callable[[Robot], Effect]] = {
    "com": lambda robot: PayloadComOffset(robot, PAYLOAD),
    "direction": lambda robot: LoadDirectionTilt(robot, PAYLOAD),
    "mass": lambda robot: PayloadMassError.from_text(robot, str(PAYLOAD), "forgotten"),
}
"""Effect of the chain that each source of load error is; of a mass its weight."""


def own_part(coordinates: Coordinates) -> dict[str, slice]:
    """Where each source stands among `own_names`."""
    first = 1 + len(coordinates.centre_of_mass)
    return {"mass": slice(0, 1), "com": slice(1, first), "direction": slice(first, None)}

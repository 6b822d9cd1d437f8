"""All actuators softer or stiffer than the robot file says by one factor, which tells the unit."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from expdesign.assurance.plausibility.evidence import Evidence, Fitted
from expdesign.assurance.plausibility.finding import Implausibility
from expdesign.assurance.plausibility.mistakes.mistake import Mistake

_POOR = 0.5
"""Misfit above which stiffness means nothing."""


@dataclass(frozen=True)
class _Slip:
    """A factor of the compliances with what makes it.

    Attributes:
        factor: identified by stated compliance.
        payload: the question for recordings with masses.
        wrench: the question for recordings with forces.
        exact: whether robots have such factors as well, so that all actuators must have it to a few per cent.
    """

    factor: float
    payload: str
    wrench: str
    exact: bool = False


_KGF, _POUND = 9.80665, 0.45359237
"""N of a kgf, kg of a pound."""
_TEN_SOFT = "are the readings ten times too large"
_KNOWN = (
    _Slip(_KGF, f"Are weights in mass_kg ten times too small, or {_TEN_SOFT}?",
           f"Are the forces in kgf, as if kg stood in the columns of N (1 kgf = 9.80665 N), or {_TEN_SOFT}?"),
    _Slip(1.0 / _KGF, "Are weights in N in the column mass_kg (1 kg weighs 9.80665 N), or the readings ten times too "
           "small?", "Are the forces ten times too large (N, not kgf), or the readings ten times too small?"),
    _Slip(_POUND, "Are masses in lb in the column mass_kg (1 lb = 0.4536 kg)?", "", exact=True),
    _Slip(100.0, "Are masses, or readings, a hundred times off: cm, or a decimal point?",
           "Are forces, or readings, a hundred times off: cm, or a decimal point?"),
    _Slip(0.01, "Are masses, or readings, a hundred times off: cm, or a decimal point?",
           "Are forces, or readings, a hundred times off: cm, or a decimal point?"),
)  # fmt: skip


class StiffnessFactor(Mistake):
    """Everything fits, with another stiffness than the file states."""

    def findings(self, evidence: Evidence) -> Iterator[Implausibility]:
        stated = evidence.fits[-1]
        options = evidence.options
        if stated is None or stated.misfit >= _POOR or stated.share_positive < options.most:
            return
        known = self._known(stated, evidence)
        ratio, limit = stated.ratio, options.unit_ratio
        if known is None and 1.0 / limit < ratio < limit:
            return
        softer = "softer" if ratio > 1.0 else "stiffer"
        all_alike = "" if known is None else ", all actuators alike"
        what = f"the robot comes out {max(ratio, 1.0 / ratio):.3g} times {softer} than its file says{all_alike}"
        yield Implausibility(what, self._unit(ratio) if known is None else known)

    @staticmethod
    def _unit(ratio: float) -> str:
        if ratio > 1.0:
            return (
                "Are deflections in mm (and mrad), a mass in tonnes, a force in kN, or `actuator_stiffness` in another "
                "unit?"
            )
        return "Is a mass in grams or a force in mN, are deflections in km, or is `actuator_stiffness` in N/µm or N/mm?"

    @staticmethod
    def _known(stated: Fitted, evidence: Evidence) -> str | None:
        """The question of the factor that all actuators share, or None."""
        shown = stated.compliances[np.isfinite(stated.compliances)]
        if len(shown) < 2 or np.any(shown <= 0.0):
            return None
        logarithms, options = np.log(shown), evidence.options
        centre, spread = float(logarithms.mean()), float(logarithms.std(ddof=1))
        payload = evidence.recordings.payload is not None
        for known in _KNOWN:
            text = known.payload if payload else known.wrench
            near, alike = (options.exact, options.exact) if known.exact else (options.near, options.alike)
            if text and spread < alike and abs(centre - np.log(known.factor)) < near + spread / np.sqrt(len(shown)):
                return text
        return None

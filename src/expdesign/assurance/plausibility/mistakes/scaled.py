"""Signs and units of readings, commands, moments and stiffnesses: what is wrong by a factor."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from expdesign.assurance.plausibility.evidence import Evidence, Fitted
from expdesign.assurance.plausibility.finding import Implausibility
from expdesign.assurance.plausibility.mistakes.mistake import Alternative, Mistake

_DEGREE = np.pi / 180.0
"""rad of a degree."""


class ReadingUnits(Mistake):
    """Translations or rotations, or one column, in another unit; what is computed with has to be in m and rad."""

    def alternatives(self, evidence: Evidence) -> Iterator[Alternative]:
        linear, stated = evidence.linear, evidence.stated
        if linear.any() and (~linear).any():
            for factor, unit in ((1e-3, "mm"), (1e-6, "µm"), (1e3, "km")):
                text = f"Are the translations in {unit}? Write the unit into the columns' names, as in `dx_{unit}`."
                yield Alternative(text, stated.scaled(np.where(linear, factor, 1.0)))
            for factor, unit in ((_DEGREE, "deg"), (1e-3, "mrad"), (1e-6, "µrad"), (1.0 / _DEGREE, "turned twice")):
                said = "degrees" if unit == "deg" else unit
                text = f"Are the rotations in {said}? Write the unit into the columns' names, as in `drx_{unit}`."
                if unit == "turned twice":
                    text = "Were the rotations converted from degrees twice?"
                yield Alternative(text, stated.scaled(np.where(linear, 1.0, factor)))
        for column, name in enumerate(evidence.names):
            for factor, unit in ((1e-3, "mm" if linear[column] else "mrad"), (_DEGREE, "degrees"), (1e-6, "µ")):
                factors = np.ones(len(linear))
                factors[column] = factor
                if linear[column] == (unit == "degrees"):
                    continue
                said = {"µ": "µm" if linear[column] else "µrad"}.get(unit, unit)
                yield Alternative(f"Is {name} in {said}?", stated.scaled(factors))


class CommandUnits(Mistake):
    """Angles of a pose in degrees."""

    def alternatives(self, evidence: Evidence) -> Iterator[Alternative]:
        robot, stated = evidence.robot, evidence.stated
        split = robot.coordinates.translations
        angles = np.array([name.endswith("_rad") for name in robot.configuration])
        if robot.configuration == robot.coordinates.pose and len(angles) > split:
            turned = stated.configurations * np.where(angles, _DEGREE, 1.0)
            yield Alternative("Are the commanded angles in degrees?", evidence.at(turned))


class Moments(Mistake):
    """Moments in N·mm or kN·m, or with the wrong sign."""

    def alternatives(self, evidence: Evidence) -> Iterator[Alternative]:
        stated, split = evidence.stated, evidence.robot.coordinates.translations
        if evidence.robot.coordinates.n == split:
            return
        for factor, text in (
            (1e-3, "Are moments in N·mm, or centres of mass in millimetres?"),
            (1e3, "Are moments in kN·m?"),
            (9.80665, "Are moments in kgf·m? 1 kgf = 9.80665 N."),
            (1.0 / 9.80665, "Are the forces in kgf (1 kgf = 9.80665 N), and the moments in N·m?"),
            (-1.0, "Have the moments the wrong sign?"),
        ):
            wrenches = stated.wrenches.copy()
            wrenches[:, split:] *= factor
            yield Alternative(text, replace(stated, wrenches=wrenches))


class TurnedSigns(Mistake):
    """Everything, one column, or all translations or rotations with the other sign."""

    def alternatives(self, evidence: Evidence) -> Iterator[Alternative]:
        stated, linear, count = evidence.stated, evidence.linear, len(evidence.axes)
        yield Alternative(
            "Have all deflections, or all loads, the wrong sign? A deflection is the loaded minus the unloaded pose, "
            "and a load what the environment applies to the platform.",
            stated.scaled(np.full(count, -1.0)),
        )
        for column, name in enumerate(evidence.names):
            factors = np.ones(count)
            factors[column] = -1.0
            yield Alternative(f"Has {name} the wrong sign?", stated.scaled(factors))
        for kind, noun in ((linear, "translations"), (~linear, "rotations")):
            if kind.sum() > 1:
                yield Alternative(f"Have the {noun} the wrong sign?", stated.scaled(np.where(kind, -1.0, 1.0)))


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

"""Readings and commands in another unit than their columns say."""

from collections.abc import Iterator

import numpy as np

from expdesign.assurance.plausibility.evidence import Evidence
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

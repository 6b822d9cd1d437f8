"""Moments, or centres of mass, in another unit or of the other sign than the forces."""

from collections.abc import Iterator
from dataclasses import replace

from expdesign.assurance.plausibility.evidence import Evidence
from expdesign.assurance.plausibility.mistakes.mistake import Alternative, Mistake


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

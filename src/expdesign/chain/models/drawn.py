"""What no reading of an arm's calibration shows of the pose of its tip, and the drawing alone says.

A frame on the tip is where markers of unknown places say that it is, and joint 6's zero is one turn with theirs: no
reading tells them apart. What stays as drawn is a term with its prior, as large as such parts are made, and belongs to
the uncertainty of the tip's pose, though not to that of readings. Where the instrument's own pose was identified, the
base's frame is that of the first joint at its zero: what is uncertain of the place of that frame is said beside U.
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.models.checked import AGAIN
from expdesign.chain.models.matrix_rows import MatrixRows, matrix_rows
from expdesign.io.schema import NonNegative, Section

RESTS_ON_IT = (
    "most of U rests on the drawing, because no reading shows where the tip is on its flange (one standard deviation, "
    "as this arm is made): {}. State where the markers are on the tip (`markers` of the robot file), and measure three"
)
"""What is said where that is most of U, with how much it is."""


@dataclass(frozen=True)
class Drawn:
    """Standard deviations of what the drawing alone says.

    Attributes:
        steps: of the p parameters of a calibration that move no reading and may move the tip, shape (p, d).
        base: the same of the base's frame against the instrument, shape (p, e).
        tip: of the place (m) and the turn (rad) of the tip on its last link, 0 where these are parameters.
    """

    steps: FloatArray
    base: FloatArray
    tip: tuple[float, float] = (0.0, 0.0)

    def moved(self, sensitivities: FloatArray, turned: FloatArray) -> FloatArray:
        """What they do to N poses of the tip, one standard deviation each, shape (N, 6, d + 6).

        Args:
            sensitivities: of the poses, with respect to these parameters and maybe more after them, (N, 6, p …).
            turned: orientations of the tip along the axes of the poses, shape (N, 3, 3).
        """
        own = np.zeros((len(turned), 6, 6))
        own[:, :3, :3], own[:, 3:, 3:] = self.tip[0] * turned, self.tip[1] * turned
        found: FloatArray = np.concatenate([sensitivities[..., : len(self.steps)] @ self.steps, own], axis=-1)
        return found


class DrawnSection(Section):
    """`drawing` of a model file: rows of the steps of all parameters, and the tip on its last link."""

    steps: MatrixRows
    tip_m: NonNegative
    tip_rad: NonNegative


def drawn_entry(drawn: Drawn | None, scale: FloatArray) -> dict[str, object]:
    """The key `drawing` of a model file whose parameters stand in units of a scale (p,); nothing for None."""
    if drawn is None:
        return {}
    steps = drawn.steps * scale[: len(drawn.steps), None]
    return {"drawing": {"steps": matrix_rows(steps), "tip_m": float(drawn.tip[0]), "tip_rad": float(drawn.tip[1])}}


def drawn_of(section: DrawnSection | None, scale: FloatArray) -> Drawn | None:
    """What the section says of parameters that stand in units of a scale (p,).

    Raises:
        InputError: there are more rows than parameters, or numbers that are not finite.
    """
    if section is None:
        return None
    rows = section.steps
    if len(rows) > len(scale) or any(len(row) != len(rows[0]) for row in rows) or not np.isfinite(rows).all():
        what = f"at most {len(scale)} rows of finite numbers, equally many each, are needed here"
        raise section.where("steps").fault(what, f"Order: `parameters`. {AGAIN}")
    steps = np.array(rows).reshape(len(rows), -1) / scale[: len(rows), None]
    return Drawn(steps, np.zeros((len(rows), 0)), (section.tip_m, section.tip_rad))

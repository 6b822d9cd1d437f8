"""What a calibration of an arm assumes beforehand, and how it treats noise and outliers."""

from dataclasses import dataclass
from typing import Literal

Loss = Literal["squares", "huber", "student"]
Further = Literal["masses", "tool", "harmonics", "drift"]
"""What is identified on request: factors on the masses of links; mass and first moments of what rides on each tip;
errors of joints that repeat once and twice a turn; wandering of instrument against base over the time of the campaign.
"""

Held = Literal["zeros", "lengths", "angles", "compliances"]
"""Groups of parameters that can be held at the drawing."""


@dataclass(frozen=True)
class ArmOptions:
    """Options of the identification of arms from absolute readings.

    Attributes:
        hold: groups that stay at the drawing.
        loss: of a row whose residual is large: `squares`, `huber` (linear beyond 1.345 standard deviations, 95 %
            efficient at normal noise; Huber, Annals of Mathematical Statistics 35, 1964, 73) or `student` (Student's t
            with 4 degrees of freedom, as recommended for unknown tails by Lange, Little and Taylor, J. Am. Stat. Assoc.
            84, 1989, 881).
        further: what is identified beside geometry and compliances.
    """

    hold: tuple[Held, ...] = ()
    loss: Loss = "squares"
    further: tuple[Further, ...] = ()

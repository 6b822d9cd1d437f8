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

    The sizes are standard deviations with which zeros and frames of an arm are made, before anything is measured. They
    are multiplied by one factor for each group (zeros, lengths, angles, compliances, harmonics, masses), which the rows
    decide by their evidence (`groups.py`).

    Attributes:
        length: m, of the frames of joints: the limit for 400 to 1000 mm in ISO 2768-1, class m.
        angle: rad, of the frames of joints: half the limit (20') for sides of 50 to 120 mm there.
        zero: rad, of the zeros of revolute joints: mastering by marks reaches some tenths of a degree.
        zero_length: m, of the zeros of prismatic joints.
        compliance: of a joint, in units of the robot file's, whose order of magnitude is all that is taken as known.
        spread: standard deviation of the logarithm of a factor beforehand: ten times better or worse is usual.
        hold: groups that stay at the drawing.
        beyond: deviations in manufacture, as above, from which a correction is none: the drawing is of another machine,
            or the correction holds something else.
        loss: of a row whose residual is large: `squares`, `huber` (linear beyond 1.345 standard deviations, 95 %
            efficient at normal noise; Huber, Annals of Mathematical Statistics 35, 1964, 73) or `student` (Student's t
            with `freedom` degrees of freedom; Lange, Little and Taylor, J. Am. Stat. Assoc. 84, 1989, 881).
        freedom: of Student's t; 4 as recommended there for unknown tails.
        generous: RMS of the residuals in stated standard deviations below which these are far too large, and are
            estimated; only where χ² is improbably small as well.
        determined: part of its deviation beforehand that a parameter keeps at most where the rows tell it apart.
        redundant: part of a column, orthogonal to the columns before it, below which rows do not tell parameters apart:
            rounding of exact derivatives, squared by no normal equation.
        folds: of the cross-validation where no rows are marked `test`.
        further: what is identified beside geometry and compliances.
        tool_mass: kg, of what rides on a tip: a gripper.
        tool_moment: kg·m, its first moments: the same at 0.15 m.
    """

    length: float = 8e-4
    angle: float = 3e-3
    zero: float = 1e-2
    zero_length: float = 2e-3
    compliance: float = 3.0
    spread: float = 2.3
    hold: tuple[Held, ...] = ()
    beyond: float = 5.0
    loss: Loss = "squares"
    freedom: float = 4.0
    generous: float = 0.7
    determined: float = 0.5
    redundant: float = 1e-7
    folds: int = 5
    further: tuple[Further, ...] = ()
    tool_mass: float = 2.0
    tool_moment: float = 0.3

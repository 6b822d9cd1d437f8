"""When something is called a mistake: every threshold, far outside what machines and laboratories have."""

from dataclasses import dataclass


@dataclass(frozen=True)
class MistakeOptions:
    """Thresholds, which lie far outside what sound recordings of machines with any physics reach.

    Attributes:
        gain: factor by which an alternative reading must reduce the misfit.
        poor: misfit below which nothing needs an explanation by a mistake where noise is not stated.
        fair: misfit below which the signs and sizes of compliances mean something.
        most: share of the compliances of one sign that makes it the sign of all.
        odds: how much likelier than chance a mistake must be, for each alternative that is tried.
        refuted: p-value of χ² below which the recordings as they are do not fit the robot with their stated noise.
        consistent: p-value above which they do under an alternative; it is then named whatever the gain.
        unit_ratio: factor between identified and stated stiffness beyond which a unit is suspected.
        alike: standard deviation of the logarithms of the actuators' factors below which they are one factor.
        near: distance of the logarithm of that factor from a known one within which it is that one.
        exact: the same two for factors near 1, which robots may have as well: their common distance and spread.
        chance: probability by which structure in the numbers (copies, rounding, scatter) may be accident.
        repeatability: how many times better than stated readings may repeat.
        noisy: bounds on the factor by which all columns scatter more than stated, when that is a mistake of the unit.
        enough: degrees of freedom from which on the scatter of rows and columns is compared.
        slip: standard deviations from what the others say beyond which slips are tried for a row or a reading.
        candidates: of these so many, the most conspicuous ones.
        columns: whose scatter is compared at least.
        senseless: misfit from which on stiffness means nothing.
        shown: part of the largest column of sensitivities below which a compliance does not show.
        spare: readings beyond the compliances that a judgement takes at least.
        rows: rows beyond which further ones are not looked at.
    """

    gain: float = 10.0
    poor: float = 1e-3
    fair: float = 0.1
    most: float = 0.8
    odds: float = 1e4
    refuted: float = 1e-6
    consistent: float = 0.01
    unit_ratio: float = 30.0
    alike: float = 0.35
    near: float = 0.15
    exact: float = 0.04
    chance: float = 1e-6
    repeatability: float = 10.0
    noisy: float = 0.2
    enough: float = 40.0
    slip: float = 3.0
    candidates: int = 4
    columns: int = 3
    senseless: float = 0.5
    shown: float = 1e-6
    spare: int = 4
    rows: int = 3000


DEFAULT = MistakeOptions()
"""What commands use."""


@dataclass(frozen=True)
class RobotOptions:
    """Ranges that machines lie in.

    Attributes:
        sizes: m.
        linear, rotary: N/m and N·m/rad, of actuators.
        impossible: factor beyond these ranges from which a number is no machine's, and not merely unusual.
        unequal: ratio of the stiffest to the softest actuator of one kind beyond which one is in another unit.
        gravity: m/s²; from the Moon's to that of any centrifuge that a robot stands in.
        disproportion: ratio of the sizes of two parts of one robot beyond which one is in another unit.
        excluded: part of the robot's size by which limits may not exclude its own reference pose.
    """

    sizes: tuple[float, float] = (0.002, 40.0)
    linear: tuple[float, float] = (1e4, 1e11)
    rotary: tuple[float, float] = (1.0, 1e10)
    impossible: float = 100.0
    unequal: float = 3e3
    gravity: tuple[float, float] = (0.5, 30.0)
    disproportion: float = 60.0
    excluded: float = 0.6


@dataclass(frozen=True)
class ProblemOptions:
    """Thresholds of run configurations and of targets of a compensation.

    Attributes:
        far: times the robot's size at which no centre of mass and no pose is.
        soft, soft_arm, broken: deflections in parts of the robot's size that are suspicious for robots on legs and for
            arms, and impossible.
        turned, overturned: rad of deflection that are suspicious, and impossible.
        noises, angular_noises: m, rad; standard deviations between which instruments are.
        platform_angle: rad that no platform on legs turns by.
        ratio: of loads in the experiment and at the targets beyond which one of them is in another unit.
        unseen, perfect: largest deflection in standard deviations of its reading below and above which one of them is
            in another unit.
        uneven: ratio of that of translations to that of rotations beyond which the noise of one is in another unit.
        coarse, angular_coarse, finest: m, rad, either; tolerances that need no calibration, or that none reaches.
        unknown_direction, unknown_force: rad, and times the force at the targets, that a load error is not.
        samples: measurements drawn from the design space to be judged.
        heavy, other_unit: times the largest calibrated load that are suspicious, and that are another unit.
        lever: part of the robot's size: moments below the largest force times this lever are not compared.
    """

    far: float = 8.0
    soft: float = 0.003
    soft_arm: float = 0.05
    broken: float = 0.5
    turned: float = 0.05
    overturned: float = 1.0
    noises: tuple[float, float] = (1e-12, 1e-3)
    angular_noises: tuple[float, float] = (1e-12, 2e-2)
    platform_angle: float = 1.8
    ratio: float = 150.0
    unseen: float = 1.0
    perfect: float = 1e7
    uneven: float = 3e4
    coarse: float = 1e-2
    angular_coarse: float = 0.2
    finest: float = 1e-12
    unknown_direction: float = 0.3
    unknown_force: float = 10.0
    samples: int = 200
    heavy: float = 3.0
    other_unit: float = 100.0
    lever: float = 0.05


ROBOT, PROBLEM = RobotOptions(), ProblemOptions()
"""What commands use."""

"""What an identification remarks on the recordings and on its result, as data; the sentences are in
`report/remark_texts.py`.
"""

from dataclasses import dataclass

from expdesign.chain.recordings.recordings import Remark


@dataclass(frozen=True)
class Implausible(Remark):
    """Physics speaks against the recordings as they are (`plausibility`).

    Attributes:
        what: what is computed from them.
        likely: the mistake that is probably in them.
        where: row or column, where it concerns one.
        otherwise: whether they fit only if they are read otherwise.
    """

    what: str
    likely: str
    where: str = ""
    otherwise: bool = False


@dataclass(frozen=True)
class NegativeCompliance(Remark):
    """A compliance comes out negative.

    Attributes:
        actuator: whose it is.
        certain: whether it cannot be positive within its uncertainty.
    """

    actuator: str
    certain: bool


@dataclass(frozen=True)
class IdleActuators(Remark):
    """Actuators that no fitted row loads keep the stiffness of the robot file.

    Attributes:
        actuators: their names.
        deviation: relative standard deviation with which that stiffness is taken as known.
    """

    actuators: tuple[str, ...]
    deviation: float


@dataclass(frozen=True)
class LargeGeometricErrors(Remark):
    """The geometry is so far off that the frames are probably not those of the commands.

    Attributes:
        size: RMS of the determined parameters (m).
    """

    size: float


@dataclass(frozen=True)
class AliasedGeometry(Remark):
    """Geometric parameters of which only combinations are determined.

    Attributes:
        count: of them.
        total: number of geometric parameters.
    """

    count: int
    total: int


@dataclass(frozen=True)
class NoiseBeyondStated(Remark):
    """Residuals exceed the stated noise, and a second component was estimated.

    Attributes:
        name: `translations` or `rotations`.
        stated: RMS of the stated standard deviations (m or rad).
        needed: what they would have to be.
        extra: the second component, needed² − stated².
    """

    name: str
    stated: float
    needed: float
    extra: float


@dataclass(frozen=True)
class GenerousNoise(Remark):
    """The stated standard deviations are far larger than the residuals, from which the noise was estimated.

    Attributes:
        name: `translations` or `rotations`.
        stated: RMS of the stated standard deviations (m or rad).
        needed: what the residuals show.
    """

    name: str
    stated: float
    needed: float


@dataclass(frozen=True)
class BlindPoses(Remark):
    """Parameters that other poses would tell apart, and the fitted ones do not.

    Attributes:
        names: of the parameters, which stay as drawn.
    """

    names: tuple[str, ...]


@dataclass(frozen=True)
class BeyondManufacture(Remark):
    """Corrections of a geometry that no machine needs: the drawing is of another one, or something else is in them.

    Attributes:
        names: of the parameters, for people.
        values: what was identified (m or rad).
        sizes: their standard deviations in manufacture (m or rad).
        angles: whether they are angles.
    """

    names: tuple[str, ...]
    values: tuple[float, ...]
    sizes: tuple[float, ...]
    angles: tuple[bool, ...]

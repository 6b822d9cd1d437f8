"""One thing that physics says against an input, and how it is said."""

import logging
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.errors import InputError
from expdesign.mechanics.robots.robot import Robot

_LOGGER = logging.getLogger("expdesign.assurance.plausibility")


@dataclass(frozen=True)
class Implausibility:
    """Something that cannot be, or that is hardly meant.

    Attributes:
        what: what is computed from the input.
        likely: the unit or the sign that is probably meant.
        where: the key or the column that it concerns.
        impossible: whether it cannot be.
        otherwise: whether the input fits only if it is read otherwise, so that what follows from it as it is, is wrong.
    """

    what: str
    likely: str
    where: str = ""
    impossible: bool = False
    otherwise: bool = False


def say(findings: Sequence[Implausibility], source: str) -> None:
    """Raise the first impossible finding, or log every suspicious one as a warning (on standard error by default).

    Raises:
        InputError: something is impossible.
    """
    for finding in sorted(findings, key=lambda one: not one.impossible):
        where = ", ".join(part for part in (source, finding.where) if part)
        if finding.impossible:
            raise InputError(finding.what, where=where, remedy=finding.likely)
        _LOGGER.warning("expdesign: warning: %s: %s. %s", where, finding.what, finding.likely)


def outside(
    value: float, low: float, high: float, what: str, likely: str, where: str = "", impossible: float = np.inf
) -> list[Implausibility]:
    """A number that machines and laboratories do not have.

    Args:
        value: the number; NaN is not asked about.
        low: the least that they have.
        high: the most.
        what: the sentence, with a place for the number.
        likely: what is probably meant.
        where: the key or the column.
        impossible: factor beyond the range from which it is no machine's, and not merely unusual.
    """
    if not (value < low or value > high):
        return []
    return [Implausibility(what.format(value), likely, where, value < low / impossible or value > high * impossible)]


def extent(robot: Robot) -> float | None:
    """Largest distance (m) between the parts of a robot at its reference configuration; None for one without a drawing.

    A body or a robot of a point has none either.
    """
    drawing = robot.drawing(robot.reference_configuration())
    if drawing is None:
        return None
    spread = np.ptp(drawing.points.reshape(-1, drawing.points.shape[-1]), axis=0)
    size = float(np.linalg.norm(spread))
    return size if np.isfinite(size) and size > 0.0 else None


def largest(values: FloatArray) -> float:
    """Largest magnitude of what is finite; 0 where nothing is."""
    finite = np.abs(values[np.isfinite(values)])
    return float(finite.max()) if finite.size else 0.0

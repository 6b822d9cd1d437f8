"""What a model file says is checked for what it means: a file that cannot be is never believed.

A machine yields to its load, one number stands in one place, a covariance is positive semidefinite, and ranges have a
low and a high end. Numbers that contradict that were changed by hand or come from somewhere else.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.io.schema import LARGEST
from expdesign.io.yaml_reader import YamlDocument
from expdesign.mechanics.robots.robot import Robot

AGAIN = "Identify or diagnose the recordings again."
SAME = 1e-6
"""Relative difference of one number written twice that is rounding."""
SURE = 2.0
"""Standard deviations by which a compliance has to be negative to be impossible: noise makes less of a small one."""
ROUNDING = 1e-6
"""Of the largest eigenvalue of a correlation matrix: an eigenvalue below minus that is no rounding."""


def relative_compliances(
    stated: Mapping[str, float], written: Sequence[float], robot: Robot, file: YamlDocument
) -> FloatArray:
    """Compliances (n_p,) in units of the robot file's, to the last bit as they were written.

    Args:
        stated: `compliance`, by actuator (m/N or rad/(N·m)).
        written: `relative_compliance`, the same in units of the robot file's; empty where the file leaves it out.
        robot: of the model.
        file: of the model.

    Raises:
        InputError: both contradict each other, or `robot.actuator_stiffness`, which is their ratio.
    """
    compliance = np.array(list(stated.values()))
    if not len(written):
        relative: FloatArray = compliance * robot.stiffness
        return relative
    found = np.array(written)
    if found.shape != compliance.shape:
        what = f"{len(compliance)} numbers are needed here, not {len(found)}"
        raise file.where("relative_compliance").fault(what, "One of each actuator.")
    apart = ~np.isclose(found * robot.compliance, compliance, rtol=SAME, atol=0.0)
    if apart.any():
        index = int(np.argmax(apart))
        what = (
            f"{compliance[index]:.6g} contradicts `relative_compliance` {found[index]:.6g}, which is its product with "
            f"the actuator stiffness {robot.stiffness[index]:.6g}"
        )
        remedy = f"Take `relative_compliance` out if `compliance` is right. {AGAIN}"
        raise file.where("compliance", list(stated)[index]).fault(what, remedy)
    return found


def require_yielding(compliance: FloatArray, covariance: FloatArray, robot: Robot, file: YamlDocument) -> None:
    """Raise an `InputError` where an actuator moves against its load.

    Args:
        compliance: of every actuator, shape (n_p,), in any unit.
        covariance: of all parameters (p, p) in the same unit, these first; infinite where one is not determined.
        robot: of the model.
        file: of the model.
    """
    deviation = np.sqrt(np.diag(covariance)[: len(compliance)])
    against = np.flatnonzero(compliance < -SURE * np.where(deviation > 0.0, deviation, 0.0))
    if against.size:
        name = robot.actuators[against[0]]
        what = "a negative compliance: under its load the actuator would move against it"
        raise file.where("compliance", name).fault(what, f"Correct the sign. {AGAIN}")


def covariance_of(rows: Sequence[Sequence[float]], count: int, place: YamlDocument) -> FloatArray:
    """A covariance (count, count); infinite variances mark what is not determined.

    Raises:
        InputError: it has another size, holds NaN or what no quantity has as a variance, or is not symmetric and
            positive semidefinite where it is finite.
    """
    if len(rows) != count or any(len(row) != count for row in rows):
        what = f"a matrix of {count}×{count} numbers is needed here"
        raise place.fault(what, "Order: `parameters`.")
    covariance = np.array(rows, dtype=float).reshape(count, count)
    strange = np.isnan(covariance) | (np.isfinite(covariance) & (np.abs(covariance) > LARGEST**2))
    if strange.any():
        row, column = (int(place) for place in np.argwhere(strange)[0])
        value = covariance[row, column]
        what = "NaN is no number" if np.isnan(value) else f"{value:.3g} is beyond any quantity in SI units"
        raise place.where(row, column).fault(what, AGAIN)
    known = np.isfinite(np.diag(covariance))
    inner = covariance[np.ix_(known, known)]
    if not np.isfinite(inner).all():
        raise place.fault("infinite beside finite variances: what is determined has finite covariances", AGAIN)
    variance = np.diag(inner)
    if np.any(np.diag(covariance) < 0.0) or not np.allclose(inner, inner.T, rtol=1e-6, atol=0.0):
        raise place.fault("a covariance is symmetric with a diagonal of variances", AGAIN)
    scale = np.sqrt(np.where(variance > 0.0, variance, 1.0))
    eigenvalues = np.linalg.eigvalsh(inner / np.outer(scale, scale)) if len(inner) else np.zeros(1)
    certain = np.any(inner[variance == 0.0] != 0.0)
    if certain or eigenvalues[0] < -ROUNDING * eigenvalues[-1]:
        what = "no covariance: some combination of the parameters would have a negative variance"
        raise place.fault(what, f"A correlation is between -1 and 1. {AGAIN}")
    return covariance


def require_ordered(ranges: Mapping[str, Sequence[float]], place: YamlDocument) -> None:
    """Raise an `InputError` where a range of `calibrated` ends before it begins."""
    for name, (low, high) in ranges.items():
        if low > high:
            what = f"the range is the wrong way round: {low:g} > {high:g}"
            raise place.where(name).fault(what, f"Low first, then high. {AGAIN}")

"""What `expdesign identify` prints of an identification: stiffnesses, geometry, fit and warnings, a line each."""

import numpy as np

from expdesign.estimation.identify import Identification
from expdesign.estimation.remarks import Implausible
from expdesign.report.arm_section import accuracy_lines, further_lines, geometry_line
from expdesign.report.check_texts import coverage_sentence, fit_sentences
from expdesign.report.identification_record import rms
from expdesign.report.remark_texts import sentences
from expdesign.report.stiffness import identified_stiffness, stiffness_lines


def identification_lines(result: Identification) -> list[str]:
    """What was identified, with 95 % intervals, and how well it fits."""
    lines = [*_geometry(result), *_stiffness(result), *fit_sentences(result)]
    noise = result.noise
    lines += [f"noise of the {one.name}, estimated from {noise.origin}: {one.deviation:.3g}" for one in noise.groups]
    held_out = rms(result.test_residuals)
    if held_out is not None:
        lines += [f"RMS of the test rows: {held_out:.3g} standard deviations", coverage_sentence(result.coverage)]
    return lines


def identification_warnings(result: Identification) -> list[str]:
    """What is doubtful, beside what is said of the recordings where they are read."""
    doubts = [each for each in result.suspicions if not isinstance(each, Implausible)]
    return [f"warning: {text}" for text in sentences(doubts)]


def _geometry(result: Identification) -> list[str]:
    if result.arm is not None:
        line = geometry_line(result)
        return [*([line] if line else []), *further_lines(result.arm), *accuracy_lines(result.arm)]
    if result.geometry is None:
        return []
    deviation = (result.geometry.high - result.geometry.low) / 4.0
    size = float(np.sqrt((result.geometry.estimate**2).mean()))
    known = f"known to {1e3 * float(np.median(deviation)):.3g} mm (median)"
    return [f"{len(deviation)} errors of joints and lengths: {1e3 * size:.3g} mm RMS, {known}"]


def _stiffness(result: Identification) -> list[str]:
    if not result.robot.actuators:
        return [f"a {result.robot.kind} has no actuators whose stiffness could be identified: does it deflect at all?"]
    if result.calibration == "geometric":
        return []
    return stiffness_lines(identified_stiffness(result), result.robot)

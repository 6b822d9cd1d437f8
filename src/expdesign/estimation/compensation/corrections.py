"""How large corrections are, and how well the pose is known that they attain."""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.models.estimable import Calibrated, OutsideRange
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.estimation.compensation.compensate import Compensation
from expdesign.estimation.coverage_factor import STANDARD
from expdesign.mechanics.robots.robot import Robot


@dataclass(frozen=True)
class Corrections:
    """Corrections of N commands, in the order of the targets.

    Attributes:
        translation: by how much the commanded platform or tip is beside the target (m), shape (N,).
        rotation: by what angle it is turned against it (rad), shape (N,); zero where poses have no orientation.
        expanded: U = k·u of the attained pose (m, rad), k = 2 (about 95 %), shape (N, n); infinite where the
            recordings did not determine it.
        beyond: what of each target lies outside of what was calibrated, N tuples.
    """

    translation: FloatArray
    rotation: FloatArray
    expanded: FloatArray
    beyond: tuple[tuple[OutsideRange, ...], ...]


def corrections_of(
    robot: Robot, targets: LoadedPoints, found: Compensation, calibrated: Calibrated | None
) -> Corrections:
    """The corrections that commands make: where the unloaded, nominal robot would stand, against the target."""
    there, wanted = found.commands, targets.configurations
    translation = np.linalg.norm(robot.position(there) - robot.position(wanted), axis=-1)
    turned = robot.jacobians(there).rotation - robot.jacobians(wanted).rotation
    # ‖R₁ − R₂‖_F = 2√2·sin(θ/2) keeps small angles exact, which the trace does not.
    chord = np.linalg.norm(turned, axis=(-2, -1)) / (2.0 * np.sqrt(2.0))
    rotation = 2.0 * np.arcsin(np.minimum(chord, 1.0)) * bool(robot.coordinates.rotations)
    beyond = [()] * len(targets) if calibrated is None else calibrated.beyond(targets, robot)
    return Corrections(translation, rotation, STANDARD.factor * found.deviations, tuple(beyond))

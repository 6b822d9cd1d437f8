"""A payload that droops under its own weight."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ...kinematics import Matrix, Pose
from ...loads import Load
from .law import Unlisted

if TYPE_CHECKING:
    from ...machine import Machine


@dataclass(frozen=True)
class DroopingPayload(Unlisted):
    """A slender payload bends under its own weight, and its centre of mass moves along the force that acts on it.

    A cantilever's end sags in proportion to its load, so the moment has a part that is quadratic in the load. Shift
    compliance_m_per_N times the force, in platform axes. Accepted: payload. `payload_com_offset` is no wrong name.
    """

    identifier: ClassVar[str] = "drooping_payload"
    also: ClassVar[tuple[str, ...]] = ("payload_com_offset",)
    compliance_m_per_N: float
    axis: Sequence[float]

    @property
    def parts(self) -> tuple[str, ...]:
        return ("payload",)

    def build(self, machine: Machine) -> None:
        turned: list[Matrix] = [np.eye(3)]
        axis = np.asarray(self.axis, dtype=float)

        def turn(platform: Pose) -> None:
            turned[0] = platform.rotation

        def bent(load: Load) -> Load:
            return load.shifted(self.compliance_m_per_N * float(axis @ turned[0].T @ load.force) * axis)

        machine.on_command.append(turn)
        machine.load_laws.append(bent)

"""Deflections: how far the load moves the platform, in pose coordinates, by a reading before and one after."""

from dataclasses import replace

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.parameter import Parameter
from expdesign.chain.readings.reading import Reading
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.recordings.remark import Remark
from expdesign.chain.row import Row
from expdesign.mechanics.robots.robot import Robot


class Deflection(Reading):
    """The reading is the deflection itself; own weight acts in both states and cancels."""

    names = ()
    absolute = False
    chord_steps = 2
    linear = True
    compliance_spread = float("inf")

    def __init__(self) -> None:
        self.start = np.zeros(0)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return ()

    @property
    def degeneracies(self) -> list[Remark]:
        return []

    @property
    def record(self) -> dict[str, object]:
        return {}

    def width(self, robot: Robot) -> int:
        return robot.coordinates.n

    def with_own_weight(self, row: Row, change: ca.SX) -> Row:
        return replace(row, own=row.own + change)

    def released(self, spreads: FloatArray) -> FloatArray:
        return spreads

    def displacement(self, robot: Robot, deflection: ca.SX, row: Row, theta: ca.SX, command: ca.SX) -> ca.SX:
        """Where the unloaded platform stands does not show."""
        return deflection

    def expression(self, robot: Robot, deflection: ca.SX, row: Row, theta: ca.SX, geometry: ca.SX | None) -> ca.SX:
        return deflection

    def at_points(self, points: LoadedPoints) -> LoadedPoints | None:
        return replace(points, marker=None, markers=(), aim=None, poses=False)


DEFLECTION = Deflection()

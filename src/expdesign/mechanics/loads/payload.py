"""A payload: a mass whose centre of mass has a place on the platform (file-formats.md, Conventions; theory.md 5.2)."""

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.coordinates import Coordinates
from expdesign.mechanics.loads.load import Load, small_rotation
from expdesign.mechanics.moments import moment


class Payload(Load):
    """Weight m·g at R·c from the origin of P; the parameters end with the gravity vector that acts on the mass."""

    kind = "payload"
    has_mass = True

    def __init__(self, coordinates: Coordinates) -> None:
        super().__init__(coordinates)
        self.columns = ("mass_kg", *coordinates.centre_of_mass, *coordinates.gravity)
        self.tilt = coordinates.tilt

    @property
    def keys(self) -> tuple[str, ...]:
        return (*self.own, "gravity")

    @property
    def own(self) -> tuple[str, ...]:
        return self.columns[: -len(self.gravity_columns)]

    @property
    def gravity_columns(self) -> tuple[str, ...]:
        return self.coordinates.gravity

    def payloads(self, loads: FloatArray) -> FloatArray | None:
        return loads[..., : len(self.own)]

    def centres(self, loads: FloatArray) -> FloatArray:
        return loads[..., 1 : len(self.own)]

    def gravities(self, loads: FloatArray, gravity: FloatArray) -> FloatArray:
        return loads[..., -len(gravity) :]

    def turned(self, parameters: ca.SX, rotation: ca.SX, angles: ca.SX) -> ca.SX:
        dimension = len(self.gravity_columns)
        gravity = small_rotation(parameters[-dimension:], angles)
        return self.wrench(ca.vertcat(parameters[:-dimension], gravity), rotation)

    def wrench(self, parameters: ca.SX, rotation: ca.SX) -> ca.SX:
        dimension, lever = len(self.coordinates.gravity), len(self.coordinates.centre_of_mass)
        force = parameters[0] * parameters[-dimension:]
        if not lever:
            return force
        return ca.vertcat(force, moment(rotation @ parameters[1 : 1 + lever], force))

    def defaults(self, gravity: FloatArray) -> FloatArray:
        return np.array([np.nan, *np.zeros(len(self.coordinates.centre_of_mass)), *gravity])

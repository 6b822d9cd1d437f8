"""A payload: a mass whose centre of mass has a place on the platform (file-formats.md, Conventions; theory.md 5.2)."""

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.coordinates import Coordinates
from expdesign.loads.load import Load
from expdesign.moments import moment


class Payload(Load):
    """Weight m·g at R·c from the origin of P; the parameters end with the gravity vector that acts on the mass."""

    kind = "payload"

    def __init__(self, coordinates: Coordinates) -> None:
        super().__init__(coordinates)
        self.columns = ("mass_kg", *coordinates.centre_of_mass, *coordinates.gravity)

    def wrench(self, parameters: ca.SX, rotation: ca.SX) -> ca.SX:
        dimension, lever = len(self.coordinates.gravity), len(self.coordinates.centre_of_mass)
        force = parameters[0] * parameters[-dimension:]
        if not lever:
            return force
        return ca.vertcat(force, moment(rotation @ parameters[1 : 1 + lever], force))

    def defaults(self, gravity: FloatArray) -> FloatArray:
        return np.array([np.nan, *np.zeros(len(self.coordinates.centre_of_mass)), *gravity])

"""What a load is: parameters that stand in the columns of a plan, and the wrench that they make.

A payload: a mass whose centre of mass has a place on the platform (file-formats.md, Conventions; theory.md 5.2).

A free wrench, as a force actuator or a cable applies it; it does not depend on the pose.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from functools import cached_property
from typing import ClassVar

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.coordinates import Coordinates
from expdesign.mechanics.robots.orientation import moment
from expdesign.mechanics.symbolic import BatchFunction


class Load(ABC):
    """One kind of load, acting on the platform of a robot with the given coordinates.

    Attributes:
        kind: the word in configurations.
        has_mass: whether it is a mass under gravity, whose first parameter is the mass.
        columns: names of the parameters of one load, in order; they are columns of plans and recordings.
        tilt: names of the tilts of gravity (rad) that can be chosen with it.
        keys: of `experiment.load` in a configuration.
    """

    kind: ClassVar[str]
    has_mass: ClassVar[bool] = False
    columns: tuple[str, ...]
    tilt: tuple[str, ...] = ()

    def __init__(self, coordinates: Coordinates) -> None:
        self.coordinates = coordinates

    @abstractmethod
    def wrench(self, parameters: ca.SX, rotation: ca.SX) -> ca.SX:
        """Wrench on the platform at the origin of P, components along the axes of O (N, N·m), shape (n,).

        Args:
            parameters: values of `columns`, shape (k,).
            rotation: R of the platform, shape (d, d).
        """

    @cached_property
    def _wrenches(self) -> BatchFunction:
        rotation, parameters = self.symbols
        return self.function("wrenches", [self.wrench(parameters, rotation)])

    def wrenches(self, rotation: FloatArray, loads: FloatArray) -> FloatArray:
        """Wrenches (..., n) of loads (..., k) at R of the platform (..., d, d)."""
        return self._wrenches(rows_first(rotation), loads)[0]

    @cached_property
    def symbols(self) -> tuple[ca.SX, ca.SX]:
        """R of the platform (d, d) and the parameters of a load (k,), of which a `function` is made."""
        dimension = len(self.coordinates.gravity)
        return ca.SX.sym("R", dimension, dimension), ca.SX.sym("load", len(self.columns))

    def function(self, name: str, outputs: Sequence[ca.SX]) -> BatchFunction:
        """Expressions of `symbols` as a function of R, `rows_first`, and of loads (..., k)."""
        rotation, parameters = self.symbols
        flat = ca.SX.sym("r", rotation.numel())
        # NumPy flattens rows first, CasADi columns first.
        matrix = ca.reshape(flat, *rotation.shape).T
        return BatchFunction(name, [flat, parameters], [ca.substitute(output, rotation, matrix) for output in outputs])

    @property
    def keys(self) -> tuple[str, ...]:
        return self.columns

    @property
    def own(self) -> tuple[str, ...]:
        """Names of the parameters that are chosen as they are, and do not follow from a tilt."""
        return self.columns

    @property
    def gravity_columns(self) -> tuple[str, ...]:
        """Names of the parameters that are the gravity that acts on it."""
        return ()

    def payloads(self, loads: FloatArray) -> FloatArray | None:
        """Mass and centre of mass (kg, m) of loads (..., k), shape (..., 1 + d); None where it has no mass."""
        return None

    def centres(self, loads: FloatArray) -> FloatArray:
        """Centre of mass in the platform frame (m) of loads (..., k), shape (..., d), or (..., 0) without one."""
        return loads[..., :0]

    def gravities(self, loads: FloatArray, gravity: FloatArray) -> FloatArray:
        """Gravity (m/s²) under loads (..., k) where it is `gravity` (d,) otherwise, shape (..., d)."""
        return np.broadcast_to(gravity, (*loads.shape[:-1], len(gravity)))

    @abstractmethod
    def turned(self, parameters: ca.SX, rotation: ca.SX, angles: ca.SX) -> ca.SX:
        """The wrench with the load turned by small angles about x and y of O, about the normal in the plane (rad)."""

    @abstractmethod
    def defaults(self, gravity: FloatArray) -> FloatArray:
        """Value of each column that a table leaves out, NaN where it must be given, shape (k,)."""


def rows_first(rotation: FloatArray) -> FloatArray:
    """Matrices (..., d, d) as vectors (..., d²), row after row."""
    return rotation.reshape(*rotation.shape[:-2], rotation.shape[-2] * rotation.shape[-1])


def tilted_gravity(gravity: FloatArray) -> BatchFunction:
    """Gravity in O by tilts of the base: Ry(tilt_y)·Rx(tilt_x)·g of (2,) in space, R(tilt)·g of (1,) in the plane."""
    if len(gravity) == 2:
        tilt = ca.SX.sym("tilt")
        c, s = ca.cos(tilt), ca.sin(tilt)
        found = ca.vertcat(c * gravity[0] - s * gravity[1], s * gravity[0] + c * gravity[1])
    else:
        tilt = ca.SX.sym("tilt", 2)
        cx, sx, cy, sy = ca.cos(tilt[0]), ca.sin(tilt[0]), ca.cos(tilt[1]), ca.sin(tilt[1])
        y, z = cx * gravity[1] - sx * gravity[2], sx * gravity[1] + cx * gravity[2]
        found = ca.vertcat(cy * gravity[0] + sy * z, y, -sy * gravity[0] + cy * z)
    return BatchFunction("tilt", [tilt], [found])


def tilts_of(gravities: FloatArray, gravity: FloatArray) -> FloatArray | None:
    """Tilts (m, 2), or (m, 1) in the plane, that turn gravity (d,) to some (m, d); None where none do, and in space
    where gravity without tilt is not along z.
    """
    if len(gravity) == 2:
        across = gravity[0] * gravities[:, 1] - gravity[1] * gravities[:, 0]
        tilts = np.arctan2(across, gravities @ gravity)[:, None]
    elif gravity[:2].any() or not gravity[2]:
        return None
    else:
        x, y, z = (gravities / gravity[2]).T
        tilts = np.column_stack([np.arctan2(-y, np.hypot(x, z)), np.arctan2(x, z)])
    again = tilted_gravity(gravity)(tilts)[0]
    return tilts if np.allclose(again, gravities, rtol=0.0, atol=1e-9 * float(np.linalg.norm(gravity))) else None


def small_rotation(vector: ca.SX, angles: ca.SX) -> ca.SX:
    """`vector` turned by small angles (rad): about x and y of O in space, about the normal in the plane.

    Exact to first order, which is all that an error propagation needs.
    """
    if vector.shape[0] == 2:
        return vector + angles[0] * ca.vertcat(-vector[1], vector[0])
    return vector + ca.cross(ca.vertcat(angles[0], angles[1], 0.0), vector)


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


class Wrench(Load):
    """Forces and moments at the origin of P along the axes of O."""

    kind = "wrench"

    def __init__(self, coordinates: Coordinates) -> None:
        super().__init__(coordinates)
        self.columns = coordinates.wrench

    def wrench(self, parameters: ca.SX, rotation: ca.SX) -> ca.SX:
        return parameters

    def turned(self, parameters: ca.SX, rotation: ca.SX, angles: ca.SX) -> ca.SX:
        split = self.coordinates.translations
        parts = [small_rotation(parameters[:split], angles)]
        if parameters.shape[0] > split:
            # About the normal of the plane a moment stays what it is.
            parts.append(small_rotation(parameters[split:], angles) if split == 3 else parameters[split:])
        return ca.vertcat(*parts)

    def defaults(self, gravity: FloatArray) -> FloatArray:
        return np.zeros(self.coordinates.n)

"""A narrow door to the multibody engine (exudyn): bodies, connectors, loads and equilibria.

Every equilibrium is the solution of the full nonlinear equations by Newton's method: positions and rotations
are finite, connectors follow the bodies. Masses do not matter, since there are no inertia terms and no weight
except the loads that are applied.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import Any, TypeAlias

import exudyn
import numpy as np

from .errors import LaboratoryError
from .kinematics import Matrix, Pose, Vector, rotation_angles, rotation_matrix

items: Any = import_module("exudyn.itemInterface")  # its constructors have no type hints
_ENGINE_ANGLES = "moving-xyz"  # convention of the engine's rotation coordinates

Placement: TypeAlias = Callable[[Pose], Pose]
"""Where a body is when nothing is loaded, given the commanded pose of the platform."""


@dataclass(frozen=True)
class Body:
    """A rigid body of the engine; its axes are those of O while the platform is at its home pose."""

    index: int
    node: int | None
    origin: Vector
    placement: Placement


@dataclass(frozen=True)
class Point:
    """A point fixed to a body, in the body's axes (m)."""

    body: Body
    local: Vector


class Engine:
    """One mechanical system. Build it, `assemble` it once, then change commands and loads and `solve`."""

    def __init__(self) -> None:
        self._container = exudyn.SystemContainer()
        self._system: Any = self._container.AddSystem()
        self._bodies: list[Body] = []
        self._stiffest = 0.0
        self._settings = exudyn.SimulationSettings()
        self.ground = Body(
            self._system.AddObject(items.ObjectGround()),
            None,
            np.zeros(3),
            lambda _: Pose(np.zeros(3), np.eye(3)),
        )

    def add_body(self, origin: Vector, placement: Placement) -> Body:
        """Add a rigid body whose reference position is `origin` (m, in O)."""
        node = self._system.AddNode(items.NodeRigidBodyRxyz(referenceCoordinates=[*map(float, origin), 0.0, 0.0, 0.0]))
        index = self._system.AddObject(items.ObjectRigidBody(nodeNumber=node, mass=1.0, inertia=[1, 1, 1, 0, 0, 0]))
        body = Body(index, node, np.asarray(origin, dtype=float), placement)
        self._bodies.append(body)
        return body

    def add_spring(
        self, start: Point, end: Point, stiffness: float, law: Callable[[float], float] | None = None
    ) -> int:
        """Add an axial spring (N/m) between two points, or a `law`: tension (N) from length (m)."""
        self._stiffest = max(self._stiffest, stiffness)
        parameters: dict[str, Any] = {"stiffness": stiffness, "referenceLength": 1.0}
        if law is not None:
            tension = law

            def force(mbs: Any, t: float, item: int, elongation: float, *_: float) -> float:  # the engine's signature
                return tension(elongation + 1.0)

            parameters["springForceUserFunction"] = force
        markers = [self._marker(start), self._marker(end)]
        return int(self._system.AddObject(items.ObjectConnectorSpringDamper(markerNumbers=markers, **parameters)))

    def add_bushing(self, start: Point, end: Point, stiffness: Matrix, axes: Matrix | None = None) -> int:
        """Join two bodies by a bushing, 6 x 6 (N/m, N, N m/rad), in `axes` fixed to the first body."""
        self._stiffest = max(self._stiffest, float(np.abs(stiffness).max()))
        return int(
            self._system.AddObject(
                items.ObjectConnectorRigidBodySpringDamper(
                    markerNumbers=[self._marker(start, axes), self._marker(end, axes)],
                    stiffness=np.asarray(stiffness, dtype=float),
                    useIntrinsicFormulation=True,
                )
            )
        )

    def add_field(self, point: Point, anchor: Vector, force: Callable[[Vector], Vector], stiffest: float = 0.0) -> None:
        """Apply a force (N, in O) to a point that depends on the point's displacement from `anchor` (m, in O).

        `stiffest`: how fast it may change (N/m).
        """
        self._stiffest = max(self._stiffest, stiffest)

        def law(mbs: Any, t: float, item: int, displacement: Any, *_: Any) -> list[float]:  # the engine's signature
            return [-float(f) for f in force(np.array(displacement, dtype=float))]

        self._system.AddObject(
            items.ObjectConnectorCartesianSpringDamper(
                markerNumbers=[self._marker(Point(self.ground, anchor)), self._marker(point)],
                stiffness=[1.0, 1.0, 1.0],
                springForceUserFunction=law,
            )
        )

    def add_joint(self, start: Point, end: Point, locked: tuple[int, int, int], axes: Matrix) -> None:
        """Lock the displacement of `end` along some of the `axes` fixed to the body of `start`."""
        self._system.AddObject(
            items.ObjectJointGeneric(
                markerNumbers=[self._marker(start, axes), self._marker(end, axes)],
                constrainedAxes=[*locked, 0, 0, 0],
            )
        )

    def add_load(self, body: Body) -> DeadLoad:
        """Add a force and a moment with directions fixed in O, at a point of a body that may be moved."""
        marker = self._marker(Point(body, np.zeros(3)))
        force = self._system.AddLoad(items.LoadForceVector(markerNumber=marker))
        moment = self._system.AddLoad(items.LoadTorqueVector(markerNumber=marker))
        return DeadLoad(self._system, marker, force, moment)

    def assemble(self) -> None:
        """Finish building."""
        self._system.Assemble()
        settings = self._settings
        settings.solution.file.write = False
        settings.solution.sensors.active = False
        settings.staticSolver.verboseMode = 0
        settings.staticSolver.numberOfLoadSteps = 1
        settings.staticSolver.adaptiveStep = False
        settings.staticSolver.newton.relativeTolerance = 1e-12
        # Residual in N and N m: 1e-8 N moves a 10 N/um leg by 1e-15 m. Very stiff connectors cannot do better
        # than rounding of the coordinates times their stiffness.
        settings.staticSolver.newton.absoluteTolerance = max(1e-8, 1e-15 * self._stiffest)

    def place(self, platform: Pose) -> None:
        """Put every body where it is without load at a commanded pose; Newton's method starts there."""
        coordinates = np.zeros(6 * len(self._bodies))
        for body in self._bodies:
            pose = body.placement(platform)
            where = self._slice(body)
            coordinates[where] = [
                *(pose.position - body.origin),
                *rotation_angles(pose.rotation, _ENGINE_ANGLES),
            ]
        self._start_from(coordinates)

    def solve(self) -> None:
        """Find the equilibrium, starting from the last one (or from `place`)."""
        try:
            converged = self._system.SolveStatic(self._settings)
        except (ValueError, RuntimeError) as error:
            raise LaboratoryError(f"no static equilibrium found: {str(error).strip().splitlines()[0]}") from None
        if converged is False:
            raise LaboratoryError("no static equilibrium found")
        self._start_from(self._system.systemData.GetODE2Coordinates())

    def pose(self, body: Body) -> Pose:
        """Where a body is in the last equilibrium."""
        if body.node is None:
            return Pose(np.zeros(3), np.eye(3))
        coordinates = self._system.systemData.GetODE2Coordinates()[self._slice(body)]
        return Pose(body.origin + coordinates[:3], rotation_matrix(coordinates[3:], _ENGINE_ANGLES))

    def position(self, point: Point) -> Vector:
        """Position of a point in O (m) in the last equilibrium."""
        return self.pose(point.body).point(point.local)

    def set_spring_length(self, spring: int, length: float) -> None:
        """Set the unstressed length of a spring (m)."""
        self._system.SetObjectParameter(spring, "referenceLength", float(length))

    def set_bushing_offset(self, bushing: int, offset: Vector) -> None:
        """Set the unstressed displacement (m) and rotation (rad) of a bushing, six numbers in its axes."""
        self._system.SetObjectParameter(bushing, "offset", [float(each) for each in offset])

    def spring_length(self, spring: int) -> float:
        """Length of a spring (m) in the last equilibrium."""
        return float(self._system.GetObjectOutput(spring, exudyn.OutputVariableType.Distance))

    def _marker(self, point: Point, axes: Matrix | None = None) -> int:
        place: dict[str, Any] = {"localPosition": [float(each) for each in point.local]}
        if axes is not None:
            frame = np.eye(4)
            frame[:3, :3], frame[:3, 3] = axes, point.local
            place = {"localHT": frame}
        return int(self._system.AddMarker(items.MarkerBodyRigid(bodyNumber=point.body.index, **place)))

    def _slice(self, body: Body) -> slice:
        first = self._system.GetNodeODE2Index(body.node)
        return slice(first, first + 6)

    def _start_from(self, coordinates: Vector) -> None:
        self._system.systemData.SetODE2Coordinates(coordinates, configuration=exudyn.ConfigurationType.Initial)


@dataclass(frozen=True)
class DeadLoad:
    """A force and a moment of constant direction on a body."""

    system: Any
    marker: int
    force: int
    moment: int

    def set(self, force: Vector, moment: Vector, local: Vector) -> None:
        """Set force (N, in O), moment (N m, in O) and the force's point (m, in the body's axes)."""
        self.system.SetMarkerParameter(self.marker, "localPosition", [float(each) for each in local])
        self.system.SetLoadParameter(self.force, "loadVector", [float(each) for each in force])
        self.system.SetLoadParameter(self.moment, "loadVector", [float(each) for each in moment])

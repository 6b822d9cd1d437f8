"""What a robot may offer beside its Jacobians; effects, readings and fits ask for these and never for its kind.

A robot says which capabilities it has (`Robot.on_legs`, `on_straight_legs`, `jointed`), and returns the object that has
one from the property of its name, most often itself. A new family of robots offers what it can, and gets the effects
that need no more than that. The closed form of inverse kinematics, on which most rests, is the abstract class
`ParallelRobot` itself.
"""

from typing import Protocol

import casadi as ca

from expdesign.arrays import FloatArray
from expdesign.mechanics.robots.kinematic_tree import KinematicTree


class StraightLegs(Protocol):
    """Actuators that are straight legs between a joint of the base and one of the platform.

    Attributes:
        platform_joints: in the platform's axes (m), shape (n_p, d).
    """

    platform_joints: FloatArray

    def leg_vectors(self, pose: ca.SX, geometry: ca.SX) -> ca.SX:
        """From base joint to platform joint in base axes (m), d×n_p."""
        ...


class Links(Protocol):
    """Links one after the other, with their masses and with errors of their geometry: robots commanded in joints.

    Attributes:
        tree: the kinematics, with all geometric errors and masses.
        low, high: limits of the joint coordinates (rad or m), infinite where there are none, shape (n_q,).
    """

    tree: KinematicTree
    low: FloatArray
    high: FloatArray

    def tip(self, q: ca.SX, geometry: ca.SX | None = None) -> tuple[ca.SX, ca.SX]:
        """Position (3,) in m and orientation (3×3) of the tip at joint coordinates (n_q,)."""
        ...

    def jacobian_expressions(self, configuration: ca.SX, geometry: ca.SX | None = None) -> tuple[ca.SX, ca.SX, ca.SX]:
        """J, J̌ and R with errors of the geometry."""
        ...

    def own_weight_expression(
        self, q: ca.SX, gravity: ca.SX, geometry: ca.SX | None = None, factors: ca.SX | None = None
    ) -> ca.SX:
        """Torques about the joints by the links' own weight (N·m or N), shape (n_q,)."""
        ...

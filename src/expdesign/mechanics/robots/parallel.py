"""Parallel robots: everything from one expression, the actuator coordinates q(X; geometry), lengths or angles.

theory.md section 2: ∂q/∂X = J̌⁻¹ (1.13), J⁻¹ = J̌⁻¹·T with Ẋ = T·η, T = blkdiag(I, E⁻¹), ω = E·α̇. All derivatives are
CasADi's; the inverses of these small matrices are taken numerically, for whole batches.
"""

from abc import abstractmethod
from functools import cached_property, partial
from typing import Self

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from expdesign.arrays import FloatArray
from expdesign.errors import ConvergenceError
from expdesign.mechanics.differentiation import plain
from expdesign.mechanics.robots.orientation import Orientation, angular_velocity_map, moments, velocities
from expdesign.mechanics.robots.robot import CommandedState, Jacobians, Robot, gravity_or_standard, invert
from expdesign.mechanics.symbolic import BatchFunction

_TOLERANCE = 1e-14
"""m of leg length; rounding of lengths below a metre is 1e-16."""
_PASSES = 30


class PosedRobot(Robot):
    """A platform that is commanded in poses.

    Attributes:
        home: origin of P in O at zero pose (m), shape (d,).
    """

    home: FloatArray

    @abstractmethod
    def rotation(self, pose: ca.SX) -> ca.SX:
        """R of the platform at a symbolic pose."""

    def pose_rate_map(self, pose: ca.SX) -> ca.SX:
        """T(X) with Ẋ = T·η (theory.md section 1), n×n."""
        translations = self.coordinates.translations
        rates = ca.SX.eye(self.coordinates.n)
        if self.coordinates.rotations == 3:
            velocity_map = angular_velocity_map(self.rotation(pose), pose[translations:])
            rates[translations:, translations:] = ca.inv_minor(velocity_map)
        return rates

    def frame(self, configuration: ca.SX, deflection: ca.SX, geometry: ca.SX | None = None) -> tuple[ca.SX, ca.SX]:
        pose = configuration + deflection
        return ca.SX(self.home) + pose[: self.coordinates.translations], self.rotation(pose)

    def position(self, configurations: FloatArray) -> FloatArray:
        return self.home + configurations[..., : self.coordinates.translations]


class ParallelRobot(PosedRobot):
    """A platform on limbs, one actuator each, whose coordinates are in closed form of the pose.

    Attributes:
        geometry: nominal geometry in the order of `geometry_names` (m), shape (n_g,). `base k x` and `platform k x`
            are positions of the joints of limb k in O and on the platform; their errors are part of the library then.
        geometry_names: e.g. `base 3 x`.
        leg_length: smallest and largest coordinate of an actuator (m or rad), or None.
    """

    on_legs = True
    geometry: FloatArray
    geometry_names: tuple[str, ...]
    leg_length: tuple[float, float] | None

    @abstractmethod
    def actuator_lengths(self, pose: ca.SX, geometry: ca.SX) -> ca.SX:
        """Actuator coordinates q (m or rad, see `units`), shape (n_p,), at a symbolic pose and geometry."""

    @abstractmethod
    def scaling_frame(self) -> tuple[FloatArray, float]:
        """Reference point in the platform frame (m) and length (m) that make twists commensurable (see `condition`)."""

    def commanded_state(self, configuration: ca.SX, gravity: ca.SX) -> CommandedState:
        lengths = self.actuator_lengths(configuration, ca.SX(self.geometry))
        position = ca.SX(self.home) + configuration[: self.coordinates.translations]
        return CommandedState(position, self.pose_rate_map(configuration), lengths, ca.SX.zeros(len(self.stiffness)))

    def jacobian_expressions(self, configuration: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
        lengths = self.actuator_lengths(configuration, ca.SX(self.geometry))
        pose_map = ca.solve(ca.jacobian(lengths, configuration), ca.SX.eye(self.coordinates.n))
        forward = ca.solve(self.pose_rate_map(configuration), pose_map)
        return forward, pose_map, self.rotation(configuration)

    def kinematics(self, configuration: ca.SX) -> list[ca.SX]:
        lengths = self.actuator_lengths(configuration, ca.SX(self.geometry))
        return [ca.jacobian(lengths, configuration), self.pose_rate_map(configuration), self.rotation(configuration)]

    @cached_property
    def _lengths(self) -> BatchFunction:
        pose = ca.SX.sym("X", self.coordinates.n)
        return BatchFunction("lengths", [pose], [self.actuator_lengths(pose, ca.SX(self.geometry))])

    @property
    def actuator_limits(self) -> tuple[FloatArray, FloatArray]:
        low, high = self.leg_length or (-np.inf, np.inf)
        return np.full(len(self.stiffness), low), np.full(len(self.stiffness), high)

    def lengths(self, poses: FloatArray) -> FloatArray:
        """Actuator coordinates (m or rad) at poses (..., n), shape (..., n_p)."""
        (lengths,) = self._lengths(poses)
        return lengths

    @cached_property
    def _rates(self) -> BatchFunction:
        pose, geometry = ca.SX.sym("X", self.coordinates.n), ca.SX.sym("g", len(self.geometry))
        lengths = self.actuator_lengths(pose, geometry)
        return BatchFunction("rates", [pose, geometry], [lengths, ca.jacobian(lengths, pose)])

    def pose_of(self, lengths: FloatArray, start: FloatArray, geometry: FloatArray | None = None) -> FloatArray:
        """Forward kinematics: poses (..., n) with given actuator coordinates, by Newton's method from poses nearby.

        q(X + δX) = q(X) + ∂q/∂X·δX (thesis 1.13); from within the workspace it converges quadratically, and where it
        does not, the coordinates belong to no pose near the start.

        Args:
            lengths: actuator coordinates (m or rad), shape (..., n_p).
            start: poses nearby, shape (..., n).
            geometry: joint coordinates in the order of `geometry_names` (m), shape (..., n_g); the robot's own if None.

        Raises:
            ConvergenceError: no pose near the start has these lengths.
        """
        coordinates = self.geometry if geometry is None else geometry
        batch = np.broadcast_shapes(lengths.shape[:-1], start.shape[:-1], coordinates.shape[:-1])
        pose: FloatArray = np.broadcast_to(start, (*batch, start.shape[-1])).copy()
        for _ in range(_PASSES):
            reached, rates = self._rates(pose, coordinates)
            missing = lengths - reached
            if not np.isfinite(rates).all():
                break
            pose += np.linalg.solve(rates, missing[..., None])[..., 0]
            if np.abs(missing).max() < _TOLERANCE * max(1.0, float(np.abs(lengths).max()) / 0.1):
                return pose
        what = "there is no pose with these leg lengths near the one that is expected"
        raise ConvergenceError(what, remedy="Check the lengths, or the geometry in the robot file.")

    @property
    def inverse_kinematics(self) -> "ParallelRobot":
        return self

    def actuator_coordinates(self, configurations: FloatArray) -> FloatArray:
        return self.lengths(configurations)

    def pose_rates(self, configurations: FloatArray) -> FloatArray:
        jacobians = self.jacobians(configurations)
        # J̌ = T·J, and J is square here.
        rates: FloatArray = jacobians.pose @ np.linalg.inv(jacobians.forward)
        return rates

    def jacobians_of(self, *kinematics: FloatArray) -> Jacobians:
        length_rates, pose_rates, rotation = kinematics
        inverse_forward = length_rates @ pose_rates
        forward = invert(inverse_forward)
        return Jacobians(
            forward,
            pose_rates @ forward,
            rotation,
            partial(self._condition, plain(inverse_forward), plain(forward), plain(rotation)),
        )

    def _condition(self, inverse: FloatArray, forward: FloatArray, rotation: FloatArray) -> FloatArray:
        """Scaled condition number κ = ‖J⁻¹S‖_F ‖S⁻¹J‖_F / n.

        S refers the twist to a point amid the platform joints and divides rotations by their spread, so that κ depends
        neither on units nor on where the platform frame lies; κ = 1 for an isotropic mechanism, and κ lies between
        κ₂/n and κ₂ of the scaled matrix.
        """
        n, translations = self.coordinates.n, self.coordinates.translations
        if n > translations:
            point, length = self.scaling_frame()
            lever = (rotation @ point)[..., None, :]
            # u·v + (b×u)·ω with v = v_c − ω×lever gives the moment column ((b − lever)×u) of the centred twist.
            directions = inverse[..., :translations]
            centred = inverse.copy()
            centred[..., translations:] -= moments(np.broadcast_to(lever, directions.shape), directions)
            centred[..., translations:] /= length
            centred_forward = forward.copy()
            centred_forward[..., :translations, :] += velocities(forward[..., translations:, :], lever)
            centred_forward[..., translations:, :] *= length
        else:
            centred, centred_forward = inverse, forward
        norms = np.linalg.norm(centred, axis=(-2, -1)) * np.linalg.norm(centred_forward, axis=(-2, -1))
        condition: FloatArray = np.nan_to_num(norms / n, nan=np.inf, posinf=np.inf)
        return condition


class StraightLegs(ParallelRobot):
    """A platform on straight legs, each between a joint of the base and one of the platform.

    Attributes:
        base_joints: in O (m), shape (n_p, d).
        platform_joints: in the platform's axes (m), shape (n_p, d).
    """

    on_straight_legs = True

    def __init__(
        self,
        *,
        base_joints: FloatArray,
        home: FloatArray,
        stiffness: FloatArray,
        platform_joints: FloatArray | None = None,
        orientation: Orientation = "fixed-xyz",
        gravity: ArrayLike | None = None,
        leg_length: tuple[float, float] | None = None,
        name: str = "",
    ) -> None:
        """See file-formats.md, Robot files.

        Args:
            base_joints: shape (n_p, d).
            home: shape (d,).
            stiffness: shape (n_p,).
            platform_joints: shape (n_p, d); None where all legs end at the tool point.
            orientation: of poses with three angles.
            gravity: shape (d,); the standard one if left out.
            leg_length: shortest and longest leg, or None.
            name: for reports; the kind if left out.
        """
        self.name = name or self.kind
        self.base_joints = np.asarray(base_joints, dtype=float)
        joints = {"base": self.base_joints}
        if platform_joints is not None:
            joints["platform"] = np.asarray(platform_joints, dtype=float)
        self.platform_joints: FloatArray = joints.get("platform", np.zeros(self.base_joints.shape))
        self.home = np.asarray(home, dtype=float)
        self.stiffness = np.asarray(stiffness, dtype=float)
        self.orientation = orientation if self.coordinates.rotations == 3 else None
        self.gravity = gravity_or_standard(gravity, len(self.home))
        self.leg_length = leg_length
        self.geometry = np.concatenate([each.ravel() for each in joints.values()])
        axes, legs = "xyz"[: len(self.home)], range(1, 1 + len(self.stiffness))
        self.geometry_names = tuple(f"{side} {leg} {axis}" for side in joints for leg in legs for axis in axes)

    def leg_vectors(self, pose: ca.SX, geometry: ca.SX) -> ca.SX:
        """From base joint to platform joint in base axes (m), d×n_p (theory.md 2.2: l = p + R b − a)."""
        legs, dimension = self.base_joints.shape
        base, *platform = (ca.reshape(each, dimension, legs) for each in ca.vertsplit(geometry, legs * dimension))
        ends = ca.repmat(ca.SX(self.home) + pose[:dimension], 1, legs)
        return (ends + self.rotation(pose) @ platform[0] if platform else ends) - base

    @property
    def straight_legs(self) -> Self:
        return self

    def actuator_lengths(self, pose: ca.SX, geometry: ca.SX) -> ca.SX:
        return ca.sqrt(ca.sum1(self.leg_vectors(pose, geometry) ** 2)).T

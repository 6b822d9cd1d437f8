"""The passive joints at the ends of a leg: they yield, and they resist rotation."""

from collections.abc import Sequence
from enum import StrEnum
from functools import partial

import casadi as ca

from expdesign.chain.component import each_leg, legs_and_all, on, passive_joint_turns
from expdesign.chain.declaration import Declaration, Input, Size, Variant
from expdesign.chain.declared_effect import DeclaredEffect
from expdesign.chain.effect import Parameter
from expdesign.chain.effects.legs.geometry import LegEnd
from expdesign.chain.form import Acting, Form
from expdesign.chain.row import Row
from expdesign.mechanics.robots.orientation import rotation_vector
from expdesign.mechanics.robots.robot import Robot


def _yields(at: Acting, theta: ca.SX, end: LegEnd) -> tuple[ca.SX, ca.SX]:
    """uᵀ·C·u·τ: the joint moves by −C·u·τ, and ∂q/∂a = −u. C is constant in the frame of the base or the platform."""
    # A row of J⁻¹ begins with the direction of the leg.
    split = at.row.gravity.shape[0]
    direction = at.row.inverse[at.index, :split].T
    if end is LegEnd.PLATFORM:
        direction = at.row.rotation.T @ direction
    x, y = direction[0], direction[1]
    if split == 2:
        along = theta[0] * x**2 + 2.0 * theta[1] * x * y
    else:
        z = direction[2]
        along = theta[0] * x**2 + theta[1] * y**2 + 2.0 * (theta[2] * x * y + theta[3] * x * z + theta[4] * y * z)
    return along * at.force, at.state


_ENDS = tuple(Form(partial(_yields, end=end), str(end)) for end in LegEnd)


class PassiveJointCompliance(DeclaredEffect):
    """A leg's passive joint, or its mount, yields differently along different directions.

    Only the part of the yielding that lies along the leg changes its length. A compliance that is the same in all
    directions is confounded with the leg's own; what shows is how the apparent compliance changes as the leg turns
    against the frame in which it is fixed. So C lacks the entry that the leg's own compliance stands for. Variants
    `base` and `platform` name the end.
    """

    identifier = "legs.passive_joint_compliance"
    physics = "passive_joint_compliance"
    declared = Declaration(
        left_out="anisotropic compliance of a leg's joint or its mount",
        phrase="soft passive joints of {component}",
        usually="universal and spherical joints, brackets",
        port="actuators",
        inputs=(Input.FORCE, Input.PLACE),
        sizes=(
            Size(
                "compliance_*",
                0.2,
                "assumed: a fifth of the leg's own compliance, which includes the mean of its joints",
                "actuator compliance",
            ),
        ),
    )

    at = on(lambda robot: robot.on_straight_legs, each_leg)
    says = "The {variant} joint of {component}, or its mount, yields differently along different directions."

    @classmethod
    def variants(cls, robot: Robot) -> Sequence[Variant]:
        # What a platform that does not turn is joined to yields as a base does.
        return _ENDS if robot.coordinates.rotations else _ENDS[:1]

    def describe(self) -> tuple[Parameter, ...]:
        entries = ("xx", "yy", "xy", "xz", "yz") if self.robot.coordinates.translations > 2 else ("xx", "xy")
        # Differences to the leg's own compliance; a joint that yields by 1 mm under 1 N holds no leg.
        return tuple(Parameter(f"compliance_{entry}_m_per_N", 1e-8, low=-1e-3, high=1e-3) for entry in entries)


class PassiveJoints(StrEnum):
    """What the joints at the ends of a leg resist."""

    CARDAN = ""
    BENDING = "bending"
    BASE = "base"
    PLATFORM = "platform"
    FLEXURES = "flexures"


_SHARES = {
    PassiveJoints.CARDAN: (1.0, 1.0, 0.5),
    PassiveJoints.BENDING: (1.0, 1.0, 0.0),
    PassiveJoints.BASE: (1.0, 0.0, 0.0),
    PassiveJoints.PLATFORM: (0.0, 1.0, 0.0),
    PassiveJoints.FLEXURES: (1.0, 1.0, 0.0),
}
"""Share of a joint's stiffness with which each variant resists what `passive_joint_turns` gives: joints in series
resist being turned about the leg with half of it."""


class PassiveJointStiffness(DeclaredEffect):
    """Joints or flexures resist rotation, with `joint_Nm_per_rad` at both ends of the legs.

    A leg between two joints with rotational stiffness k bends both of them as the platform moves: with the leg's own
    rotation ω_l = u×ṗ/q (ṗ the velocity of its upper end), the base joint turns by ω_l and the platform joint by
    ω − ω_l; about the leg itself the two joints are in series. This is a stiffness K_J beside that of the legs,
    ΔX = (K_C + K_J)⁻¹·ΔF, i.e. (I + diag(c)·JᵀK_J·J)·Δq = diag(c)·τ.

    Flexures that are relaxed at the zero pose are bent at every other one. The legs then carry forces τ₀ without any
    load, and the geometric stiffness of these adds to K_J, which itself follows from the energy of the bent joints.

    Variants: empty (joints without preload), `bending` (likewise, free to turn about the leg), `base` and `platform`
    (bending at that end alone) and `flexures` (relaxed at the zero pose).
    """

    identifier = "legs.passive_joint_stiffness"
    physics = "passive_joint_stiffness"
    declared = Declaration(
        left_out="resistance of a joint or flexure against rotation",
        phrase="stiff passive joints of {component}",
        usually="flexures and preloaded joints",
        port="passive joints",
        laws=("joints",),
        inputs=(Input.FORCE, Input.PLACE),
        sizes=(
            Size(
                "joint_Nm_per_rad", 50.0, "assumed: flexures or preloaded universal joints that turn by 1° under 1 N·m"
            ),
        ),
    )

    at = on(lambda robot: robot.on_straight_legs, legs_and_all)
    quantities = (Parameter("joint_Nm_per_rad", 100.0, low=0.0, high=1e7),)
    says = "The joints of {component} resist rotation with {joint_Nm_per_rad:.3g} N·m/rad."

    @classmethod
    def variants(cls, robot: Robot) -> list[Variant]:
        return list(PassiveJoints) if robot.coordinates.rotations == 3 else [PassiveJoints.CARDAN]

    def describe(self) -> tuple[Parameter, ...]:
        self.changes_geometry = self.variant is PassiveJoints.FLEXURES
        return super().describe()

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        stiffness = theta[0] * (self.bent(row) if self.variant is PassiveJoints.FLEXURES else self.relaxed(row))
        added = ca.diag(compliance) @ row.forward.T @ stiffness @ row.forward
        # (I + S)⁻¹·e = e − S·(I + S)⁻¹·e, of which an expression of the derivative at S = 0 is short.
        return elongation - added @ ca.solve(ca.SX.eye(elongation.shape[0]) + added, elongation), state

    def unloaded(self, pose: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        if self.variant is not PassiveJoints.FLEXURES:
            return pose
        return pose + row.pose_map @ (compliance * theta[0] * self.preload(row))

    def relaxed(self, row: Row) -> ca.SX:
        """K_J (n×n, twist coordinates) of relaxed joints of unit stiffness."""
        n = self.robot.coordinates.n
        total = ca.SX.zeros(n, n)
        shares = _SHARES[self.variant] if self.robot.coordinates.rotations else (1.0,)
        for leg in self.actuators:
            for turn, share in zip(passive_joint_turns(self.robot, row, leg), shares, strict=True):
                total += share * turn.T @ turn
        return total

    def bent(self, row: Row) -> ca.SX:
        """K_J + K_G(τ₀) per unit stiffness in twist coordinates, from the energy of joints relaxed at the zero pose.

        Of the end that the variant names, or of both. With W = T⁻ᵀ·∂U/∂X the wrench that bends the joints, the
        unloaded legs carry τ₀ = −Jᵀ·W; the derivative of the whole wrench W + J⁻ᵀ·τ₀ at constant τ₀ is the stiffness
        of the joints.
        """
        robot = self.robot.inverse_kinematics
        pose = ca.SX.sym("X", 6)
        held = ca.SX.sym("tau", 6)
        geometry = ca.SX(robot.geometry)
        lengths = robot.actuator_lengths(pose, geometry)
        rates = robot.pose_rate_map(pose)
        bending = rates.T @ ca.gradient(self._energy(pose), pose)
        wrench = bending + (ca.jacobian(lengths, pose) @ rates).T @ held
        derivative = ca.jacobian(wrench, pose) @ rates
        # τ₀ is held constant in the derivative, so it is put in last.
        return ca.substitute(ca.substitute(derivative, pose, row.pose), held, self.preload(row))

    def preload(self, row: Row) -> ca.SX:
        """τ₀ (n_p,) per unit stiffness: actuator forces that hold the bent joints without any load."""
        pose = ca.SX.sym("X", 6)
        bending = self.robot.inverse_kinematics.pose_rate_map(pose).T @ ca.gradient(self._energy(pose), pose)
        return -row.forward.T @ ca.substitute(bending, pose, row.pose)

    def _energy(self, pose: ca.SX) -> ca.SX:
        """Energy of joints of unit stiffness: ½(bending at the base² + bending at the platform² + ½ twist²).

        Of one end ½(bending² + ¼ twist²), so that those of both ends add up.
        """
        geometry = ca.SX(self.robot.inverse_kinematics.geometry)
        vectors = self.robot.straight_legs.leg_vectors(pose, geometry)
        relaxed = self.robot.straight_legs.leg_vectors(ca.SX.zeros(6), geometry)
        rotation = self.robot.inverse_kinematics.rotation(pose)
        turned = rotation_vector(rotation)
        energy = ca.SX(0)
        for leg in self.actuators:
            u = vectors[:, leg] / ca.norm_2(vectors[:, leg])
            home = relaxed[:, leg] / ca.norm_2(relaxed[:, leg])
            ends = {PassiveJoints.BASE: home, PassiveJoints.PLATFORM: rotation @ home}
            for end, relaxed_at in ends.items():
                if self.variant in (end, PassiveJoints.FLEXURES):
                    energy += 0.5 * (_angle_squared(u, relaxed_at) + 0.25 * ca.dot(u, turned) ** 2)
        return energy


def _angle_squared(a: ca.SX, b: ca.SX) -> ca.SX:
    """Square of the angle between unit vectors, smooth where it is zero (relative error 1e-5 at 0.5 rad)."""
    versine = 1.0 - ca.dot(a, b)
    return 2.0 * versine * (1.0 + versine / 6.0 + 2.0 * versine**2 / 45.0)

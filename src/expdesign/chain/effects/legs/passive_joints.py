"""The passive joints at the ends of a leg: they yield, and they resist rotation."""

from collections.abc import Sequence
from enum import StrEnum
from functools import lru_cache, partial

import casadi as ca

from expdesign.chain.component import each_leg, legs_and_all, on, passive_joint_turns
from expdesign.chain.declaration import Declaration, Input, Size, Variant
from expdesign.chain.effect import Effect, Parameter
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


class PassiveJointCompliance(Effect):
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


class PassiveJointStiffness(Effect):
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
        flexures = self.variant is PassiveJoints.FLEXURES
        stiffness = row.forward.T @ self.bent(row) @ row.forward if flexures else self._relaxed(row)
        added = ca.diag(compliance) @ (theta[0] * stiffness)
        # (I + S)⁻¹·e = e − S·(I + S)⁻¹·e, of which an expression of the derivative at S = 0 is short.
        return elongation - added @ ca.solve(ca.SX.eye(elongation.shape[0]) + added, elongation), state

    def unloaded(self, pose: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        if self.variant is not PassiveJoints.FLEXURES:
            return pose
        return pose + row.pose_map @ (compliance * theta[0] * self.preload(row))

    @property
    def _shares(self) -> tuple[float, ...]:
        return _SHARES[self.variant] if self.robot.coordinates.rotations else (1.0,)

    def _relaxed(self, row: Row) -> ca.SX:
        """Jᵀ·K_J·J (n_p×n_p) of relaxed joints of unit stiffness."""
        parts = [zip(self._shares, _of_turns(self.robot, row, leg), strict=True) for leg in self.actuators]
        return sum((share * part for leg in parts for share, part in leg), ca.SX(0.0))

    def resisting(self, row: Row, twist: ca.SX) -> ca.SX:
        """K_J·η, the wrench (n,) with which relaxed joints of unit stiffness resist a twist (n,)."""
        turns = [zip(self._shares, passive_joint_turns(self.robot, row, leg), strict=True) for leg in self.actuators]
        return sum((share * (turn.T @ (turn @ twist)) for leg in turns for share, turn in leg), ca.SX(0.0))

    def bent(self, row: Row) -> ca.SX:
        """K_J + K_G(τ₀) (n×n, twist coordinates) of joints of unit stiffness that are relaxed at the zero pose: of the
        end that the variant names, or of both.
        """
        return sum((_flexures(self.robot, row, self.variant)[0][leg] for leg in self.actuators), ca.SX(0.0))

    def preload(self, row: Row) -> ca.SX:
        """τ₀ (n_p,) per unit stiffness: actuator forces that hold the bent joints without any load."""
        return sum((_flexures(self.robot, row, self.variant)[1][leg] for leg in self.actuators), ca.SX(0.0))


_KEPT = 64
"""Expressions that are kept, so that all variants, and the effects at one leg and at all of them, share them."""


@lru_cache(maxsize=_KEPT)
def _of_turns(robot: Robot, row: Row, leg: int) -> list[ca.SX]:
    """(t·J)ᵀ·(t·J), (n_p×n_p) each, of the turns t of a leg's joints (`passive_joint_turns`)."""
    turned = [turn @ row.forward for turn in passive_joint_turns(robot, row, leg)]
    return [each.T @ each for each in turned]


@lru_cache(maxsize=_KEPT)
def _flexures(robot: Robot, row: Row, variant: Variant) -> tuple[list[ca.SX], list[ca.SX]]:
    """Stiffness (n×n) and preload τ₀ (n_p,) by the bent joints of every leg, from their energies U.

    With W = T⁻ᵀ·∂U/∂X the wrench that bends them, the unloaded legs carry τ₀ = −Jᵀ·W; the stiffness is the derivative
    of the whole wrench W + J⁻ᵀ·τ₀ at constant τ₀, Σ τ₀,k·H_k the second part of it.
    """
    closed_form, pose = robot.inverse_kinematics, ca.SX.sym("X", 6)
    rates = closed_form.pose_rate_map(pose)
    inverse = ca.jacobian(closed_form.actuator_lengths(pose, ca.SX(closed_form.geometry)), pose) @ rates
    wrenches = [rates.T @ ca.gradient(energy, pose) for energy in _energies(robot, pose, variant)]
    curvatures = [ca.jacobian(inverse[k, :].T, pose) @ rates for k in range(inverse.shape[0])]
    derivatives = [ca.jacobian(wrench, pose) @ rates for wrench in wrenches]
    found = ca.substitute(ca.cse([*wrenches, *curvatures, *derivatives]), [pose], [row.pose])
    wrenches, curvatures, derivatives = (found[i * len(wrenches) :][: len(wrenches)] for i in range(3))
    preloads = [-row.forward.T @ wrench for wrench in wrenches]
    bent = [sum((t[k] * h for k, h in enumerate(curvatures)), d) for d, t in zip(derivatives, preloads, strict=True)]
    return bent, preloads


def _energies(robot: Robot, pose: ca.SX, variant: Variant) -> list[ca.SX]:
    """Energy of each leg's joints of unit stiffness: ½(bending at the base² + bending at the platform² + ½ twist²).

    Of one end ½(bending² + ¼ twist²), so that those of both ends add up.
    """
    geometry, found = ca.SX(robot.inverse_kinematics.geometry), []
    rotation = robot.inverse_kinematics.rotation(pose)
    turned = rotation_vector(rotation)
    both = (ca.horzsplit(robot.straight_legs.leg_vectors(at, geometry)) for at in (pose, ca.SX.zeros(6)))
    for vector, relaxed in zip(*both, strict=True):
        u, home = vector / ca.norm_2(vector), relaxed / ca.norm_2(relaxed)
        ends = {PassiveJoints.BASE: home, PassiveJoints.PLATFORM: rotation @ home}
        bent = [_angle_squared(u, at) for end, at in ends.items() if variant in (end, PassiveJoints.FLEXURES)]
        found.append(sum((0.5 * (squared + 0.25 * ca.dot(u, turned) ** 2) for squared in bent), ca.SX(0.0)))
    return found


def _angle_squared(a: ca.SX, b: ca.SX) -> ca.SX:
    """Square of the angle between unit vectors, smooth where it is zero (relative error 1e-5 at 0.5 rad)."""
    versine = 1.0 - ca.dot(a, b)
    return 2.0 * versine * (1.0 + versine / 6.0 + 2.0 * versine**2 / 45.0)

"""Joints that follow others linearly: `<mimic>` tags of a URDF, and the couplings of a robot file.

A joint's coordinate is Σ multiplier·q + offset over the joints that it follows. Those may follow others in turn; what
remains are the leaders, joints that follow none. With such rules closed linkages are open trees: in a parallelogram the
elbow follows the motor that drives it and, with multiplier −1, the shoulder.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from pydantic import Field

from expdesign.errors import InputError
from expdesign.io.nearest import nearest
from expdesign.io.schema import Number, Section
from expdesign.io.yaml_reader import YamlDocument
from expdesign.mechanics.robots.urdf import Mimic, Urdf, UrdfJoint


class CouplingSection(Section):
    """One entry of `couplings` in a serial robot's file."""

    follows: dict[str, Number] = Field(
        min_length=1,
        description="Joints of the URDF that it follows, each with its multiplier (rad or m of this joint per rad or m "
        "of that).",
    )
    offset: Number = Field(default=0.0, description="Coordinate (rad or m) where those stand at zero.")


@dataclass(frozen=True)
class Motion:
    """What moves a joint: Σ multiplier·q over coordinates `terms` (index, multiplier), plus `offset`.

    `index` is the coordinate whose link begins at the joint.
    """

    index: int
    terms: tuple[tuple[int, float], ...]
    offset: float


@dataclass(frozen=True)
class Leading:
    """The leaders of a joint with their multipliers, and the offset."""

    multipliers: Mapping[str, float]
    offset: float


def leading(urdf: Urdf, joint: UrdfJoint, above: tuple[str, ...] = ()) -> Leading:
    """The joints that lead a joint, through any chain of rules.

    Raises:
        InputError: joints follow each other in a circle.
    """
    if not joint.mimics:
        return Leading({joint.name: 1.0}, 0.0)
    if joint.name in above:
        what = f"joint `{joint.name}` mimics itself"
        raise InputError(what, where=urdf.source, remedy="Correct <mimic>, or `couplings` in the robot file.")
    multipliers: dict[str, float] = {}
    offset = 0.0
    for mimic in joint.mimics:
        led = leading(urdf, urdf.joints[mimic.joint], (*above, joint.name))
        offset += mimic.offset + mimic.multiplier * led.offset
        for name, multiplier in led.multipliers.items():
            multipliers[name] = multipliers.get(name, 0.0) + mimic.multiplier * multiplier
    return Leading(multipliers, offset)


def coupled(urdf: Urdf, couplings: Mapping[str, CouplingSection], document: YamlDocument) -> Urdf:
    """The URDF with the couplings of a robot file in the place of its own `<mimic>` tags of these joints.

    Raises:
        InputError: a joint is not in the URDF, or does not move.
    """
    joints = dict(urdf.joints)
    for name, rule in couplings.items():
        for mentioned, keys in ((name, ("couplings", name)), *((n, ("couplings", name, n)) for n in rule.follows)):
            require_joint(urdf, mentioned, document.where(keys if len(keys) == 2 else ("couplings", name, "follows")))
        mimics = [Mimic(joint, multiplier, 0.0) for joint, multiplier in rule.follows.items()]
        mimics[0] = replace(mimics[0], offset=rule.offset)
        joints[name] = replace(joints[name], mimics=tuple(mimics))
    found = replace(urdf, joints=joints)
    for joint in found.joints.values():
        leading(found, joint)
    return found


def require_joint(urdf: Urdf, name: str, where: str) -> UrdfJoint:
    """The moving joint of that name; raises `InputError` where there is none."""
    moving = [joint.name for joint in urdf.joints.values() if joint.moves]
    if name not in moving:
        what = f"joint `{name}` of {urdf.source} does not move" if name in urdf.joints else (
            f"the URDF {urdf.source} has no joint `{name}`"
        )  # fmt: skip
        raise InputError(what, where=where, remedy=nearest(name, moving))
    return urdf.joints[name]

"""Read what elastostatics needs of a URDF file: which joint moves which link, how far, and what the links weigh.

The reader is the project's own because the kinematics needs the parameters themselves: every joint and every link frame
carries symbolic errors of its geometry (`kinematic_tree.py`), and joints that mimic others are followed. Of the readers
that were tried, adam-robotics 0.5 drops `<mimic>` and offers no frame errors. Meshes, collision shapes, inertia tensors
and dynamics have no meaning in statics and are passed over.

Joints that follow others linearly: `<mimic>` tags of a URDF, and the couplings of a robot file.

A joint's coordinate is Σ multiplier·q + offset over the joints that it follows. Those may follow others in turn; what
remains are the leaders, joints that follow none. With such rules closed linkages are open trees: in a parallelogram the
elbow follows the motor that drives it and, with multiplier −1, the shoulder.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from pydantic import Field

from expdesign.arrays import FloatArray
from expdesign.errors import InputError
from expdesign.io.nearest import nearest
from expdesign.io.schema import LARGEST, Number, Section
from expdesign.io.yaml_reader import read_text
from expdesign.mechanics.robots.orientation import rotations_of, transform

_MOVING = ("revolute", "continuous", "prismatic")
_FARTHEST = 2.0
"""Times the span of all joints; no link reaches farther."""
_ANY = float("inf")
"""Limits may be any number: some files write one for "none"."""
_SLACK = 2.0
"""m; by so much more a link without joints beyond it may reach."""
_DENSEST = 2e4
"""kg/m³; no link is denser, all of its surroundings counted in."""
_KINDS = (*_MOVING, "fixed", "floating", "planar")


@dataclass(frozen=True)
class Mimic:
    """The joint's coordinate is `multiplier`·q + `offset` with q that of the joint it mimics."""

    joint: str
    multiplier: float
    offset: float


@dataclass(frozen=True)
class UrdfJoint:
    """A joint between two links.

    Attributes:
        name, kind, parent, child: as in the file.
        origin: pose of the child's frame in the parent's at coordinate 0, homogeneous, shape (4, 4).
        axis: unit vector of the motion in the child's frame, shape (3,).
        low, high: limits (m or rad); infinite where there are none.
        mimic: what it follows, or None.
        effort: largest force or moment (N or N·m); infinite where the file states none.
        mimics: what it follows: its coordinate is the sum over them; none for a joint that follows nothing.
    """

    name: str
    kind: str
    parent: str
    child: str
    origin: FloatArray
    axis: FloatArray
    low: float
    high: float
    mimics: tuple[Mimic, ...] = ()
    effort: float = float("inf")

    @property
    def moves(self) -> bool:
        """Whether it has one coordinate."""
        return self.kind in _MOVING

    @property
    def slides(self) -> bool:
        """Whether this is along its axis, not about it."""
        return self.kind == "prismatic"


@dataclass(frozen=True)
class UrdfLink:
    """A link: mass (kg) and its centre in the link's frame (m), shape (3,)."""

    name: str
    mass: float
    centre: FloatArray


@dataclass(frozen=True)
class Urdf:
    """Links and joints by name, in the order of the file.

    Attributes:
        slides: how far frames of links are from where the file has them (m, in their axes), by link.
    """

    source: str
    links: dict[str, UrdfLink]
    joints: dict[str, UrdfJoint]
    slides: Mapping[str, FloatArray] = field(default_factory=dict)

    def path(self, base: str, tip: str) -> list[UrdfJoint]:
        """The joints from one link to another that it carries.

        Raises:
            InputError: a link is unknown, or the base does not carry the tip.
        """
        for name in (base, tip):
            if name not in self.links:
                raise _fault(self.source, f"there is no link `{name}`", nearest(name, self.links))
        above = {joint.child: joint for joint in self.joints.values()}
        path: list[UrdfJoint] = []
        link = tip
        while link != base:
            if link not in above:
                remedy = f"`{tip}` hangs on `{link}`; name a base link on the way to it."
                raise _fault(self.source, f"link `{base}` does not carry link `{tip}`", remedy)
            path.append(above[link])
            link = above[link].parent
        return path[::-1]


def read_urdf(path: Path) -> Urdf:
    """The links and joints of a URDF file.

    Raises:
        InputError: the file is missing, is no URDF, or its joints do not form a tree.
    """
    text = read_text(path)
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise _fault(str(path), "a document type is declared", "Remove it; a URDF needs none.")
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise _fault(str(path), f"not valid XML: {error}", "Correct the syntax there.") from None
    if root.tag != "robot":
        raise _fault(str(path), f"the outermost element is <{root.tag}>, not <robot>", "Name a URDF file.")
    links = [_link(element, str(path)) for element in root.findall("link")]
    joints = [_joint(element, str(path)) for element in root.findall("joint")]
    for names, what in (([link.name for link in links], "link"), ([joint.name for joint in joints], "joint")):
        repeated = next((name for name in names if names.count(name) > 1), None)
        if repeated is not None:
            raise _fault(str(path), f"there are two {what}s `{repeated}`", "Rename one of them.")
    urdf = Urdf(str(path), {link.name: link for link in links}, {joint.name: joint for joint in joints})
    _require_tree(urdf)
    _require_sensible_masses(urdf)
    return urdf


def _require_sensible_masses(urdf: Urdf) -> None:
    """Raise where a centre of mass lies far outside any robot of that size, or a mass would not fit into it."""
    travel = (joint.high - joint.low for joint in urdf.joints.values() if joint.slides)
    size = sum(float(np.linalg.norm(joint.origin[:3, 3])) for joint in urdf.joints.values())
    size += sum(way for way in travel if np.isfinite(way))
    for link in urdf.links.values():
        where, distance = f"{urdf.source}, link {link.name}", float(np.linalg.norm(link.centre))
        if distance > _FARTHEST * size + _SLACK:
            what = f"the centre of mass lies {distance:.4g} m from the link's frame, but all joints span {size:.3g} m"
            raise _fault(where, what, "Check the unit of <origin xyz=...> in <inertial> (m).")
        if link.mass > _DENSEST * (_FARTHEST * size + _SLACK) ** 3:
            what = f"a mass of {link.mass:.4g} kg does not fit into a robot whose joints span {size:.3g} m"
            raise _fault(where, what, "Check the unit of <mass value=...> (kg).")


def _require_tree(urdf: Urdf) -> None:
    parents: dict[str, str] = {}
    for joint in urdf.joints.values():
        for name in (joint.parent, joint.child):
            if name not in urdf.links:
                what = f"joint `{joint.name}` names the link `{name}`, which is not there"
                raise _fault(urdf.source, what, nearest(name, urdf.links))
        if joint.child in parents:
            raise _fault(urdf.source, f"link `{joint.child}` hangs on two joints", "A URDF describes a tree.")
        parents[joint.child] = joint.parent
        for mimic in joint.mimics:
            if mimic.joint not in urdf.joints:
                what = f"joint `{joint.name}` mimics `{mimic.joint}`, which is not there"
                raise _fault(urdf.source, what, nearest(mimic.joint, urdf.joints))
    for link in urdf.links:
        above, steps = link, 0
        while above in parents:
            above, steps = parents[above], steps + 1
            if steps > len(urdf.links):
                raise _fault(urdf.source, f"link `{link}` carries itself", "A URDF describes a tree.")


def _link(element: ElementTree.Element, source: str) -> UrdfLink:
    name = _name(element, "link", source)
    where = f"{source}, link {name}"
    inertial = element.find("inertial")
    mass = None if inertial is None else inertial.find("mass")
    if inertial is None or mass is None:
        return UrdfLink(name, 0.0, np.zeros(3))
    value = float(_numbers(mass.get("value", ""), 1, where, "the mass")[0])
    if value < 0.0:
        raise _fault(where, f"a mass cannot be negative ({value:g} kg)", "Correct it.")
    return UrdfLink(name, value, _origin(inertial, where)[:3, 3])


def _joint(element: ElementTree.Element, source: str) -> UrdfJoint:
    name, kind = _name(element, "joint", source), element.get("type", "")
    where = f"{source}, joint {name}"
    if kind not in _KINDS:
        raise _fault(where, f"unknown type of joint `{kind}`", f"Known: {', '.join(_KINDS)}.")
    ends = []
    for end in ("parent", "child"):
        found = element.find(end)
        if found is None or not found.get("link"):
            raise _fault(where, f"it has no <{end} link=...>", "Add it.")
        ends.append(str(found.get("link")))
    axis_element = element.find("axis")
    axis = np.array([1.0, 0.0, 0.0])
    if axis_element is not None:
        axis = _numbers(axis_element.get("xyz", "1 0 0"), 3, where, "the axis")
    length = float(np.linalg.norm(axis))
    if length == 0.0:
        if kind in _MOVING:
            raise _fault(where, "the axis has no direction", "Correct <axis xyz=...>.")
        length = 1.0
    low, high = _limits(element, kind, where)
    return UrdfJoint(name, kind, ends[0], ends[1], _origin(element, where), axis / length, low, high,
                     _mimics(element, where), _effort(element, where))  # fmt: skip


def _limits(element: ElementTree.Element, kind: str, where: str) -> tuple[float, float]:
    limit = element.find("limit")
    if limit is None or kind == "continuous" or limit.get("lower") is None or limit.get("upper") is None:
        return float("-inf"), float("inf")
    low = float(_numbers(limit.get("lower", ""), 1, where, "the lower limit", _ANY)[0])
    high = float(_numbers(limit.get("upper", ""), 1, where, "the upper limit", _ANY)[0])
    if low > high:
        raise _fault(where, f"the limits are the wrong way round: {low:g} > {high:g}", "Correct <limit>.")
    return low, high


def _effort(element: ElementTree.Element, where: str) -> float:
    """The largest force or moment that <limit> states; infinite where it states none, or 0, which stands for none."""
    limit = element.find("limit")
    if limit is None or limit.get("effort") is None:
        return float("inf")
    effort = float(_numbers(limit.get("effort", ""), 1, where, "the effort", _ANY)[0])
    return effort if effort > 0.0 else float("inf")


def _mimics(element: ElementTree.Element, where: str) -> tuple[Mimic, ...]:
    """What every <mimic> tag says; a joint with several follows their sum."""
    mimics: list[Mimic] = []
    for mimic in element.findall("mimic"):
        joint = mimic.get("joint")
        if not joint:
            raise _fault(where, "<mimic> names no joint", "Add `joint=...`.")
        if joint in [other.joint for other in mimics]:
            raise _fault(where, f"two <mimic> tags name the joint `{joint}`", "Take one of them out.")
        multiplier = float(_numbers(mimic.get("multiplier", "1"), 1, where, "the multiplier")[0])
        mimics.append(Mimic(joint, multiplier, float(_numbers(mimic.get("offset", "0"), 1, where, "the offset")[0])))
    return tuple(mimics)


def _origin(element: ElementTree.Element, where: str) -> FloatArray:
    """Homogeneous matrix of <origin xyz rpy>: R = Rz(yaw)·Ry(pitch)·Rx(roll)."""
    origin = element.find("origin")
    if origin is None:
        return np.eye(4)
    position = _numbers(origin.get("xyz", "0 0 0"), 3, where, "xyz")
    angles = _numbers(origin.get("rpy", "0 0 0"), 3, where, "rpy")
    return transform(rotations_of(angles), position)


def _numbers(text: str, count: int, where: str, what: str, largest: float = LARGEST) -> FloatArray:
    """`count` finite numbers; what is beyond `largest` is no length, angle or mass, and squares of it overflow."""
    try:
        values = np.array([float(word) for word in text.split()])
    except ValueError:
        values = np.zeros(0)
    if len(values) != count or not np.isfinite(values).all():
        plural = "numbers are" if count > 1 else "number is"
        raise _fault(where, f"{what} is `{text}`, where {count} {plural} needed", "Correct it.")
    if np.abs(values).max() > largest:
        raise _fault(where, f"{what} is `{text}`, beyond any quantity in SI units", "Correct the exponent.")
    return values


def _name(element: ElementTree.Element, what: str, source: str) -> str:
    name = element.get("name")
    if not name:
        raise _fault(source, f"a <{what}> has no name", "Add `name=...`.")
    return name


def _fault(where: str, what: str, remedy: str) -> InputError:
    return InputError(what, where=where, remedy=remedy)


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


def coupled(urdf: Urdf, couplings: Mapping[str, CouplingSection]) -> Urdf:
    """The URDF with the couplings of a robot file in the place of its own `<mimic>` tags of these joints.

    Raises:
        InputError: a joint is not in the URDF, or does not move.
    """
    joints = dict(urdf.joints)
    for name, rule in couplings.items():
        require_joint(urdf, name, str(rule.where()))
        for leader in rule.follows:
            require_joint(urdf, leader, str(rule.where("follows")))
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

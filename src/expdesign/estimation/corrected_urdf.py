"""A URDF with the geometry that was identified: origins of joints moved, and links where markers and instrument are.

The error E of a joint's frame and the offset δ of its coordinate make its `<origin>` origin·E·J(δ), J being the joint's
motion, so that commands stay those of the controller. Everything else in the file stays as it is. The error of a tip's
frame moves the origin of the fixed joint that carries the tip; a tip that a moving joint carries keeps its frame, and
a link `NAME_identified` has the corrected one.
"""

from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.io.yaml_reader import read_text
from expdesign.mechanics.robots.common_normals import as_in_file
from expdesign.mechanics.robots.kinematic_tree import FRAME_AXES, KinematicTree
from expdesign.mechanics.robots.orientation import angles_of_matrix, moved, rotations_of, transform
from expdesign.mechanics.robots.urdf import UrdfJoint


@dataclass(frozen=True)
class Attached:
    """A frame on a link.

    Attributes:
        name: of the link that has the frame.
        link: that carries it.
        pose: x, y, z (m), rx, ry, rz (rad) on it, shape (6,).
    """

    name: str
    link: str
    pose: FloatArray


def corrected_urdf(tree: KinematicTree, errors: FloatArray, attached: list[Attached]) -> str:
    """The text of the tree's URDF with geometric errors (in the order of `tree.geometry_names`) and further frames."""
    parser = ElementTree.XMLParser(target=ElementTree.TreeBuilder(insert_comments=True))
    root = ElementTree.fromstring(read_text(Path(tree.urdf.source)), parser)
    further = list(attached)
    elements = {str(element.get("name")): element for element in root.findall("joint")}
    for name, origin in corrected_origins(tree, errors).items():
        _write_origin(elements[name], pose_of(origin))
    for number, end in enumerate(tree.ends):
        if end.is_tip and _carrier(tree, end.name) is None:
            start = len(tree.coordinates) + len(FRAME_AXES) * number
            error = errors[start : start + len(FRAME_AXES)]
            if np.any(error):
                further.append(Attached(f"{end.name}_identified", end.name, error))
    for frame in further:
        ElementTree.SubElement(root, "link", {"name": frame.name})
        joint = ElementTree.SubElement(root, "joint", {"name": f"{frame.name}_joint", "type": "fixed"})
        ElementTree.SubElement(joint, "parent", {"link": frame.link})
        ElementTree.SubElement(joint, "child", {"link": frame.name})
        _write_origin(joint, frame.pose)
    ElementTree.indent(root)
    return '<?xml version="1.0"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def corrected_origins(tree: KinematicTree, errors: FloatArray) -> dict[str, FloatArray]:
    """Origins (4, 4) of the joints that errors move, by name, in the frames of the file."""
    origins: dict[str, FloatArray] = {}
    for number, end in enumerate(tree.ends):
        start = len(tree.coordinates) + len(FRAME_AXES) * number
        joint = _carrier(tree, end.name) if end.is_tip else tree.urdf.joints[end.name]
        if joint is not None:
            error = errors[start : start + len(FRAME_AXES)]
            origins[joint.name] = joint.origin @ transform(rotations_of(error[3:]), error[:3])
    for joint in tree.urdf.joints.values():
        motion = tree.motion(joint)
        if motion is None:
            continue
        terms = [(index, multiplier) for index, multiplier in motion.terms if index < len(tree.coordinates)]
        offset = float(sum(multiplier * errors[index] for index, multiplier in terms))
        if offset or joint.name in origins:
            motion_by = np.array(ca.DM(moved(joint.axis, ca.SX(offset), along=joint.slides)))
            origins[joint.name] = origins.get(joint.name, joint.origin) @ motion_by
    return {name: as_in_file(tree.urdf, tree.urdf.joints[name], origin) for name, origin in origins.items()}


def pose_of(matrix: FloatArray) -> FloatArray:
    """x, y, z (m), rx, ry, rz (rad) of a homogeneous matrix (4, 4); roll is 0 where it cannot be told from yaw."""
    return np.concatenate([matrix[:3, 3], angles_of_matrix(matrix[:3, :3])])


def _carrier(tree: KinematicTree, tip: str) -> UrdfJoint | None:
    """The fixed joint that carries a tip and nothing of the chain beyond it; None where there is none."""
    joint = next((each for each in tree.urdf.joints.values() if each.child == tip), None)
    return None if joint is None or joint.moves or tree.is_passed(tip) else joint


def _write_origin(joint: ElementTree.Element, pose: FloatArray) -> None:
    origin = joint.find("origin")
    if origin is None:
        origin = ElementTree.SubElement(joint, "origin")
    origin.set("xyz", " ".join(repr(float(value)) for value in pose[:3]))
    origin.set("rpy", " ".join(repr(float(value)) for value in pose[3:]))

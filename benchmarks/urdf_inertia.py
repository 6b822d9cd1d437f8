"""URDF files as pinocchio's reader wants them."""

from pathlib import Path
from xml.etree import ElementTree


def with_inertia(path: Path) -> str:
    """The URDF with an inertia tensor for every mass: pinocchio's reader asks for one, statics does not use it."""
    root = ElementTree.parse(path).getroot()
    zeros = dict.fromkeys(("ixy", "ixz", "iyz"), "0")
    for inertial in root.iter("inertial"):
        if inertial.find("inertia") is None:
            ElementTree.SubElement(inertial, "inertia", {**dict.fromkeys(("ixx", "iyy", "izz"), "1e-3"), **zeros})
    return ElementTree.tostring(root, encoding="unicode")

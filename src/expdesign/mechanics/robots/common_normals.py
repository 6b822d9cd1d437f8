"""Origins of revolute joints near their common normals, where a file has them far away along parallel axes.

Where an arm has a joint's origin along its axis moves nothing: the frame before and the one beyond take it up. Between
parallel axes a calibration by Denavit and Hartenberg's parameters determines the sum of such offsets alone, and
controllers hold some of hundreds of metres that cancel. Errors of manufacture are counted at the origins, and an angle
of 0.1 mrad would be worth centimetres there. With D_j = Trans(s_j·a_j) the slide of joint j along its axis a_j (in the
frame of its child link), constant transforms become D_p⁻¹·X·D_j, p being the joint before; poses of links become
X·D_j. The slides are those with the least Σ ‖origin‖² between consecutive joints.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.mechanics.robots.orientation import transform
from expdesign.mechanics.robots.urdf import Urdf, UrdfJoint, UrdfLink

CANCEL = 0.5
"""Part of the lengths between joints below which their offsets cancel; else origins stay where the file has them."""


def on_common_normals(urdf: Urdf, base: str, fixed: Sequence[str]) -> Urdf:
    """The URDF with the origins of its revolute joints slid along their axes, where offsets cancel.

    Args:
        urdf: as in the file.
        base: link at which the arm begins.
        fixed: links whose frames something is measured in or hangs in: tips and carriers of payloads.
    """
    steps = _steps(urdf, base, fixed)
    sliding = list(dict.fromkeys(joint.name for pair in steps for joint in pair if _slides(joint, base, fixed)))
    if not sliding:
        return urdf
    offsets, slopes = [], []
    for before, joint in steps:
        origin = _between(urdf, before, joint)
        slope = np.zeros((3, len(sliding)))
        if joint.name in sliding:
            slope[:, sliding.index(joint.name)] += origin[:3, :3] @ joint.axis
        if before is not joint and before.name in sliding:
            slope[:, sliding.index(before.name)] -= before.axis
        offsets.append(origin[:3, 3])
        slopes.append(slope)
    slides = np.linalg.lstsq(np.vstack(slopes), -np.concatenate(offsets), rcond=None)[0]
    lengths = [float(np.linalg.norm(offset)) for offset in offsets]
    shorter = [float(np.linalg.norm(o + slope @ slides)) for o, slope in zip(offsets, slopes, strict=True)]
    if sum(shorter) >= CANCEL * sum(lengths):
        return urdf
    by = dict(zip(sliding, slides, strict=True))
    return _slid(urdf, {urdf.joints[name].child: slide * urdf.joints[name].axis for name, slide in by.items()})


def _slides(joint: UrdfJoint, base: str, fixed: Sequence[str]) -> bool:
    return joint.kind in ("revolute", "continuous") and joint.child not in fixed and joint.child != base


def _steps(urdf: Urdf, base: str, fixed: Sequence[str]) -> list[tuple[UrdfJoint, UrdfJoint]]:
    """Consecutive moving joints from the base to every fixed link; the first, and a fixed one at the end, by itself."""
    steps: dict[tuple[str, str], tuple[UrdfJoint, UrdfJoint]] = {}
    for link in fixed:
        path = urdf.path(base, link)
        stops = [joint for joint in path if joint.moves or joint is path[-1]]
        for before, joint in zip((stops[0], *stops), stops, strict=False):
            steps[before.name, joint.name] = (before, joint)
    return list(steps.values())


def _between(urdf: Urdf, before: UrdfJoint, joint: UrdfJoint) -> FloatArray:
    """Constant transform (4, 4) from the link beyond one joint, or the base, to another joint's origin."""
    pose, link = joint.origin, joint.parent
    above = {each.child: each for each in urdf.joints.values()}
    while link in above and (before is joint or link != before.child) and not above[link].moves:
        pose, link = above[link].origin @ pose, above[link].parent
    return pose


def _slid(urdf: Urdf, slides: dict[str, FloatArray]) -> Urdf:
    """The URDF with the frames of links moved by `slides` (m, in themselves)."""
    none = np.zeros(3)
    joints = {}
    for name, joint in urdf.joints.items():
        before, beyond = (slides.get(link, none) for link in (joint.parent, joint.child))
        joints[name] = replace(joint, origin=_by(-before) @ joint.origin @ _by(beyond))
    links = {name: UrdfLink(name, link.mass, link.centre - slides.get(name, none)) for name, link in urdf.links.items()}
    return replace(urdf, links=links, joints=joints, slides=slides)


def as_in_file(urdf: Urdf, joint: UrdfJoint, origin: FloatArray) -> FloatArray:
    """An origin (4, 4) of a joint between the frames of its links as the file has them."""
    none = np.zeros(3)
    return _by(urdf.slides.get(joint.parent, none)) @ origin @ _by(-urdf.slides.get(joint.child, none))


def _by(shift: FloatArray) -> FloatArray:
    return transform(np.eye(3), shift)

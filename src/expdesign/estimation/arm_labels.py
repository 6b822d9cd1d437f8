"""Parameters of an arm's chain as people call them."""

from expdesign.chain.chain import Chain
from expdesign.chain.effects.joints.geometry import CalibratedGeometryError
from expdesign.mechanics.robots.kinematic_tree import FRAME_AXES
from expdesign.mechanics.robots.robot import Links


def labels_of(chain: Chain) -> list[str]:
    """`joint 2's compliance`, `the instrument's rz`, `marker ball's x`, `joint 2's zero`, `joint 3's frame, rx` ..."""
    labels = [f"joint {k + 1}'s compliance" for k in range(chain.compliances)]
    for parameter in chain.parameters[chain.compliances : chain.base]:
        whose, _, axis = parameter.name.rpartition(" ")
        axis = axis.rpartition("_")[0]
        labels.append(f"the instrument's {axis}" if whose == "instrument" else f"{whose}'s {axis}")
    for effect in chain.effects:
        if isinstance(effect, CalibratedGeometryError):
            labels += [geometry_label(chain.robot.links, index) for index in effect.indices]
        else:
            labels += [f"{effect.key}, {parameter.name}" for parameter in effect.parameters]
    return labels


def geometry_label(links: Links, index: int) -> str:
    """Of a geometric error of the tree: a joint's zero, or a coordinate of the frame of a joint or a tip."""
    count = len(links.tree.coordinates)
    if index < count:
        return f"joint {index + 1}'s zero"
    end, axis = links.tree.ends[(index - count) // len(FRAME_AXES)], FRAME_AXES[(index - count) % len(FRAME_AXES)]
    return f"{frame_owner(links, (index - count) // len(FRAME_AXES))}'s frame, {axis}" if end else ""


def frame_owner(links: Links, number: int) -> str:
    """Whose frame the far end of a link is: `joint 3`, the joint's name where it has no number, or a tip's."""
    end = links.tree.ends[number]
    if end.is_tip:
        return f"tip {end.name}"
    names = [joint.name for joint in links.tree.joints]
    return f"joint {names.index(end.name) + 1}" if end.name in names else f"joint {end.name}"

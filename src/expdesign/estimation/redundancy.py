"""Parameters of an arm as people call them, and which of them its recordings cannot tell apart."""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.chain import Chain
from expdesign.chain.effects.joints.geometry import CalibratedGeometryError
from expdesign.mechanics.minimal_set import MinimalSet
from expdesign.mechanics.robots.kinematic_tree import FRAME_AXES
from expdesign.mechanics.robots.serial import SerialRobot


@dataclass(frozen=True)
class Redundant:
    """A parameter that the fitted rows do not tell apart from others, and which stays as drawn.

    Attributes:
        name: of the parameter.
        stands_in: those that stand for it, largest share first, with what one unit of it adds to each; none where no
            row shows it.
    """

    name: str
    stands_in: tuple[tuple[str, float], ...]

    @property
    def sentence(self) -> str:
        """In words, e.g. `joint 1's zero cannot be told apart from the instrument (rz, x, y)`."""
        if not self.stands_in:
            return f"no fitted row shows {self.name}"
        owners: dict[str, list[str]] = {}
        for name, _ in self.stands_in:
            owner, _, part = name.partition("'s ")
            owners.setdefault(owner, []).append(part.replace("frame, ", ""))
        parts = [
            f"{owner}'s {own[0]}" if len(own) == 1 and own[0] == "zero" else f"{owner} ({', '.join(own)})"
            for owner, own in owners.items()
        ]
        listed = parts[0] if len(parts) == 1 else ", ".join(parts[:-1]) + f" and {parts[-1]}"
        return f"{self.name} cannot be told apart from {listed}"


def redundancies(found: MinimalSet, labels: list[str], sizes: FloatArray, *, share: float = 0.05) -> list[Redundant]:
    """What is dropped as combinations of what is kept; `sizes` (p,) make the shares of parameters comparable.

    Parameters with less than `share` of the largest part are not listed.
    """
    remarks = []
    for index, row in zip(found.dropped, found.combinations, strict=True):
        parts = np.abs(row) / sizes[found.kept]
        listed = [i for i in np.argsort(-parts) if parts[i] > share * parts.max(initial=0.0) and row[i] != 0.0]
        remarks.append(Redundant(labels[index], tuple((labels[found.kept[i]], float(row[i])) for i in listed)))
    return remarks


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


def geometry_label(links: SerialRobot, index: int) -> str:
    """Of a geometric error of the tree: a joint's zero, or a coordinate of the frame of a joint or a tip."""
    count = len(links.tree.coordinates)
    if index < count:
        return f"joint {index + 1}'s zero"
    end, axis = links.tree.ends[(index - count) // len(FRAME_AXES)], FRAME_AXES[(index - count) % len(FRAME_AXES)]
    return f"{frame_owner(links, (index - count) // len(FRAME_AXES))}'s frame, {axis}" if end else ""


def frame_owner(links: SerialRobot, number: int) -> str:
    """Whose frame the far end of a link is: `joint 3`, the joint's name where it has no number, or a tip's."""
    end = links.tree.ends[number]
    if end.is_tip:
        return f"tip {end.name}"
    names = [joint.name for joint in links.tree.joints]
    return f"joint {names.index(end.name) + 1}" if end.name in names else f"joint {end.name}"

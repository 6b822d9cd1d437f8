"""What a robot looks like: points in the base frame and the lines between them, for pictures in reports.

A kind of robot that wants to be drawn gives one `Drawing`; reports know nothing of legs or links.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Literal

from expdesign.arrays import FloatArray

Role = Literal["base", "actuator", "platform"]


@dataclass(frozen=True)
class DrawnPart:
    """Lines of one meaning.

    Attributes:
        name: what a legend calls it.
        role: what it is, which decides how it is drawn.
        paths: indices of points, each path one connected line.
    """

    name: str
    role: Role
    paths: tuple[tuple[int, ...], ...]


@dataclass(frozen=True)
class Drawing:
    """A robot at a batch of configurations.

    Attributes:
        points: in O (m), shape (..., k, d) with d = 2 or 3.
        origin: origin of the platform frame P in O (m), where wrenches refer to, shape (..., d).
        parts: lines between the points.
        components: components that a diagnosis can name (`leg 1`, `joint 1`, `link 1`) and the points that each joins;
            a leg begins at its base joint, and a joint is one point.
        directions: unit vectors in O along the axes of joints, by component, shapes (..., d).
    """

    points: FloatArray
    origin: FloatArray
    parts: tuple[DrawnPart, ...]
    components: Mapping[str, tuple[int, ...]] = field(default_factory=dict)
    directions: Mapping[str, FloatArray] = field(default_factory=dict)

    def segments(self, *roles: Role) -> Iterator[tuple[int, int]]:
        """Ends of the straight lines of parts with one of these roles, as indices of points, in their order."""
        for part in self.parts:
            for path in part.paths if part.role in roles else ():
                yield from pairwise(path)

    def paths(self, component: str) -> tuple[tuple[int, ...], ...]:
        """Lines that show a component of a diagnosis; none for what a picture does not show."""
        if component in self.components:
            return (self.components[component],)
        roles: dict[str, Role] = {"base": "base", "platform": "platform", "payload": "platform"}
        wanted = "actuator" if component.startswith("all ") else roles.get(component)
        return tuple(path for part in self.parts if part.role == wanted for path in part.paths)

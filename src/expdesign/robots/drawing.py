"""What a robot looks like: points in the base frame and the lines between them, for pictures in reports.

A kind of robot that wants to be drawn gives one `Drawing`; reports know nothing of legs or links.
"""

from dataclasses import dataclass
from typing import Literal

from expdesign.arrays import FloatArray

Role = Literal["base", "actuator", "platform"]


@dataclass(frozen=True)
class Part:
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
    """

    points: FloatArray
    origin: FloatArray
    parts: tuple[Part, ...]

"""Boxes in the range of a load, and what a measurement can tell at most anywhere in one (theory.md 10.7).

The maps of a measurement are affine in every load quantity taken alone, so that those within the range are mixtures of
those at its corners, with the weights of multilinear interpolation.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.design.optimality.information import MeasurementInformation
from expdesign.design.variables import Rows

Box = tuple[tuple[float, float], ...]
"""Ends of every load variable as parts of its range."""


@dataclass(frozen=True)
class LoadRange:
    """The range of the variables that set the load.

    Attributes:
        index: of the variables.
        values: smallest and largest value of each, as the variable has it.
        steps: parts of the range that a variable with choices can take, and the choice's index for each; None for
            intervals.
    """

    index: IntArray
    values: tuple[tuple[float, float], ...]
    steps: tuple[tuple[tuple[float, float], ...] | None, ...]

    @classmethod
    def of(cls, information: MeasurementInformation) -> "LoadRange":
        space = information.problem.space
        index = information.load_variables().index
        values: list[tuple[float, float]] = []
        steps: list[tuple[tuple[float, float], ...] | None] = []
        for place in index:
            domain = space.variables[place].domain
            values.append(space.variables[place].bounds)
            if not isinstance(domain, Rows):
                steps.append(None)
                continue
            column = domain.table[:, 0]
            low, span = column.min(), max(float(np.ptp(column)), 1e-300)
            order = np.argsort(column, kind="stable")
            steps.append(tuple((float((column[i] - low) / span), float(i)) for i in order))
        return cls(index, tuple(values), tuple(steps))

    @cached_property
    def bits(self) -> FloatArray:
        """Which end of each variable a corner of the whole range has, shape (v, l), as in `load_variables`."""
        return np.array(list(product((0.0, 1.0), repeat=len(self.index)))).reshape(
            2 ** len(self.index), len(self.index)
        )

    def halves(self) -> list[Box]:
        """The range cut once in every variable."""
        whole: Box = tuple((0.0, 1.0) for _ in self.index)
        boxes = [whole]
        for place in range(len(self.index)):
            boxes = [part for box in boxes for part in self.split(box, place)]
        return boxes

    def split(self, box: Box, place: int) -> list[Box]:
        """A box cut in the middle of one variable's part of it; the box itself where that cannot be cut."""
        low, high = box[place]
        steps = self.steps[place]
        if high <= low:
            return [box]
        if steps is None:
            ends = [(low, 0.5 * (low + high)), (0.5 * (low + high), high)]
        else:
            parts = [part for part, _ in steps if low <= part <= high]
            half = len(parts) // 2
            ends = [(parts[0], parts[half - 1]), (parts[half], parts[-1])]
        return [(*box[:place], end, *box[place + 1 :]) for end in ends]

    def variables(self, parts: FloatArray) -> FloatArray:
        """The load's variables (l,) at parts (l,) of its range."""
        found = []
        for part, steps, values in zip(parts, self.steps, self.values, strict=True):
            if steps is None:
                found.append(values[0] + part * (values[1] - values[0]))
            else:
                found.append(next(index for step, index in steps if step == part))
        return np.array(found)


class Boxes:
    """Boxes by number, and the mixtures of the whole range's corners at theirs.

    Args:
        loads: the range.
    """

    def __init__(self, loads: LoadRange) -> None:
        self.loads = loads
        self._numbers: dict[Box, int] = {}
        self._boxes: list[Box] = []
        self._corners: list[FloatArray] = []
        self._mixtures: FloatArray | None = None

    def add(self, box: Box) -> int:
        """The number of a box."""
        if box not in self._numbers:
            self._numbers[box] = len(self._boxes)
            self._boxes.append(box)
            ends = np.array(box).reshape(len(self.loads.index), 2)
            corners = np.where(self.loads.bits > 0.5, ends[:, 1], ends[:, 0])
            # The outermost corner comes first: it stands for the box.
            order = np.argsort(-np.abs(corners - 0.5).sum(axis=1), kind="stable")
            self._corners.append(corners[order])
        return self._numbers[box]

    @property
    def mixtures(self) -> FloatArray:
        """Weights of the range's corners at the corners of every box, shape (b, c, v)."""
        if self._mixtures is None or len(self._mixtures) < len(self._corners):
            at = np.array(self._corners)[:, :, None]
            self._mixtures = np.where(self.loads.bits > 0.5, at, 1.0 - at).prod(axis=3)
        return self._mixtures

    def outermost(self, number: int) -> FloatArray:
        """The load's variables (l,) at the corner that stands for a box."""
        return self.loads.variables(self._corners[number][0])

    def loads_in(self, number: int) -> FloatArray | None:
        """The load's variables (c, l) at all loads of a box; None where they are infinitely many."""
        listed = []
        for (low, high), steps in zip(self._boxes[number], self.loads.steps, strict=True):
            if steps is None and high > low:
                return None
            listed.append([low] if steps is None else [part for part, _ in steps if low <= part <= high])
        return np.array([self.loads.variables(np.array(parts)) for parts in product(*listed)])

    def split(self, number: int, corner: int) -> list[int]:
        """The halves of a box, cut in the variable in which a corner is farthest from the first; none where it is
        the first.
        """
        corners = self._corners[number]
        apart = np.abs(corners[corner] - corners[0])
        if not (apart > 0.0).any():
            return []
        return [self.add(half) for half in self.loads.split(self._boxes[number], int(apart.argmax()))]

"""What these recordings let a port see: which quantities vary, and by how much."""

from collections.abc import Iterable

import numpy as np

from expdesign.arrays import BoolArray, FloatArray
from expdesign.chain.ports.quantities import Quantity, evaluate
from expdesign.chain.row import Row, RowData
from expdesign.mechanics.robots.robot import Robot

_VARIES = 1e-9


class Sight:
    """Quantities of all rows, evaluated when they are first asked for.

    Args:
        robot: the robot.
        row: symbols of one row of its chain.
        rows: the numbers.
        counts: rows that may be fitted, shape (N,); spreads are taken over them.
        axes: measured components.
        timed: whether the recordings state times.
    """

    def __init__(
        self, robot: Robot, row: Row, rows: RowData, counts: BoolArray, axes: list[int], *, timed: bool
    ) -> None:
        self.robot, self.row, self.rows, self.counts, self.axes = robot, row, rows, counts, axes
        self.timed = timed
        self.positions = row.marker.shape[0] > 0
        self._values: dict[Quantity, FloatArray] = {}

    @property
    def pose(self) -> tuple[Quantity, ...]:
        """Every coordinate of the command."""
        return tuple(Quantity("pose", index) for index in range(len(self.robot.configuration)))

    @property
    def remembers(self) -> bool:
        """Whether some series has several rows, without which nothing shows that depends on the row before."""
        return int(self.rows.position.max()) >= 1

    def look(self, quantities: Iterable[Quantity]) -> None:
        """Evaluate quantities together."""
        missing = [quantity for quantity in dict.fromkeys(quantities) if quantity not in self._values]
        if missing:
            values = evaluate(missing, self.rows, self.row, self.robot)
            self._values |= dict(zip(missing, values.T, strict=True))

    def values(self, quantity: Quantity) -> FloatArray:
        """A quantity in all rows, shape (N,)."""
        self.look([quantity])
        return self._values[quantity]

    def spread(self, quantity: Quantity) -> float:
        """Standard deviation over the rows that count; 0 for what is constant but for rounding."""
        values = self.values(quantity)[self.counts]
        spread = float(values.std())
        return spread if spread > _VARIES * float(np.abs(values).max(initial=0.0)) else 0.0

    def largest(self, quantity: Quantity) -> float:
        """Largest modulus over the rows that count."""
        return float(np.abs(self.values(quantity)[self.counts]).max(initial=0.0))

    def varies(self, *quantities: Quantity) -> bool:
        """Whether every one of them varies."""
        return all(self.spread(quantity) > 0.0 for quantity in quantities)

    def varying(self, kind: str, count: int) -> tuple[Quantity, ...]:
        """Those of the quantities `kind` 0 ... count − 1 that vary."""
        several = [Quantity(kind, index) for index in range(count)]
        self.look(several)
        return tuple(quantity for quantity in several if self.spread(quantity) > 0.0)

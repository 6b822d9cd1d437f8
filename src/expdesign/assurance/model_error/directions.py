"""How left-out physics moves the readings and the targets, to first order.

All physics without memory stands on one measurement chain, beside what is known of the robot: one Jacobian of its
reading then holds the directions of all of it. Physics with memory has kinks at which it would disturb the derivatives
of other physics, and stands on a chain of its own.
"""

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.assurance.model_error.left_out import Omitted, offsets
from expdesign.chain.chain import Chain
from expdesign.chain.readings.reading import DEFLECTION
from expdesign.chain.row import RowData


class Directions:
    """Derivatives of what a robot does with respect to the parameters of left-out physics that are not shapes.

    Args:
        base: the chain beside which the physics is left out; it ends with the instrument's reading.
        values: its parameters, shape (p,).
        physics: what is left out.
    """

    def __init__(self, base: Chain, values: FloatArray, physics: tuple[Omitted, ...]) -> None:
        self.base, self.values, self.physics = base, values, physics
        self._chains: dict[tuple[tuple[int, ...], bool], Chain] = {}

    def at(self, rows: RowData) -> tuple[FloatArray, FloatArray]:
        """Derivatives of readings with respect to the base's parameters (N, r, p) and to the physics (N, r, D)."""
        groups = self._groups()
        found = [self._of(group, rows, platform=False) for group in groups]
        return found[0][..., : len(self.values)], self._gathered(groups, found)

    def of_platform(self, rows: RowData) -> FloatArray:
        """Derivatives of the motion of the platform with respect to the physics, shape (N, n, D)."""
        groups = self._groups()
        return self._gathered(groups, [self._of(group, rows, platform=True) for group in groups])

    def change(self, index: int, rows: RowData, size: float, *, platform: bool) -> FloatArray:
        """What physics with a step changes at a size in its prior ones: readings, or the platform's motion, (N, r)."""
        chain, entry = self._chain((index,), platform=platform), self.physics[index]
        start = np.concatenate([self.values, entry.start])
        end = np.concatenate([self.values, entry.start + size * (entry.stepped - entry.start)])
        return chain.predict(rows, end) - chain.predict(rows, start)

    def _groups(self) -> list[tuple[int, ...]]:
        """Indices of physics that stands on one chain, first that without memory which does not act on the reading."""
        plain, read, alone = list[int](), list[int](), list[tuple[int, ...]]()
        for index, entry in enumerate(self.physics):
            if entry.effect.states:
                alone.append((index,))
            else:
                (read if entry.effect.changes_reading else plain).append(index)
        return [tuple(plain), *([tuple(read)] if read else []), *alone]

    def _chain(self, group: tuple[int, ...], *, platform: bool) -> Chain:
        """The chain of a group, which ends with the reading or with the motion of the platform."""
        effects = (*self.base.effects, *(self.physics[index].effect for index in group))
        # Where nothing acts on the reading of a deflection it is the motion of the platform.
        reads = self.base.reading is not DEFLECTION or any(effect.changes_reading for effect in effects)
        key = group, not (platform and reads)
        if key not in self._chains:
            self._chains[key] = Chain(self.base.robot, effects, instrument=key[1], reading=self.base.reading)
        return self._chains[key]

    def _of(self, group: tuple[int, ...], rows: RowData, *, platform: bool) -> FloatArray:
        """Derivatives with respect to the base's parameters and those of a group, shape (N, r, p + columns)."""
        entries, known = [self.physics[index] for index in group], len(self.values)
        if entries and entries[0].step:
            mean = self.change(group[0], rows, 1.0, platform=platform)[..., None] / entries[0].step
            return np.concatenate([np.zeros((*mean.shape[:2], known)), mean], axis=-1)
        chain = self._chain(group, platform=platform)
        values = np.concatenate([self.values, *(entry.start for entry in entries)])
        free = [i for i, parameter in enumerate(chain.parameters) if i < known or not parameter.shape]
        return chain.predict_with_sensitivities(rows, values)[1][..., free]

    def _gathered(self, groups: list[tuple[int, ...]], found: list[FloatArray]) -> FloatArray:
        """The columns of all groups in the order of the physics."""
        start: IntArray = offsets(self.physics)
        whole = np.empty((*found[0].shape[:2], int(start[-1])))
        for group, columns in zip(groups, found, strict=True):
            chosen = [np.arange(start[i], start[i + 1]) for i in group]
            if chosen:
                whole[..., np.concatenate(chosen)] = columns[..., len(self.values) :]
        return whole

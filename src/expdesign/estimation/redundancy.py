"""Minimal complete sets of parameters: which columns of the sensitivities are combinations of others, and of which.

A kinematic chain has more parameters than its readings can show: a shift along the axis of a revolute joint is one of
the next joint's frame, a turn about it is the joint's zero, the first joint's zero is a turn of the base. As in
Gautier's base parameters (J. Robotic Systems 8, 1991, 485) an orthogonal factorisation finds them, here in an order of
preference instead of by pivoting on norms: what people know by name (instrument, markers, zeros) is kept before frames,
and two sets of recordings of one machine name the same parameters.
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.chain.recordings.recordings import Remark


@dataclass(frozen=True)
class BlindPoses(Remark):
    """Parameters that other poses would tell apart, and the fitted ones do not.

    Attributes:
        names: of the parameters, which stay as drawn.
    """

    names: tuple[str, ...]


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


@dataclass(frozen=True)
class MinimalSet:
    """A choice among p parameters.

    Attributes:
        kept: indices of the parameters that are identified, in increasing order.
        dropped: of those that stay as drawn.
        combinations: what a unit of every dropped parameter adds to every kept one, shape (len(dropped), len(kept)).
    """

    kept: IntArray
    dropped: IntArray
    combinations: FloatArray

    def widened(self, deviations: FloatArray) -> FloatArray:
        """Deviations (p,) of the kept parameters with the part of the dropped ones that these stand for."""
        result = deviations.copy()
        added = (self.combinations**2 * (deviations[self.dropped] ** 2)[:, None]).sum(axis=0)
        result[self.kept] = np.sqrt(deviations[self.kept] ** 2 + added)
        return result


def minimal_set(matrix: FloatArray, order: IntArray, tolerance: float) -> MinimalSet:
    """The first parameters in `order` (p,) whose columns of `matrix` (M, p) are independent of those before them.

    Args:
        matrix: sensitivities, columns in comparable units.
        order: indices of the parameters, the preferred ones first; others are neither kept nor dropped.
        tolerance: part of a column's norm that has to be left.
    """
    reduced: FloatArray = np.asarray(np.linalg.qr(matrix, mode="r"))
    norms = np.linalg.norm(reduced, axis=0)
    basis, kept, dropped = np.zeros((len(reduced), 0)), [], []
    for index in order.tolist():
        left = reduced[:, index] / norms[index] if norms[index] > 0.0 else np.zeros(len(reduced))
        for _ in range(2):  # twice is enough (Kahan, in Parlett, The Symmetric Eigenvalue Problem, 1980, 6.9)
            left = left - basis @ (basis.T @ left)
        size = float(np.linalg.norm(left))
        if norms[index] > tolerance * norms.max() and size > tolerance:
            basis = np.column_stack([basis, left / size])
            kept.append(index)
        else:
            dropped.append(index)
    chosen, others = np.array(sorted(kept), dtype=np.int64), np.array(dropped, dtype=np.int64)
    scale = np.where(norms > 0.0, norms, 1.0)
    solved = np.linalg.lstsq(reduced[:, chosen] / scale[chosen], reduced[:, others] / scale[others], rcond=None)[0]
    combinations = (solved * scale[others] / scale[chosen][:, None]).T
    return MinimalSet(chosen, others, np.where(np.abs(combinations) < tolerance, 0.0, combinations))


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

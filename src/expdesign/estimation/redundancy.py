"""Parameters of an arm that its recordings cannot tell apart, in words."""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.recordings.recordings import Remark
from expdesign.mechanics.minimal_set import MinimalSet


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

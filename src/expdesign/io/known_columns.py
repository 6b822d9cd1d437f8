"""Columns that are known, in other spellings: in capitals, with other marks, without their unit, in other words.

What can mean one thing only is read so (`SEQUENCE`); what is nearly a known name is refused with that name, because a
column that is dropped changes what is identified from the others. Which columns there are is data: of recordings and
points `chain/recordings/columns.py` declares them, and hands them to whoever reads a table.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

from expdesign.io.units import SI, measured_column


@dataclass(frozen=True)
class KnownColumns:
    """The columns that a table may have.

    Attributes:
        names: with their SI units, where they have one.
        words: what people call them: letters and digits alone, in lower case, by name.
        numbered: names in which a number stands (`q{}_rad`), by what people write (without marks, in lower case), of
            which the group that is filled is the number.
        asked: what is said of a column that is missing, by name.
    """

    names: tuple[str, ...] = ()
    words: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    numbered: Mapping[str, re.Pattern[str]] = field(default_factory=dict)
    asked: Mapping[str, str] = field(default_factory=dict)

    def has_unit(self, name: str) -> bool:
        """Whether a known column has a unit."""
        return measured_column(name) is not None

    def in_other_letters(self, name: str) -> str | None:
        """The column without a unit that has this name in other letters, or None."""
        lower = name.strip().lower().replace(" ", "_")
        return lower if lower in self.names and not self.has_unit(lower) else None

    def meant(self, name: str) -> str | None:
        """The column whose name this is but for marks and the unit (`dxm`, `x`, `J1`), or None.

        Joints of a URDF may have any name, which its columns have with their unit: `j1_rad` is none in other letters.
        """
        compact = _compact(name)
        for numbered, written in self.numbered.items():
            if found := written.fullmatch(compact):
                return numbered.format(next(filter(None, found.groups())))
        return self._without_marks.get(compact)

    def hint(self, name: str) -> str | None:
        """The column to ask after where a name is not known, which may be another word (`Masse`, `Seq`), or None."""
        compact = _compact(name)
        own = self.meant(name.removesuffix("_rad"))
        return own or next((known for known, words in self.words.items() if compact in words), None)

    @cached_property
    def _without_marks(self) -> dict[str, str]:
        """Names by their letters and digits, with and without the unit."""
        found = {_compact(name): name for name in self.names}
        for name in self.names:
            found.setdefault(_compact(_WITH_UNIT.sub("", name)), name)
        return found


_WITH_UNIT = re.compile(rf"_({'|'.join(SI.values())})$")


def _compact(name: str) -> str:
    return re.sub(r"[\W_]", "", name).lower()


NONE_KNOWN = KnownColumns()
"""Of tables in which any name is right."""

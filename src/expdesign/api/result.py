"""What the functions of the package return: one short line to look at, and what other functions take of it."""

from dataclasses import dataclass, field
from typing import ClassVar

import pandas as pd

from expdesign.files.written import Purpose
from expdesign.models.model_file import Model


@dataclass(frozen=True, repr=False)
class Result:
    """A result.

    Attributes:
        FILES: of the class: names of the files that `save` writes into a folder, `*` for any characters.
        purpose: the command and the main inputs; `save` replaces what was written for the same.
    """

    FILES: ClassVar[tuple[str, ...]] = ()
    purpose: Purpose = field(default=Purpose(""), kw_only=True, compare=False)

    @property
    def summary(self) -> str:
        """The result in one line."""
        return self.purpose.command

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self.summary.splitlines()[0]}>"

    def as_table(self) -> pd.DataFrame | None:
        """The rows that a function reads where it is given this result in the place of a table."""
        return None

    def as_model(self) -> Model | None:
        """The model that a function uses where it is given this result in the place of a model file."""
        return None

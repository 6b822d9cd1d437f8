"""What the functions of the package return: one short line to look at, and what other functions take of it."""

import html
from dataclasses import dataclass, field
from typing import ClassVar

import pandas as pd

from expdesign.chain.models.model_file import Model
from expdesign.copying import Copied
from expdesign.io.written import Purpose


@dataclass(frozen=True, repr=False)
class Result(Copied):
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

    def _repr_html_(self) -> str:
        """For notebooks: the summary, one line below the other."""
        lines = "<br>".join(html.escape(line) for line in self.summary.splitlines())
        return f"<div><b>{type(self).__name__}</b><br>{lines}</div>"

    def as_table(self) -> pd.DataFrame | None:
        """The rows that a function reads where it is given this result in the place of a table."""
        return None

    def as_model(self) -> Model | None:
        """The model that a function uses where it is given this result in the place of a model file."""
        return None

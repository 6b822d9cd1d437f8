"""What a result says: made once here, and printed by the terminal, the page, the notebook and the JSON."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from expdesign.report.blocks import Block, DataTable, PageSection, Sentences

REFUTED = (
    "warning: the model is refuted by its own recordings, and its standard deviations do not include what it lacks: "
    "run `expdesign diagnose`, which writes a model with the missing physics"
)
"""What is said of whatever is computed with such a model."""


@dataclass(frozen=True)
class Said:
    """What a result says.

    Attributes:
        summary: the result in one line.
        statements: sentences, one by one; the summary where there is nothing else.
        notes: what is doubtful, or has to be known beside the result: on standard error.
        document: makes the record of the result, which may take a while; empty where a result has none.
        tables: what is said in numbers.
    """

    summary: str
    statements: Sequence[str] | None = None
    notes: Sequence[str] = ()
    document: Callable[[], Mapping[str, Any]] = dict
    tables: Sequence[DataTable] = ()

    @property
    def sentences(self) -> list[str]:
        """The statements, or the summary alone."""
        return self.summary.splitlines() if self.statements is None else list(self.statements)

    @property
    def lines(self) -> list[str]:
        """What the command prints: the tables, and below them the sentences."""
        return [*(line for table in self.tables for line in table.lines), *self.sentences]

    def section(self, title: str, *further: Block, id: str = "result") -> PageSection:
        """The first section of a page: the sentences, and what stands with them."""
        return PageSection(id, title, [Sentences(self.sentences), *further])

"""What a result says: made once here, and printed by the terminal, the page, the notebook and the JSON."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

REFUTED = (
    "warning: the model is refuted by its own recordings, and its standard deviations do not hold what it lacks: "
    "`expdesign diagnose` looks for that, and writes a model with it"
)
"""What is said of whatever is computed with such a model."""


@dataclass(frozen=True)
class Said:
    """What a result says.

    Attributes:
        summary: the result in one line.
        statements: what the command prints, a line each; the summary where there is nothing else.
        notes: what is doubtful, or has to be known beside the result: on standard error.
        document: makes the record of the result, which may take a while; empty where a result has none.
    """

    summary: str
    statements: Sequence[str] | None = None
    notes: Sequence[str] = ()
    document: Callable[[], Mapping[str, Any]] = dict

    @property
    def lines(self) -> list[str]:
        """What the command prints."""
        return self.summary.splitlines() if self.statements is None else list(self.statements)

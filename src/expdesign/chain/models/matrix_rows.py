"""Matrices in a model file: lists of numbers, or where they are large a text of numbers for each row.

A model of free laws has hundreds of weights. YAML takes each of their 400,000 covariances for an entry of its own, and
needs 7 s to read and write them; as texts of rows 0.5 s. Both forms hold the same numbers to the last digit.
"""

from typing import Annotated, Any

from pydantic import BeforeValidator, WithJsonSchema

from expdesign.arrays import FloatArray

_LISTED = 100
"""Rows up to which numbers are entries of their own: half a page of them can still be looked at."""


def _numbers(rows: Any) -> Any:
    if not isinstance(rows, list):
        return rows
    return [[float(number) for number in row.split()] if isinstance(row, str) else row for row in rows]


MatrixRows = Annotated[
    list[list[float]],
    BeforeValidator(_numbers),
    WithJsonSchema({"type": "array", "items": {"type": ["array", "string"], "items": {"type": "number"}}}),
]
"""Rows of a matrix, each a list of numbers or a text of numbers with spaces between."""


def matrix_rows(matrix: FloatArray) -> list[list[float]] | list[str]:
    """A matrix (r, c) as it stands in a model file."""
    rows: list[list[float]] = matrix.tolist()
    return rows if len(rows) <= _LISTED else [" ".join(map(repr, row)) for row in rows]

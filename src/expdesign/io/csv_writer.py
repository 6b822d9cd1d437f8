"""CSV text of a table, reproducible to the byte."""

import csv
import io

import numpy as np
import pandas as pd


def csv_text(frame: pd.DataFrame) -> str:
    """CSV text of a frame: shortest decimal numbers that read back as the same floats, line feeds."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(frame.columns)
    # Column by column: a table of numbers goes to Python's own types at once.
    columns = [[_cell(value) for value in frame.iloc[:, place].tolist()] for place in range(frame.shape[1])]
    writer.writerows(zip(*columns, strict=True))
    return stream.getvalue()


def _cell(value: object) -> str:
    if isinstance(value, bool | np.bool_):
        return "true" if value else "false"
    if isinstance(value, float | np.floating):
        return repr(float(value) + 0.0)
    return str(value)

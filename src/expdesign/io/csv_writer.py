"""CSV text of a table, reproducible to the byte."""

import io

import numpy as np
import pandas as pd


def csv_text(frame: pd.DataFrame) -> str:
    """CSV text of a frame: shortest decimal numbers that read back as the same floats, line feeds."""
    stream = io.StringIO()
    frame.map(_cell).to_csv(stream, index=False, lineterminator="\n")
    return stream.getvalue()


def _cell(value: object) -> str:
    if isinstance(value, bool | np.bool_):
        return "true" if value else "false"
    if isinstance(value, float | np.floating):
        return repr(float(value) + 0.0)
    return str(value)

"""Tables as files: CSV or a workbook, in SI or in units of choice."""

from pathlib import Path

import pandas as pd

from expdesign.api.inputs import PathLike
from expdesign.files.csv_writer import csv_text
from expdesign.files.table_output import write_table
from expdesign.files.tables_in_units import in_units


def save_table(file: PathLike, text: pd.DataFrame, units: str | None = None) -> Path:
    """Write a table and return its path.

    Args:
        file: `.xlsx` for a workbook, anything else for CSV.
        text: with SI columns.
        units: such as `mm,mrad`: the units that columns are written in, by what they measure; SI if left out.

    Raises:
        InputError: a unit is unknown, or the file cannot be written.
    """
    frame = in_units(text, units)
    write_table(Path(file), frame, csv_text(frame))
    return Path(file)

"""Tables as files: CSV or a workbook, in SI or in units of choice."""

from pathlib import Path

import pandas as pd

from expdesign.app.api.inputs import PathLike
from expdesign.io.excel import is_excel_name, workbook
from expdesign.io.output import csv_text, output_file
from expdesign.io.tables_in_units import in_units
from expdesign.io.written import Purpose


def save_table(file: PathLike, text: pd.DataFrame, units: str | None, purpose: Purpose, *, force: bool = False) -> Path:
    """Write a table and return its path.

    Args:
        file: `.xlsx` for a workbook, anything else for CSV.
        text: with SI columns.
        units: such as `mm,mrad`: the units that columns are written in, by what they measure; SI if None.
        purpose: for which it is written.
        force: whether a file that is there for another purpose is replaced.

    Raises:
        InputError: a unit is unknown, or the file cannot be written or must not be replaced.
    """
    frame = in_units(text, units)
    path = Path(file)
    output_file(path, workbook(frame) if is_excel_name(path) else csv_text(frame), purpose, force=force)
    return path

"""A table written in the form that its file's name asks for: CSV, or an Excel workbook (.xlsx)."""

from pathlib import Path

import pandas as pd

from expdesign.files.excel import is_excel_name, workbook
from expdesign.files.output import write_bytes, write_file


def write_table(path: Path, frame: pd.DataFrame, csv: str) -> None:
    """Write a table.

    Args:
        path: `.xlsx` for a workbook, anything else for CSV.
        frame: the cells.
        csv: the same as CSV text.

    Raises:
        InputError: the file cannot be written.
    """
    if is_excel_name(path):
        write_bytes(path, workbook(frame))
    else:
        write_file(path, csv)

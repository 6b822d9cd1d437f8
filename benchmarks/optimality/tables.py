"""Tables of results: Markdown for people, CSV for programs."""

import datetime
import math
import os
from pathlib import Path

import pandas as pd

RESULTS = Path("results/benchmarks")


def write(name: str, title: str, command: str, seed: int, table: pd.DataFrame, notes: list[str]) -> None:
    """Write `results/benchmarks/<name>.md` and `.csv`, and print the former."""
    RESULTS.mkdir(parents=True, exist_ok=True)
    table.to_csv(RESULTS / f"{name}.csv", index=False, lineterminator="\n")
    cells = [[str(column) for column in table.columns], ["---"] * len(table.columns)]
    cells += [[_cell(value) for value in row] for row in table.itertuples(index=False)]
    machine = f"{os.cpu_count()} cores of a shared x86-64 virtual machine, one thread of linear algebra"
    text = "\n".join(
        [
            f"# {title}",
            "",
            f"Command: `{command}`. Date: {datetime.datetime.now(datetime.UTC).date()}. Seed: {seed}. "
            f"Machine: {machine}. All figures of this table come from one run.",
            "",
            *("| " + " | ".join(row) + " |" for row in cells),
            "",
            *(f"- {note}" for note in notes),
            "",
        ]
    )
    (RESULTS / f"{name}.md").write_text(text, encoding="utf-8")
    print(text, flush=True)


def _cell(value: object) -> str:
    if isinstance(value, float):
        return "not reached" if math.isnan(value) else f"{value:.4g}"
    return str(value)

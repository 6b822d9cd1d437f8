"""Make a study: its tables, then figures and page from them, and the record that binds them to the configuration."""

import hashlib
import io
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from expdesign.errors import InputError
from expdesign.io.output import csv_text, json_text, output_file, output_folder, write_file
from expdesign.io.schema import validate
from expdesign.io.written import Purpose, require_free_names
from expdesign.io.yaml_reader import YamlDocument, read_text, read_yaml
from research.studies.drawing import svg_text
from research.studies.page import index_text, page_text
from research.studies.study import Study, StudySection, StudyTable, Tables, known_studies

LARGEST_FIGURE = 100_000
"""Bytes of a figure that is light enough to be kept."""


@dataclass(frozen=True)
class Prepared:
    """A study with its configuration."""

    study: Study
    settings: StudySection
    document: YamlDocument

    def tables(self) -> dict[str, StudyTable]:
        """The computation."""
        return self.study.tables(self.settings, self.document)


def prepare(name: str, folder: Path) -> Prepared:
    """The study `name` with its configuration in `folder`.

    Raises:
        InputError: there is no such study, or its configuration is missing or wrong.
    """
    studies = known_studies()
    if name not in studies:
        raise InputError(f"there is no study `{name}`", remedy=f"Known: {', '.join(studies)}.")
    study = studies[name]
    document = read_yaml(folder / f"{name}.yaml")
    return Prepared(study, validate(study.settings, document), document)


def require_free_study(name: str, configurations: Path, out: Path, *, force: bool = False) -> None:
    """Raise an `InputError` where a file of a study must not be replaced: to be asked before the work."""
    names = ("*.csv", "*.svg", "README.md", "study.json")
    require_free_names(out / name, names, _purpose(name, configurations), force=force)


def _purpose(name: str, configurations: Path) -> Purpose:
    return Purpose(f"study {name}", (str(configurations / f"{name}.yaml"),))


def make(name: str, configurations: Path, out: Path, *, force: bool = False) -> None:
    """Run a study and write its CSV files, figures, page and record into `out`/NAME."""
    prepared = prepare(name, configurations)
    texts = {table: table_text(content) for table, content in prepared.tables().items()}
    files = {f"{table}.csv": text for table, text in texts.items()}
    files |= presentation(prepared, {table: read_frame(text) for table, text in texts.items()})
    record = {"study": name, "configuration_sha256": digest(prepared.document)}
    files["study.json"] = json_text(record | {"tables_sha256": {table: sha256(text) for table, text in texts.items()}})
    with output_folder(out / name, _purpose(name, configurations), force=force) as scratch:
        for file, text in files.items():
            write_file(scratch / file, text)


def write_index(out: Path, *, force: bool = False) -> None:
    """Write the list of all studies, whose tables lie in `out`, into `out`."""
    frames = (read_frame(read_text(path)) for name in known_studies() for path in sorted((out / name).glob("*.csv")))
    found = [score for frame in frames for values in scores(frame).values() for score in values]
    output_file(out / "README.md", index_text(found), Purpose("studies"), force=force)


def scores(frame: pd.DataFrame) -> dict[str, list[float]]:
    """Standard errors between every predicted column and what was sampled, by the name of the latter."""
    columns = [name.removesuffix("_predicted") for name in frame.columns if name.endswith("_predicted")]
    return {name: ((frame[name] - frame[f"{name}_predicted"]) / frame[f"{name}_se"]).to_list() for name in columns}


def presentation(prepared: Prepared, tables: Tables) -> dict[str, str]:
    """Figures and page, by file name, from the tables as they are kept."""
    figures = prepared.study.figures(prepared.settings, tables)
    files = {f"{name}.svg": svg_text(figure) for name, figure in figures.items()}
    for name, text in files.items():
        if len(text.encode()) > LARGEST_FIGURE:
            what = f"the figure has {len(text.encode())} bytes, more than {LARGEST_FIGURE}"
            raise ValueError(f"{prepared.study.name()}, {name}: {what}")
    files["README.md"] = page_text(prepared.study, prepared.settings, prepared.study.page(prepared.settings, tables))
    return files


def table_text(table: StudyTable) -> str:
    """The table as CSV, rounded to its digits."""
    return csv_text(table.frame.map(lambda value: _rounded(value, table.digits)))


def read_frame(text: str) -> pd.DataFrame:
    """A kept table; its numbers are those written, bit for bit."""
    frame = pd.read_csv(io.StringIO(text), dtype=str, keep_default_na=False)
    return frame.apply(_parsed)


def _parsed(cells: "pd.Series[str]") -> "pd.Series[Any]":
    for kind in (int, float):
        try:
            return pd.Series([kind(cell) for cell in cells], index=cells.index)
        except ValueError:
            continue
    return cells


def digest(document: YamlDocument) -> str:
    """SHA-256 of what a configuration says, with every file that it names; comments and layout do not count."""
    return sha256(json.dumps(_resolved(document.content, document.folder), sort_keys=True))


def sha256(text: str) -> str:
    """Hexadecimal digest of a text."""
    return hashlib.sha256(text.encode()).hexdigest()


def _resolved(content: Any, folder: Path) -> Any:
    """The content with named files written out."""
    if isinstance(content, dict):
        return {str(key): _resolved(value, folder) for key, value in content.items()}
    if isinstance(content, list):
        return [_resolved(value, folder) for value in content]
    if isinstance(content, str) and content.endswith((".yaml", ".csv", ".urdf")) and (folder / content).is_file():
        path = folder / content
        if content.endswith(".yaml"):
            return {content: _resolved(read_yaml(path).content, path.parent)}
        return {content: read_text(path)}
    return content


def _rounded(value: Any, digits: int) -> Any:
    return float(f"{value:.{digits - 1}e}") if isinstance(value, float) else value

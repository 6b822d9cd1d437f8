"""What is kept under results/studies still follows from the configurations, for every study that exists.

The computation is repeated with few samples: columns that do not come from samples must be the kept ones, and the
others must agree within their standard errors. Figures and pages are made again from the kept tables.
"""

import json
from functools import cache

import numpy as np
import pandas as pd
import pytest
from matplotlib import __version__ as matplotlib_version

from research.studies.making import Prepared, digest, prepare, presentation, read_frame, scores, sha256, table_text
from research.studies.page import index_text
from research.studies.study import known_studies
from research.studies.tests.kept import CONFIGURATIONS, KEPT, kept, kept_text

FEW = 4000
STUDIES = list(known_studies())


@cache
def prepared(name: str) -> Prepared:
    return prepare(name, CONFIGURATIONS)


@cache
def tables_of(name: str) -> dict[str, pd.DataFrame]:
    return {table: kept(name, table) for table in json.loads(kept_text(name, "study.json"))["tables_sha256"]}


def test_every_configuration_is_of_a_study() -> None:
    assert sorted(path.stem for path in CONFIGURATIONS.glob("*.yaml")) == sorted(STUDIES)
    assert sorted(path.name for path in KEPT.iterdir() if path.is_dir()) == sorted(STUDIES)


def test_the_index_lists_them_all() -> None:
    found = [
        score
        for name in STUDIES
        for frame in tables_of(name).values()
        for each in scores(frame).values()
        for score in each
    ]
    assert (KEPT / "README.md").read_text(encoding="utf-8") == index_text(found), "run `python -m research.studies`"
    # Scores of predictions that hold are standard normal; many share their draws, so that the limits are wide.
    assert 0.8 < np.std(found) < 1.2


@pytest.mark.parametrize("name", STUDIES)
def test_record_binds_tables_to_the_configuration(name: str) -> None:
    record = json.loads(kept_text(name, "study.json"))
    assert record["configuration_sha256"] == digest(prepared(name).document), "make the study again"
    for table, expected in record["tables_sha256"].items():
        assert sha256(kept_text(name, f"{table}.csv")) == expected


@pytest.mark.parametrize("name", STUDIES)
def test_tables_follow_from_the_configuration(name: str) -> None:
    here = prepared(name)
    samples = min(here.settings.samples, FEW)
    quick = Prepared(here.study, here.settings.model_copy(update={"samples": samples, "seed": 77}), here.document)
    tables = quick.tables()
    assert set(tables) == set(tables_of(name))
    for table, content in tables.items():
        compare(f"{name}/{table}.csv", tables_of(name)[table], read_frame(table_text(content)), content.digits)


def compare(where: str, old: pd.DataFrame, new: pd.DataFrame, digits: int) -> None:
    assert list(old.columns) == list(new.columns), where
    assert len(old) == len(new), where
    for column in old.columns:
        if column.endswith("_se"):
            assert (old[column] >= 0.0).all(), f"{where}: {column}"
        elif f"{column}_se" in old.columns:
            error = np.hypot(old[f"{column}_se"], new[f"{column}_se"])
            assert (np.abs(old[column] - new[column]) <= 5.0 * error).all(), f"{where}: {column}"
        elif pd.api.types.is_float_dtype(old[column]):
            # What is zero but for rounding differs between machines by a few units in the last place of the column.
            rounding = max(1e-15, 1e-14 * float(np.abs(old[column]).max()))
            np.testing.assert_allclose(new[column], old[column], rtol=2.0 * 10.0 ** (1 - digits), atol=rounding)
        else:
            assert list(old[column]) == list(new[column]), f"{where}: {column}"


@pytest.mark.parametrize("name", STUDIES)
def test_predictions_are_within_three_standard_errors(name: str) -> None:
    for table, frame in tables_of(name).items():
        for column, found in scores(frame).items():
            assert max(map(abs, found)) <= 3.0, f"{name}/{table}.csv: {column}: {found}"


@pytest.mark.parametrize("name", STUDIES)
def test_figures_and_page_follow_from_the_tables(name: str) -> None:
    files = presentation(prepared(name), tables_of(name))
    assert kept_text(name, "README.md") == files["README.md"]
    for file, text in files.items():
        # Another version of the plotting library draws the same figure with other text.
        if file.endswith(".svg") and f"Matplotlib v{matplotlib_version}" in kept_text(name, file):
            assert kept_text(name, file) == text, file
    kept_files = {path.name for path in (KEPT / name).iterdir()}
    assert kept_files == {*files, "study.json", *(f"{table}.csv" for table in tables_of(name))}

"""Files of earlier versions of each format are read, with the meaning that they had; files of later ones are refused.

The files in `version_1` were written by the program as it stood when effects had no identifiers, their predictions and
criteria too.
"""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

import expdesign as xd
from expdesign.app.templates import kinds
from expdesign.chain.models.model_file import model_text, read_model
from expdesign.errors import InputError
from expdesign.io.kinds import CURRENT_VERSIONS, Kind, readable_versions
from tests.commands.calls import Printed, call, refusal

OLD = Path(__file__).parent / "version_1"
EVALUATED = {"duir": 0.7990483435167716, "feir": 0.16983322480708912, "total": 0.8168975330635244}
"""`evaluate config.yaml plan.csv` as the earlier version gave it."""
FILES: dict[Kind, Path] = {
    "robot": OLD / "robots" / "bipod.yaml",
    "run configuration": OLD / "config.yaml",
    "identified model": OLD / "model-with-an-effect.yaml",
    "sweep": OLD / "sweep.yaml",
}


@pytest.mark.parametrize("name", ["", "-with-an-effect"])
def test_a_model_of_version_1_predicts_as_it_did(name: str) -> None:
    then = pd.read_csv(OLD / f"predicted{name}.csv")
    measured = [column for column in then.columns if column[0] in "ds"]
    points = then.drop(columns=[column for column in measured if column not in ("sequence", "series")])
    now = xd.predict(OLD / f"model{name}.yaml", points).frame
    compared = [column for column in measured if column not in ("sequence", "series")]
    assert len(compared) >= 4
    np.testing.assert_allclose(now[compared], then[compared], rtol=1e-9, atol=1e-18)


def test_a_configuration_of_version_1_is_judged_as_it_was_by_the_estimator_of_then(tmp_path: Path) -> None:
    content = yaml.safe_load((OLD / "config.yaml").read_text(encoding="utf-8"))
    content["robot"] = str((OLD / content["robot"]).resolve())
    content["experiment"]["estimator"] = "weighted"
    (tmp_path / "config.yaml").write_text(yaml.safe_dump(content), encoding="utf-8")
    record = xd.evaluate(tmp_path / "config.yaml", OLD / "plan.csv").record
    assert {name: record[name] for name in EVALUATED} == pytest.approx(EVALUATED, rel=1e-9)


@pytest.mark.parametrize("kind", FILES)
def test_files_of_version_1_are_read(kind: Kind, capsys: Printed) -> None:
    assert call("check", FILES[kind]) == 0


def test_a_model_of_version_1_is_written_in_the_version_of_today(tmp_path: Path) -> None:
    """Written again, the file says which version it has, and names its effects; without the names it is refused."""
    model = read_model(FILES["identified model"])
    (tmp_path / "model.yaml").write_text(model_text(model, tmp_path), encoding="utf-8")
    content = yaml.safe_load((tmp_path / "model.yaml").read_text(encoding="utf-8"))
    assert content["schema_version"] == CURRENT_VERSIONS["identified model"] == 2
    assert [effect["identifier"] for effect in content["effects"]] == ["platform.compliance"]
    again = read_model(tmp_path / "model.yaml")
    np.testing.assert_array_equal(again.values, model.values)
    del content["effects"][0]["identifier"]
    (tmp_path / "model.yaml").write_text(yaml.safe_dump(content), encoding="utf-8")
    with pytest.raises(InputError, match="identifier"):
        read_model(tmp_path / "model.yaml")


@pytest.mark.parametrize("kind", FILES)
@pytest.mark.parametrize("off", ["later", "earlier"])
def test_other_versions_are_refused_with_what_to_do(kind: Kind, off: str, tmp_path: Path, capsys: Printed) -> None:
    """Before anything else: a key that a later version added must not be called unknown."""
    read = readable_versions(kind)
    version = read[-1] + 1 if off == "later" else read[0] - 1
    content = yaml.safe_load(FILES[kind].read_text(encoding="utf-8"))
    content = {"key_of_another_version": 1} | content | {"schema_version": version}
    file = tmp_path / "file.yaml"
    file.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
    said = refusal(capsys, "check", file)
    assert "file.yaml" in said
    assert f"schema version {version} is not known" in said
    assert f"expdesign {xd.__version__} reads version" in said
    if off == "later":
        assert "Install" in said


def test_templates_have_the_version_of_today() -> None:
    files = [file for found in kinds().values() for file in found if file.suffix == ".yaml"]
    for file in files:
        content = yaml.safe_load(file.read_text(encoding="utf-8"))
        kind: Kind = "sweep" if "vary" in content else "run configuration" if "experiment" in content else "robot"
        assert content.get("schema_version", CURRENT_VERSIONS[kind]) == CURRENT_VERSIONS[kind]


def test_the_page_says_what_the_program_does() -> None:
    page = (Path(__file__).parents[2] / "docs" / "versions.md").read_text(encoding="utf-8")
    for kind, current in CURRENT_VERSIONS.items():
        read = ", ".join(map(str, readable_versions(kind)))
        assert f"| {kind} | {current} | {read} |" in page, json.dumps([kind, current, read])

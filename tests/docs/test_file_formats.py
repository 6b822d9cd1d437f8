"""docs/file-formats.md has the tables that its script makes, and every key and column that the program writes."""

import json
import re
from pathlib import Path
from types import ModuleType
from typing import Any, get_args

import pytest

import expdesign as xd
from expdesign.chain.effect import Effect
from expdesign.chain.models import model_file
from expdesign.coordinates import SPATIAL
from expdesign.plugins import implementations
from tests.commands.calls import CONFIG, ROBOT, plan_file, recordings_file
from tests.commands.test_diagnose import ROBOT as BIPOD
from tests.commands.test_diagnose import recordings
from tests.docs.test_tutorial import loaded

PAGE = (Path(__file__).parents[2] / "docs/file-formats.md").read_text(encoding="utf-8")


NAMED = set(re.findall(r"`([\w.]+)`", PAGE))


@pytest.fixture(scope="module")
def script() -> ModuleType:
    return loaded("file_formats")


def section(title: str) -> str:
    """The text below a heading."""
    found = re.search(rf"^## {re.escape(title)}\n(.*?)(?=^## |\Z)", PAGE, flags=re.DOTALL | re.MULTILINE)
    return found[1]


def keys_of(record: dict[str, Any]) -> set[str]:
    return {key for key in record if re.fullmatch(r"\w+", key)}


def test_page_and_schemas_are_what_the_script_makes(script: ModuleType) -> None:
    """Make them again with `python docs/file_formats.py`."""
    stale = [str(path) for path, text in script.files().items() if path.read_text(encoding="utf-8") != text]
    assert stale == []


def test_every_key_of_the_page_has_a_value_and_a_meaning(script: ModuleType) -> None:
    found = [entry for name in (*script.ROBOTS, "configuration", "sweep") for entry in script.entries(name)]
    assert len(found) > 80
    assert not [entry for entry in found if len(entry.meaning) < 4 or entry.value in ("", "anything")]


def test_every_section_of_a_configuration_has_its_table(script: ModuleType) -> None:
    sections = {entry.section for entry in script.entries("configuration")}
    assert sections == {"", *script.SECTIONS}
    assert not [each for each in script.SECTIONS if f"<!-- keys: configuration {each} -->" not in PAGE]


def test_identification_and_evaluation(tmp_path: Path) -> None:
    record = xd.identify(ROBOT, recordings_file(tmp_path)).record
    text = section("identification.json")
    assert not {key for key in record if f"`{key}`" not in text}
    assert not {key for key in record["measurements"][0] if f"`{key}`" not in text}
    evaluation = xd.evaluate(CONFIG, plan_file(tmp_path)).record
    own = {key for key in evaluation if key not in ("duir", "feir", "total")}
    assert not {key for key in own | set(evaluation["targets"][0]) if key not in NAMED and key not in _criteria()}


def _criteria() -> set[str]:
    return {*(f"o{i}" for i in range(1, 6)), "o_tp", "o_mv", "o_mv_max", "duir", "feir", "total"}


def test_diagnosis(tmp_path: Path) -> None:
    diagnosed = xd.diagnose(BIPOD, recordings(tmp_path))
    text = section("diagnosis.json")
    record = json.loads(json.dumps(diagnosed.record))
    for part in (record, record["tests"], record["fit"], record["location"] or {}, *record["effects"]):
        assert not {key for key in keys_of(part) if f"`{key}`" not in text}


def test_model_files() -> None:
    text = section("Model files")
    fields = model_file._ModelSection.model_fields
    (effect,) = get_args(fields["effects"].annotation)
    assert not {key for key in {*fields, *effect.model_fields} if f"`{key}`" not in text}


def test_every_column_of_recordings_and_every_physics() -> None:
    text = section("Recordings")
    for names in (SPATIAL.pose, SPATIAL.wrench[:1], SPATIAL.deflection, SPATIAL.deviation, SPATIAL.gravity):
        assert all(f"`{name}`" in text for name in names)
    kinds = implementations("expdesign.chain.effects", Effect)
    known = {kind.physics for kind in kinds if kind.__module__.count(".") == 4}
    assert not {name for name in known if f"`{name}`" not in section("Identifiers of physics")}


def test_the_page_of_commands_is_what_its_script_makes() -> None:
    """Make it again with `python docs/commands.py`."""
    script = loaded("commands")
    assert script.PAGE.read_text(encoding="utf-8") == script.page()

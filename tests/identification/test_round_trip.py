"""Every effect at every place on every robot that has it: written to a model file and read again it is the same."""

import re
from collections import Counter
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import yaml

from expdesign.chain.chain import Chain
from expdesign.chain.component import Component, Part
from expdesign.chain.effect import Effect
from expdesign.chain.effects.environment.thermal_drift import ArmThermalDrift
from expdesign.chain.effects.joints.geometry import ArmGeometricStiffness
from expdesign.chain.effects.legs.transmission import LegBacklash
from expdesign.chain.effects.links.links import LinkMassError
from expdesign.chain.models.effect_entry import EffectSection, effect_classes, effect_entry, effect_of
from expdesign.chain.models.model_file import Model, model_text, read_model
from expdesign.chain.readings.choice import reading_of
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.row import row_data
from expdesign.errors import InputError
from expdesign.io.yaml_reader import YamlDocument, parse_yaml, read_yaml
from expdesign.mechanics.robots.robot import Robot
from expdesign.mechanics.robots.robot_file import robot_from_document
from expdesign.mechanics.robots.serial import SerialRobot
from tests.chain import bodies
from tests.chain.arm_rows import arm_rows
from tests.chain.places import recordings as legs_recordings
from tests.identification.experiments import read

ROBOTS = Path(__file__).parents[2] / "configs" / "robots"
BODY = "{name: body, kind: body, home: [0.5, -0.2, 0.3]}"
CASES = ("hexapod", "hexapod, positions", "bipod", "arm", "arm, positions", "body", "body, positions")


@cache
def robot_document(name: str) -> YamlDocument:
    files = {"hexapod": "hexapod-h1.yaml", "bipod": "bipod.yaml", "arm": "ur5.yaml"}
    return parse_yaml(BODY, "body.yaml", ROBOTS) if name == "body" else read_yaml(ROBOTS / files[name])


@cache
def case(name: str) -> tuple[Robot, Recordings]:
    """A robot, and rows on which all of its effects show: series, time and temperatures, with positions if asked."""
    kind = name.split(",", maxsplit=1)[0]
    robot = robot_from_document(robot_document(kind))
    if kind == "body":
        points = bodies.recordings(count=18, lifting=True)
    elif isinstance(robot, SerialRobot):
        points = read(arm_rows(robot, series=5, loads=3, sideways=True), robot)
    else:
        points = legs_recordings("H1" if kind == "hexapod" else "bipod-unequal")
    if "positions" in name:
        places = np.random.default_rng(0).uniform(-1.0, 1.0, (len(points), 3))
        marker = np.arange(len(points)) % 2
        points = replace(points, marker=marker, markers=("a", "b"), axes=np.arange(3), deflections=places)
    return robot, points


def model_of(name: str, *effects: Effect) -> Model:
    """A model with effects, their parameters some way from neutral and with all their digits."""
    robot, points = case(name)
    chain = Chain(robot, effects, reading=reading_of(robot, points))
    low, high = chain.bounds()
    generator = np.random.default_rng(7)
    values = np.clip(chain.start() + chain.scales() * generator.uniform(0.1, 0.9, len(chain.parameters)), low, high)
    values[: chain.compliances] = generator.uniform(0.5, 2.0, chain.compliances)
    document = robot_document(name.split(",", maxsplit=1)[0])
    covariance = np.diag(chain.scales() ** 2)
    return Model(chain, values, covariance, document.content, document.folder, "recordings.csv")


def written(model: Model, folder: Path, **changes: object) -> Path:
    """The model's file, in which keys of its effects are changed, or taken out (None)."""
    path = folder / "model.yaml"
    text = model_text(model, folder)
    if changes:
        content = yaml.safe_load(text)
        for entry in content["effects"]:
            entry.update(changes)
        if None in [entry["identifier"] for entry in content["effects"]]:
            content["schema_version"] = 1  # which did without
        content["effects"] = [{key: v for key, v in entry.items() if v is not None} for entry in content["effects"]]
        text = yaml.safe_dump(content, sort_keys=False)
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("name", CASES)
def test_every_effect_at_every_place_predicts_the_same_to_the_last_bit(name: str, tmp_path: Path) -> None:
    """All places of an effect in one model; values keep all their digits, so that each of them counts."""
    robot, points = case(name)
    rows = row_data(points, robot)
    offered = 0
    for cls in effect_classes():
        effects = cls.candidates(robot, points)
        offered += len(effects)
        if effects:
            model = model_of(name, *effects)
            found = read_model(written(model, tmp_path))
            for same, effect in zip(found.chain.effects, effects, strict=True):
                assert (type(same), same.component, same.variant) == (cls, effect.component, effect.variant)
            np.testing.assert_array_equal(found.values, model.values)
            expected = model.chain.predict(rows, model.values)
            np.testing.assert_array_equal(found.chain.predict(rows, found.values), expected, err_msg=cls.identifier)
    assert offered


@pytest.mark.parametrize("name", CASES)
def test_entries_of_earlier_versions_are_read_where_one_effect_fits(name: str) -> None:
    robot, points = case(name)
    for cls in effect_classes():
        for effect in cls.candidates(robot, points):
            entry = effect_entry(effect, effect.neutral().tolist())
            same = effect_of(EffectSection.model_validate({**entry, "identifier": ""}), robot)
            assert (type(same), same.component, same.variant) == (cls, effect.component, effect.variant)


ARM_EFFECTS = [
    ("arm", ArmGeometricStiffness, Component(Part.GEOMETRY), ""),
    ("arm", ArmThermalDrift, Component(Part.LINK, 2), "time"),
    ("arm, positions", LinkMassError, Component(Part.LINK, 3), ""),
]


@pytest.mark.parametrize(("name", "cls", "component", "variant"), ARM_EFFECTS, ids=str)
def test_an_arms_effects_are_not_read_as_those_of_legs(
    name: str, cls: type[Effect], component: Component, variant: str, tmp_path: Path
) -> None:
    """Geometric stiffness, drift of a link and mass of a link share their physics with effects of legs and payloads."""
    robot, points = case(name)
    effect = cls(robot, component, cls.variant_from_text(robot, variant))
    model = model_of(name, effect)
    for identifier in (cls.identifier, None):
        found = read_model(written(model, tmp_path, identifier=identifier))
        assert type(found.chain.effects[0]) is cls
        rows = row_data(points, robot)
        np.testing.assert_array_equal(found.chain.predict(rows, found.values), model.chain.predict(rows, model.values))


def test_every_effect_has_an_identifier_of_its_own() -> None:
    counts = Counter(cls.identifier for cls in effect_classes())
    assert counts
    assert set(counts.values()) == {1}


@pytest.mark.parametrize(
    ("changes", "key", "says", "remedy"),
    [
        ({"identifier": "legs.ghost"}, "identifier", "unknown effect `legs.ghost`", "Known: .*legs.backlash"),
        ({"identifier": "joints.backlash"}, "physics", "is `joint_backlash`, not `leg_backlash`", "again"),
        ({"identifier": None, "physics": "ghost"}, "physics", "unknown physics `ghost`", "Known: .*leg_backlash"),
        ({"component": "leg 9"}, "component", "has no `leg 9`", "leg 1, leg 2"),
        ({"component": "joint 1"}, "component", "has no `joint 1`", "leg 1, leg 2"),
        ({"component": "elbow"}, "component", "has no `elbow`", "leg 1, leg 2"),
        ({"identifier": None, "component": "leg 0"}, "component", "has no `leg 0`", "leg 1, leg 2"),
        ({"variant": "sideways"}, "variant", "has no variant `sideways`", "again"),
        ({"parameters": {"gap": 1e-6}}, "parameters", "does not have these parameters", "again"),
        (
            {"identifier": None, "physics": "joint_compliance", "component": "joint 1"},
            "component",
            "has no `joint 1`",
            "A hexapod does not have it",
        ),
    ],
)
def test_an_effect_that_cannot_be_is_refused_with_file_key_and_remedy(
    changes: dict[str, object], key: str, says: str, remedy: str, tmp_path: Path
) -> None:
    robot, _ = case("hexapod")
    path = written(model_of("hexapod", LegBacklash.from_text(robot, "leg 3", "middle")), tmp_path, **changes)
    with pytest.raises(InputError, match=says) as caught:
        read_model(path)
    assert str(path) in caught.value.where or path.name in caught.value.where
    assert caught.value.where.endswith(f"effects[0].{key}")
    assert re.search(remedy, caught.value.remedy)


def test_an_entry_that_may_be_several_effects_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class Twin(LegBacklash):
        identifier = "legs.twin"

    monkeypatch.setattr("expdesign.chain.models.effect_entry.effect_classes", lambda: [LegBacklash, Twin])
    robot, _ = case("hexapod")
    model = model_of("hexapod", LegBacklash.from_text(robot, "leg 3", "middle"))
    with pytest.raises(InputError, match=r"may be several effects: legs\.backlash, legs\.twin") as caught:
        read_model(written(model, tmp_path, identifier=None))
    assert "identifier" in caught.value.remedy
    assert type(read_model(written(model, tmp_path, identifier="legs.twin")).chain.effects[0]) is Twin

"""Plans for a robot as it was found: physics of a model file in criteria, gradients and Monte-Carlo."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from expdesign.assurance.validation.repeated import repeat
from expdesign.chain.chain import Chain
from expdesign.chain.effect import Effect
from expdesign.chain.models.effect_entry import effect_classes
from expdesign.chain.models.model_file import Model, model_text
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.row import row_data
from expdesign.errors import InputError
from expdesign.io.yaml_reader import YamlDocument, parse_yaml
from expdesign.mechanics.robots.robot_file import robot_from_document
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.plan import Plan
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import problem_from_document
from tests.design.optimality.central_differences import errors_of_gradients
from tests.design.problems import HEXAPOD, changed, designs
from tests.oracle import Array, central_difference

FOLDER = Path(__file__).parents[2] / "configs" / "robots"


def effect_of(physics: str, kind: Any, component: str, variant: str = "") -> Effect:
    """The effect of that physics whose class takes the component on this robot."""
    for cls in effect_classes():
        if cls.physics == physics:
            try:
                return cls.from_text(kind, component, variant)
            except (ValueError, KeyError, IndexError, AssertionError, InputError):
                continue
    raise AssertionError(physics)


def model_of(content: dict[str, Any], effects: dict[tuple[str, str, str], list[float]], factor: float = 1.0) -> Model:
    """A model of a robot with effects and their parameters, and compliances `factor` times the nominal ones."""
    robot = robot_from_document(YamlDocument("robot.yaml", FOLDER, content))
    made = tuple(effect_of(physics, robot, component, variant) for physics, component, variant in effects)
    chain = Chain(robot, made)
    values = np.concatenate([np.full(chain.compliances, factor), *(np.array(part) for part in effects.values())])
    return Model(chain, values, np.diag((1e-3 * chain.scales()) ** 2), content, FOLDER, "recordings.csv")


def written(model: Model) -> dict[str, Any]:
    content: dict[str, Any] = yaml.safe_load(model_text(model, FOLDER))
    return content


def planned(content: dict[str, Any], changes: dict[str, Any]) -> DesignProblem:
    config = changed(HEXAPOD, changes)
    return problem_from_document(parse_yaml(yaml.safe_dump({**config, "robot": content}), "run.yaml", Path()))


BASE = {("base_compliance", "base", "diagonal"): [2e-9, 3e-9, 1e-9, 4e-8, 5e-8, 3e-8]}
PLAY = {("leg_backlash", "leg 2", "middle"): [4e-6]}
GEOMETRIC = {("geometric_stiffness", "geometry", ""): [1.0]}
PLATFORM = {("platform_compliance", "platform", "diagonal"): [1e-9, 1e-9, 2e-9, 4e-8, 4e-8, 4e-8]}


@pytest.mark.parametrize("effects", [BASE, PLAY, GEOMETRIC, PLATFORM, {**BASE, **PLAY}])
def test_deflections_of_a_plan_are_the_predictions_of_the_model(effects: dict[Any, Any]) -> None:
    model = model_of(HEXAPOD["robot"], effects, 1.2)
    here = planned(written(model), {})
    poses, loads = (part[0] for part in here.space.decode(designs(here, 1)))
    robot, count = model.chain.robot, len(poses)
    wrenches = here.loaded.load.wrenches(robot.jacobians(poses).rotation, loads)
    numbers = np.arange(count)
    points = LoadedPoints(
        "plan", numbers, numbers, numbers, None, poses, wrenches, wrenches, loads[:, :4], loads[:, 4:], None, None,
        None,  # type: ignore[arg-type]
    )  # fmt: skip
    expected = model.chain.predict(row_data(points, robot), model.values)
    found = here.loaded.deflections(poses, loads, np.zeros((count, 6)))
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-15)
    assert here.loaded.robot.stiffness == pytest.approx(robot.stiffness / 1.2)


@pytest.mark.parametrize("effects", [BASE, GEOMETRIC, {**BASE, **PLATFORM}])
def test_maps_are_derivatives_of_the_deflection(effects: dict[Any, Any]) -> None:
    content = HEXAPOD["robot"]
    here = planned(written(model_of(content, effects)), {})
    poses, loads = (part[0] for part in here.space.decode(designs(here, 1)))
    measured = here.loaded.measure(poses, loads)
    nothing = np.zeros((len(poses), 6))
    by_load = central_difference(lambda errors: here.loaded.deflections(poses, loads, errors), nothing, 1.0)
    np.testing.assert_allclose(measured.compliance, by_load, rtol=1e-5, atol=1e-15)

    def deflections(factors: Array) -> Array:
        return planned(written(scaled(content, effects, factors)), {}).loaded.deflections(poses, loads, nothing)

    by_compliance = central_difference(deflections, np.ones(6), 1e-4) / here.loaded.robot.compliance
    np.testing.assert_allclose(measured.observation, by_compliance, rtol=1e-5, atol=1e-5)


def scaled(content: dict[str, Any], effects: dict[Any, Any], factors: Array) -> Model:
    model = model_of(content, effects)
    return replace(model, values=np.concatenate([factors, model.values[6:]]))


@pytest.mark.parametrize("effects", [BASE, GEOMETRIC, {**BASE, **PLATFORM}])
def test_gradients_are_exact(effects: dict[Any, Any]) -> None:
    here = planned(written(model_of(HEXAPOD["robot"], effects)), {})
    errors = errors_of_gradients(here, designs(here, 1), ["duir", "feir", "total", "o1"])
    assert max(errors.values()) < 1e-7


def test_a_soft_base_lets_load_errors_through() -> None:
    weighted = {"experiment.estimator": "weighted"}
    bare = planned(HEXAPOD["robot"], weighted)
    soft = planned(written(model_of(HEXAPOD["robot"], BASE)), weighted)
    decisions = designs(bare, 3)
    values = {
        name: [known_criteria()[name].values(p.assess(*p.space.decode(decisions))) for p in (bare, soft)]
        for name in ("duir", "feir")
    }
    # What the base adds to a deflection is known, and the legs are identified as before; an unknown load is not.
    np.testing.assert_allclose(*values["duir"], rtol=1e-9)
    assert (values["feir"][1] > 1.01 * values["feir"][0]).all()


@pytest.mark.parametrize("effects", [BASE, {**BASE, **GEOMETRIC}])
def test_the_prediction_holds_in_repetitions_with_that_physics(effects: dict[Any, Any]) -> None:
    """Monte-Carlo, 20000 repetitions, z within 3.5 of 0 for all of the compared standard deviations."""
    here = planned(written(model_of(HEXAPOD["robot"], effects, 0.8)), {})
    poses, loads = (part[0] for part in here.space.decode(designs(here, 1)))
    result = repeat(here, Plan(poses, loads, np.arange(1, len(poses) + 1)), 20_000, 1)
    assert np.abs(result.scores()).max() < 3.5
    assert result.residual < 1e-12


def test_the_note_names_effects_and_what_starts_from_rest() -> None:
    here = planned(written(model_of(HEXAPOD["robot"], {**BASE, **PLAY})), {})
    assert here.found is not None
    assert "base_compliance" in here.found.note
    assert "linearised at the planned loads" in here.found.note
    assert here.config["robot"]["kind"] == "model"
    again = problem_from_document(parse_yaml(yaml.safe_dump(here.config), "run.json", Path()))
    decisions = designs(here, 1)
    first, second = (known_criteria()["total"].values(p.assess(*p.space.decode(decisions))) for p in (here, again))
    np.testing.assert_array_equal(first, second)


def test_a_model_file_is_found_by_its_path_and_its_errors_are_told(tmp_path: Path) -> None:
    content = written(model_of(HEXAPOD["robot"], BASE))
    path = tmp_path / "model.yaml"
    config = {**HEXAPOD, "robot": "model.yaml"}

    def read() -> DesignProblem:
        path.write_text(yaml.safe_dump(content), "utf-8")
        return problem_from_document(YamlDocument("run.yaml", tmp_path, config))

    assert read().found is not None
    content["effects"][0]["physics"] = "witchcraft"
    with pytest.raises(InputError) as raised:
        read()
    assert "model.yaml" in str(raised.value)
    assert "witchcraft" in str(raised.value)


def test_the_key_for_geometric_stiffness_adds_the_effect_to_a_model_that_lacks_it() -> None:
    key = {"experiment.geometric_stiffness": True}
    here, there = (planned(written(model_of(HEXAPOD["robot"], effects)), key) for effects in (BASE, GEOMETRIC))
    assert here.found is not None
    assert there.found is not None
    assert [name.split(" / ")[0] for name in here.found.effects] == ["base_compliance", "geometric_stiffness"]
    assert there.found.effects == ("geometric_stiffness / geometry",)
    alone = planned(HEXAPOD["robot"], key)
    assert alone.found is not None
    assert "identified" not in alone.found.note.split(";")[0]


def test_linear_physics_is_known_to_be_linear_in_the_load() -> None:
    """Then only extreme loads need be looked at, in seeds and in bounds."""
    for effects, linear in ((BASE, True), ({**BASE, **PLATFORM}, True), (GEOMETRIC, False)):
        assert planned(written(model_of(HEXAPOD["robot"], effects)), {}).loaded.linear_in_load is linear

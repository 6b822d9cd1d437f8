"""Results go into functions as they are, wrong things are answered by the project's own errors, and `dir` is short."""

import copy
import pickle
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

import expdesign as xd
from expdesign.errors import InputError
from expdesign.report.result import Result
from tests.commands.calls import CONFIG, ROBOT, plan_file
from tests.commands.test_diagnose import ROBOT as BIPOD
from tests.commands.test_diagnose import recordings

POSE = ["x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad"]


@pytest.fixture(scope="module")
def simulated(tmp_path_factory: pytest.TempPathFactory) -> xd.SimulationResult:
    return xd.simulate(CONFIG, plan_file(tmp_path_factory.mktemp("plan")), seed=3)


@pytest.fixture(scope="module")
def identified(simulated: xd.SimulationResult) -> xd.IdentificationResult:
    return xd.identify(ROBOT, simulated)


def test_a_result_stands_for_its_model(identified: xd.IdentificationResult, tmp_path: Path) -> None:
    plan = plan_file(tmp_path)
    identified.save(tmp_path / "identified")
    file = tmp_path / "identified" / "model.yaml"
    for one, other in (
        (xd.compensate(identified, plan).frame, xd.compensate(file, plan).frame),
        (xd.predict(identified, plan).frame, xd.predict(file, plan).frame),
        (xd.simulate(CONFIG, plan, model=identified).frame, xd.simulate(CONFIG, plan, model=file).frame),
    ):
        np.testing.assert_allclose(one[POSE].to_numpy(), other[POSE].to_numpy(), rtol=1e-12)


def test_a_robot_stands_for_what_deflects(tmp_path: Path) -> None:
    plan = plan_file(tmp_path)
    here = xd.simulate(CONFIG, plan, model=ROBOT).frame
    loaded = xd.load(ROBOT)
    assert isinstance(loaded, xd.RobotFile)
    pd.testing.assert_frame_equal(xd.simulate(CONFIG, plan, model=loaded).frame, here)
    content = yaml.safe_load(ROBOT.read_text(encoding="utf-8"))
    pd.testing.assert_frame_equal(xd.simulate(CONFIG, plan, model=content).frame, here)
    assert len(xd.predict(loaded, plan).frame) == 4


def test_a_mapping_as_other_readers_of_yaml_give_it() -> None:
    """YAML 1.1 takes `1e7` for a text."""
    content = yaml.safe_load(ROBOT.read_text(encoding="utf-8")) | {"name": "1e7", "actuator_stiffness": ["1e7"] * 6}
    checked = xd.physics(content)
    assert checked.robot == "1e7"
    with pytest.raises(InputError, match="a number is needed"):
        xd.physics(content | {"actuator_stiffness": ["ten"] * 6})


@pytest.mark.parametrize("wrong", [5, None, {"a": 1}, ("a", 1)])
def test_other_things_are_answered(wrong: object, tmp_path: Path, identified: xd.IdentificationResult) -> None:
    plan = plan_file(tmp_path)
    for call in (
        lambda: xd.evaluate(CONFIG, wrong),  # type: ignore[arg-type]
        lambda: xd.compensate(wrong, plan),  # type: ignore[arg-type]
        lambda: xd.compensate(identified, wrong),  # type: ignore[arg-type]
        lambda: xd.identify(ROBOT, wrong),  # type: ignore[arg-type]
        lambda: xd.identify(wrong, plan),  # type: ignore[arg-type]
        lambda: xd.run(wrong),  # type: ignore[arg-type]
    ):
        with pytest.raises(xd.ExpdesignError):
            call()


@pytest.mark.parametrize("targets", [[[0.0, 0.0]], (1, 2), np.zeros((2, 2))])
def test_rows_without_names_are_no_targets(targets: object, identified: xd.IdentificationResult) -> None:
    with pytest.raises(InputError, match=f"the targets cannot be a `{type(targets).__name__}`. Give a path, a frame"):
        xd.compensate(identified, targets)  # type: ignore[arg-type]


def test_options_that_cannot_be(simulated: xd.SimulationResult) -> None:
    with pytest.raises(InputError, match="no physics is called `creap`"):
        xd.diagnose(ROBOT, simulated, without=["creap"])
    with pytest.raises(InputError, match=r"Write \['creep'\]"):
        xd.diagnose(ROBOT, simulated, without="creep")


def test_a_look_at_a_result_is_short(
    simulated: xd.SimulationResult, identified: xd.IdentificationResult, tmp_path: Path
) -> None:
    results: list[Result] = [
        simulated, identified, xd.evaluate(CONFIG, simulated), xd.sheet(CONFIG, simulated), xd.physics(ROBOT),
        xd.predict(identified, simulated), xd.compensate(identified, simulated),
    ]  # fmt: skip
    for result in results:
        text = repr(result)
        assert text.startswith(f"<{type(result).__name__}: ")
        assert len(text) < 250, text
        assert "\n" not in text
    assert "4 rows" in repr(simulated)
    assert re.fullmatch(
        r"DesignProblem\(.*: \d+ measurements, \d+ targets?, objectives duir, feir\)", repr(xd.load(CONFIG))
    )
    assert replace(simulated, text=simulated.text.iloc[:1]).summary == "1 row simulated"


def test_what_was_loaded_can_be_checked() -> None:
    assert xd.check(xd.load_configuration(CONFIG)).summary == xd.check(CONFIG).summary
    assert xd.check(xd.load_robot(ROBOT)).summary == xd.check(ROBOT).summary
    hexapod = xd.Hexapod(**yaml.safe_load(ROBOT.read_text(encoding="utf-8")))
    assert xd.check(hexapod).summary == xd.check(ROBOT).summary
    with pytest.raises(InputError, match="a `int` cannot be checked"):
        xd.check(5)  # type: ignore[arg-type]


def test_a_model_in_memory_can_be_checked(identified: xd.IdentificationResult) -> None:
    assert xd.check(identified).summary == xd.check(identified.model).summary
    assert "identified model with 0 effects" in xd.check(identified).summary


def test_a_diagnosis_is_pickled_and_copied(tmp_path: Path) -> None:
    """Although it was told of the search by a function of the call."""
    found = xd.diagnose(BIPOD, recordings(tmp_path), callback=lambda stage, done, total, note: None)
    for copied in (pickle.loads(pickle.dumps(found)), copy.deepcopy(found)):
        assert copied.record == found.record
        assert copied.lines == found.lines


def test_what_is_loaded_says_itself_in_a_line(
    simulated: xd.SimulationResult, identified: xd.IdentificationResult
) -> None:
    machine = xd.load_robot(ROBOT)
    assert repr(machine) == f"<RobotFile: hexapod {machine.robot.name} ({ROBOT})>"
    assert re.fullmatch(r"<Recordings: 4 rows in 3 series \(.*\)>", repr(xd.read_recordings(simulated, machine)))
    assert re.fullmatch(rf"<Model of {machine.robot.name}: stiffnesses \(.*\)>", repr(identified.model))


def test_what_is_computed_with_a_refuted_model_says_so(identified: xd.IdentificationResult, tmp_path: Path) -> None:
    plan = plan_file(tmp_path)
    refuted = replace(identified.model, fit="refuted")
    for model, said in ((identified.model, False), (refuted, True)):
        for result in (xd.predict(model, plan), xd.compensate(model, plan)):
            assert any("refuted by its own recordings" in note for note in result.notes) == said


def test_recordings_in_space_are_not_those_of_a_robot_in_a_plane(
    simulated: xd.SimulationResult, caplog: pytest.LogCaptureFixture
) -> None:
    xd.read_recordings(simulated, CONFIG.parent / "robots" / "bipod.yaml")
    (warned,) = [record.getMessage() for record in caplog.records if record.levelname == "WARNING"]
    assert "z_m, rx_rad, ry_rad, rz_rad" in warned
    assert "Is the robot file that of the robot that was measured?" in warned
    assert "meant?)" not in caplog.text


def test_a_prediction_says_where_it_extrapolates(identified: xd.IdentificationResult, tmp_path: Path) -> None:
    points = pd.read_csv(plan_file(tmp_path))
    assert xd.predict(identified, points).beyond == 0
    heavy = points.assign(mass_kg=points["mass_kg"].where(points.index > 0, 200.0))
    found = xd.predict(identified, heavy)
    assert found.beyond == 1
    assert "1 of them beyond what was calibrated" in found.summary

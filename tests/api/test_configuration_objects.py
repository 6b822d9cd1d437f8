"""What stands in YAML can be said in Python, with the same figures and refusals; results are copied and opened."""

import copy
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml

import expdesign as xd
from expdesign.app.api.configuration import problem_of
from expdesign.errors import InputError
from expdesign.planning.sampling import starting_designs
from tests.commands.calls import CONFIG, ROBOT, ROOT, plan_file

said: Any = xd
"""The package without the types of its arguments: arrays and texts with units are taken beside what a file holds."""
SHIPPED = ("bipod", "hexapod-h1", "hexapod-120kg", "hexapod-geometric", "rubin-camera", "ur5")


@pytest.mark.parametrize("name", SHIPPED)
def test_objects_have_the_figures_of_their_file(name: str) -> None:
    file = ROOT / "configs" / f"{name}.yaml"
    written, loaded = problem_of(file), problem_of(xd.load_configuration(file))
    designs = starting_designs(written, 4, np.random.default_rng(1))
    for criterion in ("duir", "feir"):
        one, other = (
            problem.criteria[criterion].values(problem.assess(*problem.space.decode(designs)))
            for problem in (written, loaded)
        )
        np.testing.assert_allclose(other, one, rtol=1e-12)


def _hexapod(**changes: Any) -> Any:
    content = yaml.safe_load(ROBOT.read_text(encoding="utf-8"))
    return said.Hexapod(**{**content, "actuator_stiffness": np.full(6, 1.0e7), **changes})


def _configuration(**changes: Any) -> Any:
    experiment = said.Experiment(
        measurements=6,
        poses=said.Poses(bounds={"x_m": ["-20 mm", "20 mm"], "rx_rad": [-0.1, 0.1]}),
        load=said.Payload(mass_kg={"choices": np.array([5.0, 10.0])}),
        deflection_noise=said.DeflectionNoise(std={"dx_m": "0.5 um", "dz_m": 5.0e-7, "dry_rad": np.float64(2e-6)}),
    )
    target = said.Target(pose=np.zeros(6), payload=said.TargetPayload(mass_kg=10.0), tolerance={"dz_m": "1 um"})
    return said.Configuration(**{"robot": _hexapod(), "experiment": experiment, "targets": [target], **changes})


def test_a_configuration_made_of_objects() -> None:
    """Arrays, units and parts are taken; what it says as a mapping is the same."""
    made = _configuration()
    problem = problem_of(made)
    assert problem.noise.deviations_at is not None
    again = problem_of(said.Configuration(**made.as_mapping()))
    assert again.config == problem.config
    assert "'0.5 um'" not in repr(made)
    assert repr(made.experiment.load).startswith("Payload(") or repr(made.experiment.load).startswith("Load(")


def test_an_arm_of_a_urdf() -> None:
    urdf = ROOT / "configs" / "robots" / "ur5.urdf"
    content = yaml.safe_load((ROOT / "configs" / "robots" / "ur5.yaml").read_text(encoding="utf-8"))
    arm = xd.Arm.from_urdf(
        urdf,
        base_link=content["base_link"],
        tip_link=content["tip_link"],
        actuator_stiffness=content["actuator_stiffness"],
    )
    assert arm.name == "ur5"
    assert xd.physics(arm).robot == "ur5"


@pytest.mark.parametrize(
    ("made", "where", "what"),
    [
        (lambda: said.Hexapod(name="mine"), "Hexapod, home", "the key is missing"),
        (lambda: _hexapod(actuator_stiffness=[1.0e7] * 5), "Hexapod, actuator_stiffness", "at least 6 entries"),
        (lambda: _hexapod(limits={"leg_length": [0.3, 0.2]}), "Hexapod, limits.leg_length", "not shorter"),
        (lambda: said.Experiment(measurments=6), "Experiment, measurments", "Did you mean `measurements`"),
        (lambda: said.Payload(mass_kg="10 mm"), "Payload, mass_kg", ""),
        (lambda: said.DeflectionNoise(std={"dx_m": -1.0}), "DeflectionNoise, std.dx_m", "greater than 0"),
        (lambda: said.Target(pose=[0.0] * 6, tolerance={}), "Target, tolerance", "at least one axis"),
        (lambda: problem_of(_configuration(targets=[])), "Configuration, targets", "at least 1"),
        (lambda: problem_of(_configuration(objectives=["diur"])), "objectives", "duir"),
    ],
)
def test_what_a_file_may_not_say_objects_may_not(made: Any, where: str, what: str) -> None:
    with pytest.raises(InputError) as caught:
        made()
    assert where in caught.value.message
    assert what in caught.value.message


@pytest.fixture(scope="module")
def identified(tmp_path_factory: pytest.TempPathFactory) -> xd.IdentificationResult:
    return xd.identify(ROBOT, xd.simulate(CONFIG, plan_file(tmp_path_factory.mktemp("plan")), seed=3))


@pytest.mark.parametrize("copied", [lambda x: pickle.loads(pickle.dumps(x)), copy.deepcopy, copy.copy])
def test_results_are_pickled_and_copied(copied: Any, identified: xd.IdentificationResult, tmp_path: Path) -> None:
    """Symbols of expressions stay the same ones, so that a copy predicts what the original does."""
    plan = plan_file(tmp_path)
    again = copied(identified)
    pd.testing.assert_frame_equal(again.stiffness, identified.stiffness)
    assert again.record == identified.record
    pd.testing.assert_frame_equal(xd.predict(again, plan).frame, xd.predict(identified, plan).frame)
    checked = xd.check(CONFIG)
    problem = copied(checked)
    assert problem.feasibility == checked.feasibility


def test_what_was_saved_is_opened(identified: xd.IdentificationResult, tmp_path: Path) -> None:
    plan = plan_file(tmp_path)
    identified.save(tmp_path / "identified")
    saved = xd.open_result(tmp_path / "identified")
    assert saved.purpose.command == "identify"
    assert saved.record["stiffness"] == identified.record["stiffness"]
    np.testing.assert_allclose(
        xd.predict(saved, plan).frame.select_dtypes("number"),
        xd.predict(identified, plan).frame.select_dtypes("number"),
        rtol=1e-9,
    )
    with pytest.raises(InputError, match="no result is in this folder"):
        xd.open_result(tmp_path)


def test_notebooks_show_a_result(identified: xd.IdentificationResult) -> None:
    assert identified.summary.splitlines()[0] in identified._repr_html_()

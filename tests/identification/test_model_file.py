"""A model file gives back the chain, its values and its covariance; what it cannot be is said."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from expdesign.chain.chain import Chain
from expdesign.chain.effect import Effect
from expdesign.chain.models.model_file import Model, model_text, read_model
from expdesign.estimation.identify import identify
from expdesign.io.yaml_reader import YamlDocument, read_yaml
from tests.cases import robot
from tests.identification.experiments import experiment

ROBOT_FILE = Path(__file__).parents[2] / "configs" / "robots" / "hexapod-h1.yaml"


def document() -> YamlDocument:
    return read_yaml(ROBOT_FILE)


def saved(model: Model, folder: Path) -> Path:
    path = folder / "model.yaml"
    path.write_text(model_text(model, folder), encoding="utf-8")
    return path


def model_with(effects: tuple[Effect, ...]) -> Model:
    generator = np.random.default_rng(3)
    chain = Chain(robot("H1"), effects)
    values = chain.start() + 0.01 * chain.scales() * generator.uniform(0.1, 1.0, len(chain.parameters))
    root = generator.standard_normal((len(values), len(values))) * chain.scales()[:, None]
    content = document()
    return Model(chain, values, root @ root.T, content.content, content.folder, "recordings.csv")


@pytest.mark.parametrize("listed", [100, 0])
def test_parameters_that_were_not_determined_stay_so(
    listed: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Rows are lists, or texts of numbers where there are more than so many of them."""
    monkeypatch.setattr("expdesign.chain.models.matrix_rows._LISTED", listed)
    model = model_with(())
    model.covariance[2, :] = model.covariance[:, 2] = np.inf
    found = read_model(saved(model, tmp_path))
    np.testing.assert_allclose(found.covariance, model.covariance, rtol=1e-12)
    written = yaml.safe_load((tmp_path / "model.yaml").read_text(encoding="utf-8"))["covariance"]
    assert {type(row) for row in written} == {list if listed else str}


def test_the_file_of_an_identification_says_what_was_identified(tmp_path: Path) -> None:
    made = experiment("H1", 6)
    result = identify(made.robot, made.recordings(made.noisy(np.random.default_rng(0))))
    found = read_model(saved(Model.from_fit(result.fit, document(), "recordings.csv"), tmp_path))
    np.testing.assert_allclose(found.compliance, result.compliance.estimate, rtol=1e-14)
    assert found.chain.robot.name == "hexapod-h1"

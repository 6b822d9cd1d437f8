"""Standard deviations of predictions: finite where rows determine the combination, wider where the model is refuted."""

from pathlib import Path

import numpy as np
import pytest

from expdesign.app.api.identify import identify as identify_file
from expdesign.app.api.predict import predict as predict_file
from expdesign.chain.chain import Chain
from expdesign.chain.effects.structure.compliance import BaseCompliance
from expdesign.chain.models.estimable import Estimable
from expdesign.chain.models.model_file import Model, model_text, read_model
from expdesign.chain.readings.choice import reading_of
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.row import row_data
from expdesign.estimation.compensation.prediction import predict
from expdesign.estimation.fit import Fit, fit
from expdesign.estimation.identify import identify
from expdesign.io.yaml_reader import read_yaml
from expdesign.mechanics.robots.serial import SerialRobot
from tests.chain import bodies
from tests.chain.arms import DEVIATION, READING, configurations, read_arm, recordings_of
from tests.fitting import data_of
from tests.identification.experiments import experiment, table_of

BODY_FILE = "name: machine\nkind: body\nhome: [0.5, -0.2, 0.3]\n"


def arm_fit(folder: Path) -> tuple[SerialRobot, Recordings, Fit]:
    """Positions of an arm whose base yields, fitted with the full compliance of its base."""
    arm = read_arm(folder)
    q = configurations(80, 1)
    effect = BaseCompliance.from_text(arm, "base", "full")
    truth = Chain(arm, (effect,), reading=READING)
    values = truth.start()
    values[truth.base : truth.base + 6] = 1e-6
    empty = recordings_of(arm, q, np.zeros((len(q), 3)))
    noise = DEVIATION * np.random.default_rng(3).standard_normal((len(q), 3))
    data = recordings_of(arm, q, truth.predict(row_data(empty, arm), values) + noise)
    chain = Chain(arm, (effect,), reading=reading_of(arm, data))
    return arm, data, fit(chain, data_of(data, arm))


def test_what_rows_determine_together_has_a_finite_deviation(tmp_path: Path) -> None:
    """A base that shifts under a constant weight is an instrument that stands elsewhere: the sum is determined."""
    arm, data, found = arm_fit(tmp_path)
    assert not found.determined.all()
    model = Model.from_fit(found, read_yaml(tmp_path / "arm.yaml"), "recordings.csv")
    new = recordings_of(arm, configurations(20, 9), np.zeros((20, 3)))
    deviations = predict(model, new).deviations
    assert np.isfinite(deviations).all()
    assert deviations.max() < 20.0 * DEVIATION
    # The hat matrix of the fitted rows, by an independent route: its trace is the rank.
    fitted = predict(model, data).deviations / DEVIATION
    knowledge = found.rank - np.isfinite(found.chain.knowledge()[1]).sum()  # type: ignore[index]
    assert knowledge - 1.0 < (fitted**2).sum() < found.rank + 1e-6
    path = tmp_path / "model.yaml"
    path.write_text(model_text(model, tmp_path), encoding="utf-8")
    np.testing.assert_allclose(predict(read_model(path), new).deviations, deviations, rtol=1e-6)


def test_a_load_of_another_kind_is_not_determined(tmp_path: Path) -> None:
    """Sideways forces act through compliances of the base that weights never loaded."""
    arm, _, found = arm_fit(tmp_path)
    model = Model.from_fit(found, read_yaml(tmp_path / "arm.yaml"), "recordings.csv")
    new = recordings_of(arm, configurations(3, 9), np.zeros((3, 3)))
    sideways = type(new)(**(vars(new) | {"wrenches": np.tile([50.0, 0, 0, 0, 0, 0], (3, 1))}))
    assert np.isinf(predict(model, sideways).deviations).any()


def test_estimable_combinations_against_the_pseudoinverse() -> None:
    """Two parameters that act alike: their sum is known as a single reading's mean, their difference is not."""
    subspace = Estimable(np.full((2, 2), 0.25) * 0.04, np.array([[1.0], [-1.0]]) / np.sqrt(2.0), np.ones(2))
    found = subspace.deviations(np.array([[1.0, 1.0], [1.0, -1.0], [1.0, 0.0], [0.0, 0.0]]))
    np.testing.assert_allclose(found, [0.2, np.inf, np.inf, 0.0])
    assert np.isinf(subspace.covariance).all()
    assert not subspace.determined.any()
    apart = Estimable.from_covariance(np.array([[4.0, np.inf], [np.inf, np.inf]]))
    np.testing.assert_array_equal(apart.deviations(np.array([[3.0, 0.0], [0.0, 1.0], [0.0, 0.0]])), [6.0, np.inf, 0.0])


@pytest.mark.parametrize("factor", [1.0, 500.0])
def test_errors_far_beyond_the_stated_ones_widen_intervals_and_predictions(factor: float) -> None:
    made = experiment("H1", 24, seed=2)
    generator = np.random.default_rng(1)
    noise = factor * made.deviation * generator.standard_normal(made.exact.shape)
    result = identify(made.robot, made.recordings(made.exact + noise))
    deviation = np.sqrt(np.diag(result.covariance))
    weighted = (made.observation / made.deviation[:, None]).reshape(-1, 6)
    expected = factor * np.sqrt(np.diag(np.linalg.inv(weighted.T @ weighted)))
    np.testing.assert_allclose(deviation, expected, rtol=0.2 if factor > 1.0 else 1e-9)
    assert result.goodness.birge_ratio == pytest.approx(factor, rel=0.2)
    error = np.abs(result.compliance.estimate - made.compliance)
    assert (error < 4.5 * deviation).all()
    points = experiment("H1", 4, seed=3)
    model = Model(result.fit.chain, result.fit.values, result.fit.covariance, {}, Path(), "", result.fit.estimable)
    found = predict(model, points.recordings(points.exact))
    exact = points.observation @ made.compliance
    assert (np.abs(found.deflections - exact) < 4.5 * found.deviations + 1e-15).all()


def test_intervals_of_a_refuted_model_cover(tmp_path: Path) -> None:
    """300 experiments with 20 times the stated noise: 95 % intervals cover in 95 %, to 4 standard errors."""
    made = experiment("H1", 8, seed=2)
    generator, inside = np.random.default_rng(5), 0
    for _ in range(300):
        noise = 20.0 * made.deviation * generator.standard_normal(made.exact.shape)
        interval = identify(made.robot, made.recordings(made.exact + noise)).compliance
        inside += int(((interval.low < made.compliance) & (made.compliance < interval.high)).sum())
    assert inside / 1800 == pytest.approx(0.95, abs=4.0 * np.sqrt(0.95 * 0.05 / 300))


def test_the_model_of_a_body_predicts(tmp_path: Path) -> None:
    """Its base model has no parameters at all."""
    (tmp_path / "body.yaml").write_text(BODY_FILE, encoding="utf-8")
    rows = bodies.rows(12)
    identified = identify_file(tmp_path / "body.yaml", rows)
    identified.save(tmp_path / "out")
    predicted = predict_file(tmp_path / "out" / "model.yaml", table_of(rows).frame)
    np.testing.assert_array_equal(predicted.prediction.deflections, np.zeros((12, 6)))
    np.testing.assert_array_equal(predicted.prediction.deviations, np.zeros((12, 6)))
    # Residuals that are exactly zero say nothing of the noise: it stays as stated.
    assert identified.result.goodness.reading_ratio == 1.0

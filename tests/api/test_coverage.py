"""Predicted standard deviations say what they contain, and the one coverage that is reported is of just those."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import expdesign as xd
from expdesign.app.api.inputs import document_of
from expdesign.chain.models.model_file import model_of_robot, model_text, read_model
from expdesign.errors import InputError
from expdesign.report.identification_report import IdentificationResult
from tests.design.problems import BIPOD, HEXAPOD, problem
from tests.identification.experiments import experiment

AXES = ("x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad")
ROBOT = HEXAPOD["robot"]


def recorded(seed: int, noise: float = 1.0, *, stated: bool = True) -> pd.DataFrame:
    """Thirty rows with `noise` times what is stated, a third of them held out."""
    made = experiment("H1", 60, seed)
    generator = np.random.default_rng(seed)
    deflections = made.exact + noise * made.deviation * generator.standard_normal(made.exact.shape)
    frame = made.frame(deflections, stated=stated)
    return frame.assign(split=np.where(np.arange(60) % 3 == 0, "test", "train"))


def share_within(frame: pd.DataFrame, predicted: pd.DataFrame) -> float:
    """Of the held-out readings, within 1.96 standard deviations of what was predicted."""
    test = (frame["split"] == "test").to_numpy()
    inside = [
        np.abs(frame[f"d{axis}"] - predicted[f"d{axis}"])[test] <= 1.959964 * predicted[f"s{axis}"][test]
        for axis in AXES
    ]
    return float(np.mean(inside))


@pytest.mark.parametrize(
    ("noise", "stated", "force_error"), [(1.0, True, 0.0), (3.0, True, 0.0), (1.0, False, 0.0), (1.0, True, 0.2)]
)
def test_what_is_reported_is_what_predict_writes(
    noise: float, stated: bool, force_error: float, tmp_path: Path
) -> None:
    """Through the files, with noise as stated, three times it, and not stated; where weights have errors as well."""
    frame = recorded(1, noise, stated=stated)
    if force_error:
        frame = frame.assign(error_fz_N=10.0 * force_error)
    points = frame.drop(columns=[f"d{axis}" for axis in AXES])
    identified = xd.identify(ROBOT, frame)
    diagnosed = xd.diagnose(ROBOT, frame)
    for found, reported in (
        (identified, identified.record["fit"]["coverage_95"]),
        (diagnosed, diagnosed.record["fit"]["coverage_95"]),
    ):
        folder = tmp_path / type(found).__name__
        found.save(folder)
        model = folder / "model.yaml"
        alone = xd.predict(model, points)
        readings = xd.predict(model, points, readings=True)
        assert reported == pytest.approx(share_within(frame, readings.frame), abs=1e-9)
        assert 0.88 < reported <= 1.0
        assert share_within(frame, alone.frame) < reported - 0.05
        assert "of the model" in alone.notes[0]
        assert "noise of a reading" in readings.notes[0]


def test_readings_are_held_as_often_as_the_intervals_say() -> None:
    """Of 20 experiments with three times the stated noise: 95 % of 2,400 readings to three standard errors."""
    shares = [xd.identify(ROBOT, recorded(seed, 3.0)).record["fit"]["coverage_95"] for seed in range(20)]
    assert np.mean(shares) == pytest.approx(0.95, abs=3.0 * np.sqrt(0.95 * 0.05 / 2400))


def test_the_model_file_carries_what_is_needed(tmp_path: Path) -> None:
    identified: IdentificationResult = xd.identify(ROBOT, recorded(1, 3.0))
    (tmp_path / "model.yaml").write_text(model_text(identified.model, tmp_path), encoding="utf-8")
    again = read_model(tmp_path / "model.yaml")
    assert again.birge_ratio == identified.model.birge_ratio == pytest.approx(3.0, rel=0.1)
    assert again.reading_std == identified.model.reading_std
    assert set(again.reading_std) == {f"s{axis}" for axis in AXES}
    assert again.fit == "refuted"


def test_without_a_noise_level_readings_cannot_be_held() -> None:
    case = problem(BIPOD)
    points = pd.DataFrame({"x_m": [0.1], "y_m": [0.6], "fx_N": [0.0], "fy_N": [-500.0]})
    document = document_of(BIPOD["robot"], "robot")
    model = model_of_robot(case.loaded.robot, document)
    with pytest.raises(InputError, match="neither the points nor the model say"):
        xd.predict(model, points, readings=True)
    stated = xd.predict(model, points.assign(sx_m=2e-6, sy_m=3e-6), readings=True).frame
    np.testing.assert_allclose(stated[["sx_m", "sy_m"]], [[2e-6, 3e-6]])

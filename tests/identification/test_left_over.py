"""What speaks against a model whatever the noise of the instrument is, and what is said where nothing can be tested."""

import logging

import numpy as np
import pandas as pd
import pytest

import expdesign as xd
from expdesign.estimation.left_over import ALIKE, neighbours_of
from tests.plant import PLAIN, READ, ROBOT, STATED, recordings


@pytest.fixture(scope="module")
def measured() -> pd.DataFrame:
    """Sixty poses at two markers, with stated noise of 30 µm; the model of `identify` is right."""
    return recordings(PLAIN, 120, 7, markers=2, loads=False)


def said(found: xd.IdentificationResult) -> str:
    return " ".join(found.lines)


def test_without_stated_noise_the_model_cannot_be_tested_and_what_is_left_is_said(measured: pd.DataFrame) -> None:
    found = xd.identify(ROBOT, measured.drop(columns=STATED))
    assert found.result.goodness.verdict == "noise estimated"
    assert "so that the model with its geometry cannot be tested; 0.0" in said(found)
    assert "mm are left" in said(found)
    assert not found.refused
    left = found.record["statement"]["left_over"]["parts"]["positions"]
    errors = found.result.arm.accuracy["fitted", "position"]
    assert left == {"before": pytest.approx(errors.before.rms), "after": pytest.approx(errors.after.rms)}


def test_residuals_of_neighbours_that_are_alike_refute_a_model(measured: pd.DataFrame) -> None:
    """The instrument wanders by 20 µm from row to row, and no noise is stated."""
    walk = np.cumsum(2e-5 * np.random.default_rng(3).standard_normal((len(measured), 3)), axis=0)
    found = xd.identify(ROBOT, measured.assign(**{n: measured[n] + walk[:, i] for i, n in enumerate(READ)}).drop(
        columns=STATED
    ))  # fmt: skip
    assert found.result.goodness.refuted
    assert "what is left of neighbouring rows is alike (correlation 0." in said(found)
    assert found.record["statement"]["verdict"] == "refuted"
    assert found.result.goodness.birge_ratio == 1.0  # the noise has been estimated with it


def test_stated_noise_that_is_exceeded_refutes_a_model(measured: pd.DataFrame) -> None:
    right = xd.identify(ROBOT, measured).result.goodness
    assert right.verdict == "not refuted"
    found = xd.identify(ROBOT, measured.assign(**dict.fromkeys(STATED, 1e-6)))
    assert found.result.goodness.refuted
    assert "at the stated noise, p below 1e-6: the model with its geometry does not explain" in said(found)
    assert "or the noise is larger than stated" in said(found)


def test_readings_that_fit_under_no_interpretation_are_refused(
    measured: pd.DataFrame, caplog: pytest.LogCaptureFixture
) -> None:
    """Rows in another order than their commands: half a metre is left after the fit."""
    few = measured[:60]
    order = np.random.default_rng(1).permutation(len(few))
    mixed = few.assign(**{name: few[name].to_numpy()[order] for name in READ})
    with caplog.at_level(logging.WARNING):
        found = xd.identify(ROBOT, mixed.drop(columns=STATED))
    assert found.refused
    assert "no model of the right machine leaves as much: the model with its geometry is refuted" in said(found)
    assert "Tried without success: joints in other units" in caplog.text
    assert "inverse poses; coupled joints" in caplog.text


def test_neighbours_are_alike_by_chance_as_often_as_said() -> None:
    """White rows of unequal variances, correlated within: the level holds to within the error of 4,000 draws."""
    generator = np.random.default_rng(2)
    mixing = np.array([[1.0, 0.8, 0.0], [0.0, 1.0, 0.5], [0.0, 0.0, 0.4]])
    sizes = generator.choice([0.5, 1.0, 3.0], (60, 1))
    p = []
    for _ in range(4000):
        found = neighbours_of(sizes * (generator.standard_normal((60, 3)) @ mixing))
        assert found is not None
        p.append(found.p_value)
    assert np.mean(np.array(p) < ALIKE) < 0.003
    assert np.mean(np.array(p) < 0.05) == pytest.approx(0.05, abs=0.012)

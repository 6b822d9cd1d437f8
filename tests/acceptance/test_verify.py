"""Check measurements: tests hold their levels, a wrong robot fails at the stated risk, and bad files are refused."""

import hashlib
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml
from scipy.stats import norm

import expdesign as xd
from expdesign.app.api.inputs import table_of
from expdesign.assurance.acceptance.attained import Comparison, noise_covariance
from expdesign.assurance.acceptance.certificate import certificate_number
from expdesign.assurance.acceptance.check_measurement import read_check_measurement
from expdesign.assurance.acceptance.conformity import TargetResult
from expdesign.chain.models.model_file import model_text
from expdesign.errors import InputError
from expdesign.io.output import csv_text
from expdesign.report import words
from expdesign.report.blocks import KeyFigures
from expdesign.report.verification_report import statement
from tests.acceptance.verified import CONFIG, STD, case, commands, measured, model
from tests.commands.calls import Printed, call, refusal
from tests.design.problems import changed, problem


def test_what_is_attained_is_what_is_predicted() -> None:
    found = xd.verify(model(), measured(commands(3), np.random.default_rng(1)), config=case())
    assert found.result.consistent
    assert found.result.verdict == "pass"
    assert len(found.result.targets) == 2
    assert all(len(target.rows) == 3 for target in found.result.targets)
    assert found.result.targets[0].uncertainty[0] == pytest.approx(5e-7 / np.sqrt(3))
    # The commands were found with this model, so that it predicts no error at all.
    np.testing.assert_allclose(found.result.comparison.predicted, 0.0, atol=1e-12)


def test_the_measured_error_is_that_of_the_robot() -> None:
    """Without noise: attained minus wanted is (A at the command)·(true − identified compliance)."""
    frame = measured(commands(), np.random.default_rng(0), noise=False)
    found = xd.verify(model(), frame, config=case())
    here = case().targets
    wrong = case().loaded.robot.compliance - model().compliance
    expected = here.observation @ wrong
    np.testing.assert_allclose(found.result.comparison.attained, expected, atol=2e-3 * np.abs(expected).max())


def test_measured_poses_say_the_same_as_deflections() -> None:
    frame = measured(commands(2), np.random.default_rng(3))
    poses = frame.drop(columns=list(STD))
    for pose, name in zip(("x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad"), STD, strict=True):
        poses[f"measured_{pose}"] = frame[pose] + frame[name]
    one, other = xd.verify(model(), frame, config=case()), xd.verify(model(), poses, config=case())
    np.testing.assert_allclose(one.result.comparison.attained, other.result.comparison.attained, atol=1e-15)
    assert one.result.comparison.chi2 == pytest.approx(other.result.comparison.chi2, rel=1e-6)


def test_chi_squared_is_that_of_the_dense_covariance() -> None:
    found = xd.verify(model(), measured(commands(2), np.random.default_rng(4)), config=case()).result.comparison
    flat = found.residuals.ravel()
    assert found.chi2 == pytest.approx(flat @ np.linalg.inv(found.noise + found.model) @ flat, rel=1e-6)
    assert np.linalg.matrix_rank(found.model, tol=1e-9 * found.model.max()) <= 6


def test_shared_references_correlate_rows_of_a_series() -> None:
    deviations = np.array([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]])
    covariance = noise_covariance(deviations, np.array(["a", "a", "b"])).reshape(3, 2, 3, 2)
    np.testing.assert_allclose(np.einsum("iaia->ia", covariance), deviations**2)
    assert covariance[0, 0, 1, 0] == pytest.approx(1.5)
    assert covariance[0, 0, 1, 1] == 0.0
    assert covariance[0, 0, 2, 0] == 0.0


def test_the_adjusted_probabilities_are_those_of_holm() -> None:
    z = norm.isf(np.array([[0.01, 0.04], [0.03, 0.005]]) / 2.0)
    comparison = Comparison(z, np.zeros((2, 2)), np.eye(4), np.zeros((4, 4)))
    np.testing.assert_allclose(comparison.adjusted, [[0.03, 0.06], [0.06, 0.02]], rtol=1e-9)


@pytest.mark.parametrize(
    ("error", "uncertainty", "tolerance", "expected"),
    [
        (0.5, 0.2, 1.0, "conforms"),
        (-0.5, 0.2, 1.0, "conforms"),
        (0.7, 0.2, 1.0, "not proven"),
        (1.3, 0.2, 1.0, "not proven"),
        (-1.5, 0.2, 1.0, "does not conform"),
        (np.nan, np.nan, 1.0, "not proven"),
        (0.5, 0.2, np.nan, "no tolerance"),
    ],
)
def test_conformity(error: float, uncertainty: float, tolerance: float, expected: str) -> None:
    assert one_axis(1, error, uncertainty, tolerance).conformity.tolist() == [expected]


def one_axis(rows: int, *of_axis: float) -> TargetResult:
    """A target along one axis, from its error, standard uncertainty and tolerance, with k = 2."""
    error, uncertainty, tolerance = (np.array([each]) for each in of_axis)
    return TargetResult(np.zeros(6), np.arange(rows), error, uncertainty, tolerance, 2.0, np.full(1, np.nan))


def rates(count: int, error: dict[str, float], seed: int) -> tuple[float, float, float]:
    """How often a check measurement passes, how often the model test rejects, how often e ± U holds the truth."""
    generator = np.random.default_rng(seed)
    frame = commands(2)
    exact = xd.verify(model(), measured(frame, generator, error=error, noise=False), config=case())
    truth = exact.result.comparison.attained
    passes = rejects = covered = 0.0
    for _ in range(count):
        found = xd.verify(model(), measured_again(frame, exact, generator), config=case())
        passes += found.result.verdict == "pass"
        p_value = found.result.statement.p_value
        rejects += p_value is not None and p_value < 0.05
        for target in found.result.targets:
            covered += (np.abs(target.error - truth[target.rows[0]]) <= target.expanded).sum()
    return passes / count, rejects / count, covered / (count * 12)


def measured_again(frame: pd.DataFrame, exact: Any, generator: np.random.Generator) -> pd.DataFrame:
    result = frame.copy()
    for column, (name, sigma) in enumerate(STD.items()):
        result[name] = exact.check.readings[:, column] + sigma * generator.standard_normal(len(frame))
        result["s" + name[1:]] = sigma
    return result


@pytest.mark.parametrize(("count", "seed"), [(200, 5), pytest.param(2000, 6, marks=pytest.mark.slow)])
def test_a_robot_whose_truth_fails_passes_at_most_at_the_stated_risk(count: int, seed: int) -> None:
    """Its true error of dz at target 1 is just at the tolerance: it passes with Φ(−2) = 2.3 % at most."""
    frame = measured(commands(2), np.random.default_rng(0), noise=False)
    truth = xd.verify(model(), frame, config=case()).result.comparison.attained[0, 2]
    passes, _, covered = rates(count, {"dz_m": 3e-6 - truth}, seed)
    assert passes <= 0.0228 + 3.0 * np.sqrt(0.0228 * 0.9772 / count)
    assert covered == pytest.approx(0.9545, abs=0.015)


def test_a_robot_that_is_far_off_does_not_conform() -> None:
    frame = measured(commands(2), np.random.default_rng(2), error={"dz_m": 2e-5})
    verified = xd.verify(model(), frame, config=case())
    found = verified.result
    assert found.verdict == "fail"
    assert verified.refused  # the command exits with status 3
    assert not found.consistent
    assert found.targets[0].conformity[2] == "does not conform"


def test_targets_that_were_not_measured_are_not_proven() -> None:
    frame = measured(commands(1), np.random.default_rng(2)).iloc[:1]
    found = xd.verify(model(), frame, config=case()).result
    assert found.verdict == "not proven"
    assert found.targets[1].conformity[found.targets[1].matters].tolist() == ["not proven"]


def test_tolerances_may_stand_in_columns_or_be_missing() -> None:
    frame = measured(commands(2), np.random.default_rng(1))
    assert xd.verify(model(), frame).result.verdict == "no tolerance"
    assert xd.verify(model(), frame.assign(tolerance_dz_m=5e-6)).result.verdict == "pass"
    assert xd.verify(model(), frame.assign(tolerance_dz_m=1e-8)).result.verdict == "not proven"
    assert xd.verify(model(), frame.assign(tolerance_dz_m=1e-8, dz_m=1e-3)).result.verdict == "fail"


def weightless(frame: pd.DataFrame) -> pd.DataFrame:
    """With wrenches of 0 in place of the payloads."""
    bare = frame.drop(columns=[name for name in map(str, frame) if name.startswith(("mass_", "com_"))])
    return bare.assign(**dict.fromkeys(("fx_N", "fy_N", "fz_N", "mx_Nm", "my_Nm", "mz_Nm"), 0.0))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda f: f.drop(columns=[n for n in f if n.startswith("target_")]), "no targets"),
        (lambda f: f.drop(columns=list(STD)), "no measured column"),
        (lambda f: f.assign(measured_x_m=0.0), "together with"),
        (lambda f: f.assign(tolerance_dz_m=-1.0), "row 2, column tolerance_dz_m"),
        (lambda f: f.drop(columns=list(STD)).assign(measured_x_m=20.0), "from its target"),
        (lambda f: f.assign(dx_m=12.0), "cannot be a deflection"),
        (
            lambda f: f.assign(mass_kg=[26.5, 13.0]),
            r"row 3, column mass_kg: mass_kg is 13 in the row and 20 at target 2",
        ),
        (lambda f: f.assign(com_x_m=0.0), r"row 2, column com_x_m"),
        (lambda f: f.assign(same_as=["", "experiment"]), "row 3, column same_as: .* `experiment` in the row and empty"),
        (lambda f: weightless(f).assign(fz_N=-100.0), "row 2, column fz_N: fz_N is -100"),
    ],
)
def test_bad_check_measurements(change: Any, words: str) -> None:
    frame = change(measured(commands(1), np.random.default_rng(1)))
    with pytest.raises(InputError, match=words):
        xd.verify(model(), frame, config=case())


def test_a_tolerance_belongs_to_the_load_of_its_target() -> None:
    frame = measured(commands(1), np.random.default_rng(1)).assign(mass_kg=13.0)
    stated = frame.assign(tolerance_dz_m=1.0)
    assert [len(t.rows) for t in xd.verify(model(), stated, config=case()).result.targets] == [1, 1, 0, 0]
    known = problem(changed(CONFIG, {f"targets.{i}.payload.std": {"mass_kg": 7.0} for i in range(2)}))
    assert [len(t.rows) for t in xd.verify(model(), frame, config=known).result.targets] == [1, 1]


def test_the_deviations_of_the_prediction_are_not_taken_for_those_of_the_instrument() -> None:
    frame = measured(commands(1), np.random.default_rng(1))
    written = frame.assign(**{name: commands(1)[name] for name in frame if name in ("sx_m", "sy_m", "sz_m")})
    written = written.assign(**{name: commands(1)[name] for name in ("srx_rad", "sry_rad", "srz_rad")})
    with pytest.raises(InputError, match="still those of the prediction"):
        xd.verify(model(), written)
    found = xd.verify(model(), written, config=case()).result
    assert found.targets[0].uncertainty[0] == pytest.approx(5e-7)


def test_a_check_measurement_is_read_in_the_order_of_its_sequence() -> None:
    frame = measured(commands(2), np.random.default_rng(1)).assign(sequence=[4, 3, 2, 1])
    check = read_check_measurement(table_of(frame, "check"), case().loaded.robot)
    np.testing.assert_array_equal(check.readings[:, 0], frame["dx_m"].to_numpy()[::-1])


ABOUT = "instrument: interferometer <X>\noperator: A. N. Other\ndate: 2026-03-01\nenvironment: 20.0 ± 0.1 °C\n"


def test_the_command_writes_a_certificate(tmp_path: Path, capsys: Printed) -> None:
    files = {name: tmp_path / name for name in ("model.yaml", "check.csv", "config.yaml", "about.yaml")}
    files["model.yaml"].write_text(model_text(model(), tmp_path))
    files["check.csv"].write_text(csv_text(measured(commands(2), np.random.default_rng(1))))
    files["config.yaml"].write_text(yaml.safe_dump(CONFIG))
    files["about.yaml"].write_text(ABOUT)
    out = tmp_path / "out"
    code = call(
        "verify", files["model.yaml"], files["check.csv"], "--config", files["config.yaml"],
        "--about", files["about.yaml"], "--out", out,
    )  # fmt: skip
    printed = capsys.readouterr()
    assert code == 0
    assert "verdict: pass" in printed.out
    assert "serial_number" in printed.err
    record = json.loads((out / "verification.json").read_text())
    assert record["verdict"] == "pass"
    digest = hashlib.sha256(files["check.csv"].read_bytes()).hexdigest()
    assert record["files"][str(files["check.csv"])] == digest
    assert record["about"]["date"] == "2026-03-01"
    page = (out / "report.html").read_text()
    number = record.pop("certificate")
    assert number == certificate_number(record)
    assert number != certificate_number(record | {"about": record["about"] | {"operator": "B"}})
    assert f"Certificate {number}, made by expdesign {xd.__version__}" in page
    assert 'content: "page " counter(page) " of " counter(pages)' in page
    for text in (digest, "A. N. Other", "20.0 ± 0.1 °C", "Name and signature", "interferometer &lt;X&gt;", "passes"):
        assert text in page


@pytest.mark.parametrize(
    ("text", "words"),
    [("operater: X\n", "Did you mean `operator`"), ("- a\n", "a mapping"), ("operator: [1]\n", "text is needed")],
)
def test_bad_texts_of_a_certificate(tmp_path: Path, capsys: Printed, text: str, words: str) -> None:
    (tmp_path / "about.yaml").write_text(text)
    (tmp_path / "model.yaml").write_text(model_text(model(), tmp_path))
    (tmp_path / "check.csv").write_text(csv_text(measured(commands(1), np.random.default_rng(1))))
    where = [tmp_path / name for name in ("model.yaml", "check.csv")]
    assert words in refusal(capsys, "verify", *where, "--about", tmp_path / "about.yaml", "--out", tmp_path / "out")


def test_the_number_of_readings_that_would_prove_conformity() -> None:
    # U = 0.8 of two readings has to come down to 0.4: four times as many.
    assert one_axis(2, 0.6, 0.4, 1.0).measurements_needed == 8
    assert one_axis(2, 0.1, 0.1, 1.0).measurements_needed == 2
    assert one_axis(2, 1.1, 0.1, 1.0).measurements_needed is None
    assert one_axis(0, np.nan, np.nan, 1.0).measurements_needed is None


def key_figures(found: xd.VerificationResult) -> list[str]:
    """Titles at the head of the certificate."""
    blocks = found.page().sections[0].blocks
    return [figure.label for block in blocks if isinstance(block, KeyFigures) for figure in block.items]


def test_a_certificate_that_does_not_pass_states_no_risk_and_says_how_many_readings_would_prove_it() -> None:
    frame = measured(commands(1), np.random.default_rng(2)).iloc[:1]
    found = xd.verify(model(), frame, config=case())
    assert found.result.verdict == "not proven"
    said = " ".join(statement(found.result))
    assert "No axis is proven to be beyond its tolerance" in said
    assert f"{words.count(found.result.readings_needed or 0, 'independent reading')} of every target" in said
    assert "Risk" not in key_figures(found)
    assert "Readings needed" in key_figures(found)
    assert found.record["readings_needed"] == found.result.readings_needed


def test_a_mean_beyond_its_tolerance_by_less_than_its_uncertainty_says_nothing_of_their_number() -> None:
    """One reading in which noise alone may be beyond the tolerance: more readings move the mean."""
    frame = measured(commands(1), np.random.default_rng(2), error={"dx_m": 3.2e-6})
    found = xd.verify(model(), frame, config=case()).result
    assert found.verdict == "not proven"
    assert found.readings_needed is None
    said = " ".join(statement(found))
    assert "cannot be said yet" in said
    assert "No number of readings" not in said
    failed = measured(commands(1), np.random.default_rng(2), error={"dx_m": 9e-6})
    assert "No number of readings" in " ".join(statement(xd.verify(model(), failed, config=case()).result))


def test_a_certificate_that_passes_states_its_risk() -> None:
    found = xd.verify(model(), measured(commands(3), np.random.default_rng(1)), config=case())
    assert found.result.readings_needed == 3
    assert "Three independent readings of every target proved it." in statement(found.result)
    assert "Risk" in key_figures(found)


def test_readings_at_no_target_of_the_configuration_are_named() -> None:
    here = case()
    elsewhere = problem(changed(CONFIG, {f"targets.{i}.pose": [0.005, -0.005 * (i + 1), 0, 0, 0, 0] for i in range(2)}))
    frame = measured(commands(2), np.random.default_rng(1))
    found = xd.verify(model(), frame, config=elsewhere).result
    assert found.off_target
    assert found.verdict == "not proven"
    assert any("No check reading is at a target" in text for text in statement(found))
    assert not xd.verify(model(), frame, config=here).result.off_target
    # As many as would prove it if the mean were 0: k·σ/√n ≤ T on every axis.
    needed = [np.ceil((2.0 * target.reading / target.tolerance) ** 2) for target in found.targets]
    assert found.readings_needed == max(np.nanmax(needed), 1)


def test_what_is_not_as_predicted_is_said_in_one_sentence_with_its_row() -> None:
    frame = measured(commands(2), np.random.default_rng(2))
    frame["dz_m"] = frame["dz_m"] + np.where(frame.index == 1, 2e-5, 0.0)
    found = xd.verify(model(), frame, config=case()).result
    assert found.statement.verdict == "refuted"
    said = " ".join(statement(found))
    assert "The attained poses are not those that the model predicts" in said
    assert "p below 1e-6" in said
    assert "row 3 (dz_m" in said


def test_a_wrong_sign_of_the_readings_is_named(caplog: pytest.LogCaptureFixture) -> None:
    frame = measured(commands(2), np.random.default_rng(2))
    other = measured(commands(2), np.random.default_rng(2), error={"dz_m": 2e-5})
    caplog.clear()
    for sound in (frame, other):
        xd.verify(model(), sound, config=case())
    assert not caplog.records
    xd.verify(model(), frame.assign(**{name: -frame[name] for name in STD}), config=case())
    assert "Do all deflections, or all loads, have the wrong sign?" in caplog.text


def test_overstated_deviations_of_check_readings_are_named() -> None:
    frame = measured(commands(4), np.random.default_rng(2))
    names = [name for name in map(str, frame.columns) if name.startswith("s") and name not in ("sequence", "series")]
    frame[names] *= 5.0
    found = xd.verify(model(), frame, config=case()).result
    assert found.statement.verdict == "too good"
    assert "times too large" in " ".join(statement(found))


def test_a_model_that_its_own_recordings_refute_is_named() -> None:
    refuted = replace(model(), fit="refuted")
    found = xd.verify(refuted, measured(commands(3), np.random.default_rng(1)), config=case())
    # The readings prove conformity at the targets, and nothing elsewhere.
    assert found.result.verdict == "pass"
    assert any("own recordings refute it" in text for text in statement(found.result))
    assert found.record["model_refuted"]

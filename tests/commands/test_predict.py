"""`expdesign predict`."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from expdesign.chain.models.model_file import read_model
from expdesign.chain.recordings.points import points_from_table
from expdesign.estimation.compensation.prediction import predict
from expdesign.io.table import read_table
from tests.commands.calls import Printed, call, model_file, plan_file


def test_points_are_filled_in_and_keep_order_and_columns(tmp_path: Path, capsys: Printed) -> None:
    model, plan, out = model_file(tmp_path), plan_file(tmp_path), tmp_path / "predicted.csv"
    frame = pd.read_csv(plan).iloc[::-1]
    frame.to_csv(plan, index=False)
    assert call("predict", model, plan, "--out", out) == 0
    assert f"{plan}: columns without a meaning here, kept but not used: note\n" in capsys.readouterr().err
    written = pd.read_csv(out)
    pd.testing.assert_frame_equal(written[list(frame.columns)], frame.reset_index(drop=True))
    expected = predict(read_model(model), points_from_table(read_table(plan), read_model(model).chain.robot))
    np.testing.assert_allclose(written["dz_m"], expected.deflections[::-1, 2], rtol=1e-12)
    np.testing.assert_allclose(written["srx_rad"], expected.deviations[::-1, 3], rtol=1e-12)


def test_what_was_measured_is_replaced_by_what_is_predicted(tmp_path: Path) -> None:
    model, out = model_file(tmp_path), tmp_path / "predicted.csv"
    assert call("predict", model, tmp_path / "recordings.csv", "--out", out, "--platform") == 0
    measured, predicted = pd.read_csv(tmp_path / "recordings.csv"), pd.read_csv(out)
    assert list(measured.columns) == list(predicted.columns)
    assert not np.allclose(measured["dz_m"], predicted["dz_m"], rtol=1e-6, atol=0.0)


@pytest.mark.parametrize(
    ("column", "value", "said"),
    [
        ("z_m", 0.3, ["a point is beyond the robot's limits: leg"]),
        (
            "mass_kg",
            106.0,
            [
                "the mass is 106 kg, 4 times the largest that was calibrated",
                "moment_Nm 116.2 (recorded up to 29.06); mass_kg 106 (recorded up to 26.5)",
            ],
        ),
    ],
)
def test_points_beyond_limits_and_calibration_are_named_and_predicted(
    column: str, value: float, said: list[str], tmp_path: Path, capsys: Printed
) -> None:
    """A recorded row may lie there: the file's limits are often narrower than the machine's."""
    model, plan, out = model_file(tmp_path), plan_file(tmp_path), tmp_path / "predicted.csv"
    frame = pd.read_csv(plan).astype({column: float})
    frame.loc[1, column] = value
    frame.to_csv(plan, index=False)
    capsys.readouterr()
    assert call("predict", model, plan, "--out", out) == 0
    printed = capsys.readouterr().err
    assert all(f"row 3: {each}" in printed for each in said)
    assert np.isfinite(pd.read_csv(out)["dz_m"]).all()

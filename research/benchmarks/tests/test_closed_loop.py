"""The closed loop: files from plan to attained pose, and the benchmark that compares criteria."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.commands.calls import ROBOT, ROOT, call, plan_file

pytest.importorskip("exudyn", reason="the virtual laboratory's engine is an extra")
from expdesign.planning.problem_file import read_problem
from research.benchmarks import closed_loop

POSE = ["x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad"]


def test_recordings_of_the_laboratory_make_the_robot_accurate(tmp_path: Path) -> None:
    from research.laboratory import Laboratory, Robot  # noqa: PLC0415 (an extra)

    plan = pd.read_csv(plan_file(tmp_path)).drop(columns="note")
    bench = Laboratory(
        Robot.read(ROBOT),
        true_stiffness=np.array([5.1, 4.2, 6.0, 5.5, 4.8, 5.0]) * 1e6,
        noise_std=[5e-7] * 3 + [2e-6] * 3,
        seed=3,
    )
    recordings, targets, commands = (tmp_path / f"{name}.csv" for name in ("recordings", "targets", "commands"))
    bench.measure(plan).to_csv(recordings, index=False)
    wanted = plan.assign(x_m=0.005, y_m=[0.0, 0.01, 0.0, -0.01], series=[1, 2, 3, 4])
    wanted.to_csv(targets, index=False)
    assert call("identify", ROBOT, recordings, "--out", tmp_path / "identified") == 0
    assert call("compensate", tmp_path / "identified" / "model.yaml", targets, "--out", commands) == 0
    written = pd.read_csv(commands)
    errors = bench.attained(written)[POSE].to_numpy() - wanted[POSE].to_numpy()
    by_length = bench.attained(written, lengths=True)[POSE].to_numpy() - wanted[POSE].to_numpy()
    uncompensated = bench.attained(wanted)[POSE].to_numpy() - wanted[POSE].to_numpy()
    deviations = written[["sx_m", "sy_m", "sz_m", "srx_rad", "sry_rad", "srz_rad"]].to_numpy()
    assert (np.abs(errors) < 4.0 * deviations).all()
    np.testing.assert_allclose(by_length, errors, atol=1e-12)
    assert np.abs(errors).max() < 0.1 * np.abs(uncompensated).max()


def test_the_benchmark_writes_its_result(tmp_path: Path) -> None:
    options = ["--repetitions", "3", "--generations", "2", "--out", str(tmp_path / "out")]
    closed_loop.main([str(ROOT / "configs" / "closed-loop.yaml"), *options])
    table = pd.read_csv(tmp_path / "out" / "attained.csv").set_index("plan_by")
    assert float(table["mean"]["no compensation"]) > 5.0 * float(table["mean"]["total"])
    assert {"duir", "feir", "total", "o1", "o2", "o3", "o4", "o5", "o_tp", "random"} <= set(table.index)
    page = (tmp_path / "out" / "README.md").read_text(encoding="utf-8")
    assert "research.benchmarks.closed_loop " in page
    assert not [name for name in table.index if f"| {name} | {table['mean'][name]:.3f} ± " not in page]


@pytest.mark.slow
def test_the_attained_error_is_the_predicted_total() -> None:
    """RMS over 300 robots and experiments within 4 standard errors of the criterion."""
    problem = read_problem(ROOT / "configs" / "closed-loop-load-errors.yaml")
    setting = closed_loop.loop_of(problem, 0.1)
    plans = {"total": closed_loop.plans_by_criterion(problem, 1, 5)["total"]}
    attained, predicted = closed_loop.run(setting, plans, 300, 2)
    row = closed_loop.summary(attained, predicted).set_index("plan_by").loc["total"]
    # The criterion takes the approximate stiffness for the true one, which is scattered by 10 %.
    assert abs(row["rms"] - row["predicted_total"]) < 4.0 * row["rms_standard_error"] + 0.02 * row["rms"]

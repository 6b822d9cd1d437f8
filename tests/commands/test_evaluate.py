"""`evaluate`: what theory.md section 11 gives reaches the record, and what cannot be identified is null and said."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.commands.calls import Printed, call, refusal, yaml_file
from tests.design.problems import BIPOD, changed

CONFIG = changed(
    BIPOD,
    {
        "experiment.measurements": 1,
        "experiment.load": {"kind": "wrench", "fx_N": [-1000, 1000], "fy_N": [-1000, 1000]},
        "experiment.deflection_noise": {"std": {"dx_m": 1.0, "dy_m": 1.0}},
        "experiment.load_error": [{"source": "wrench", "std": [2.0, 3.0], "shared": False}],
        "targets.0.tolerance": {"dx_m": 1.0, "dy_m": 1.0},
        "optimiser": ...,
    },
)
HEADER = "sequence,series,x_m,y_m,fx_N,fy_N\n"
VECTOR_U = [[1.1442042521, -0.2390983402], [-0.2390983402, 1.1581359476]]
VECTOR_Z = np.array([[-0.1086639676, -0.0330364372], [0.0240485830, -0.0746558704]]) * 1e-6


def evaluate(folder: Path, rows: str, capsys: Printed, config: dict[str, Any] = CONFIG) -> tuple[int, str, str]:
    plan = folder / "plan.csv"
    plan.write_text(rows if rows.startswith("sequence") else HEADER + rows)
    code = call("evaluate", yaml_file(folder / "config.yaml", config), plan, "--json")
    printed = capsys.readouterr()
    return code, printed.out, printed.err


def test_vectors_of_the_theory(tmp_path: Path, capsys: Printed) -> None:
    """`tests/docs/test_theory.py` has the vectors themselves."""
    code, output, _ = evaluate(tmp_path, "1,1,-0.20,0.55,200,-900\n", capsys)
    record = json.loads(output)
    assert code == 0
    target = record["targets"][0]
    np.testing.assert_allclose(target["U"], VECTOR_U, atol=1e-10)
    np.testing.assert_allclose(target["Z"], VECTOR_Z, atol=1e-16)
    np.testing.assert_allclose(target["cov_fe"], VECTOR_Z @ np.diag([4.0, 9.0]) @ VECTOR_Z.T, rtol=1e-8)
    assert record["duir"] == pytest.approx(np.sqrt(np.trace(VECTOR_U)), abs=1e-9)
    assert record["feir"] == pytest.approx(np.sqrt(np.trace(np.array(target["cov_fe"]))), rel=1e-12)
    assert record["total"] == pytest.approx(np.hypot(record["duir"], record["feir"]), rel=1e-12)
    assert record["rank"] == 2
    assert record["condition"] == pytest.approx(1.0 / record["o2"], rel=1e-9)


def test_a_plan_without_loads_is_named_and_not_the_knowledge_of_loads(tmp_path: Path, capsys: Printed) -> None:
    plan = tmp_path / "plan.csv"
    plan.write_text(HEADER + "1,1,-0.20,0.55,0,0\n2,2,0.1,0.5,0,0\n")
    assert call("evaluate", yaml_file(tmp_path / "config.yaml", CONFIG), plan) == 0
    printed = capsys.readouterr()
    assert f"{plan}: no load acts on any actuator" in printed.err
    assert "Know the load better" not in printed.out
    message = refusal(capsys, "montecarlo", tmp_path / "config.yaml", plan, "--out", tmp_path / "out")
    assert f"expdesign: {plan}: no load acts on any actuator" in message


def test_what_cannot_be_identified_is_null_and_said(tmp_path: Path, capsys: Printed) -> None:
    # Along the second leg's direction the first leg carries nothing.
    code, output, error = evaluate(tmp_path, "1,1,0.0,0.5,-500,500\n", capsys)
    record = json.loads(output)
    assert code == 0
    assert record["rank"] == 1
    assert record["duir"] is None
    assert record["condition"] is None
    assert record["o3"] == 0.0
    assert "identify 1 of 2 stiffnesses" in error

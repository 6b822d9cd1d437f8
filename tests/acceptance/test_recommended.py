"""What is recommended, and what is enough, is what is expected to pass; a complete enumeration leaves nothing open."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml

import expdesign as xd

TWO_LEGS: dict[str, Any] = {
    "schema_version": 1,
    "robot": {
        "name": "two legs",
        "kind": "bipod",
        "home": [0.0, 0.7],
        "base_joints": [[-0.6, 0.0], [0.35, 0.05]],
        "actuator_stiffness": [1.2e7, 0.8e7],
    },
    "experiment": {
        "measurements": 2,
        "poses": {"grid": {"x_m": [-0.2, 0.2, 3], "y_m": [-0.1, 0.15, 3]}},
        "load": {"kind": "wrench", "fx_N": {"choices": [-200, 0, 200]}, "fy_N": {"choices": [-300, 300]}},
        "deflection_noise": {"std": {"dx_m": 1.0e-6, "dy_m": 1.5e-6}},
        "load_error": [
            {"source": "wrench", "std": [4, 6], "shared": True},
            {"source": "direction", "std": 0.01, "shared": False},
        ],
    },
    "targets": [
        {"pose": [0.1, 0.05], "wrench": [100, -400], "tolerance": {"dx_m": 2e-6, "dy_m": 3e-6}},
        {"pose": [-0.15, 0.0], "wrench": [0, -400], "tolerance": {"dy_m": 2e-6}, "weight": 3},
    ],
    "optimiser": {"effort": "quick"},
}
"""A plan of each of its few designs can be evaluated; that of the least total does not pass."""


@pytest.fixture(scope="module")
def config(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("two-legs") / "config.yaml"
    path.write_text(yaml.safe_dump(TWO_LEGS))
    return path


@pytest.fixture(scope="module")
def found(config: Path) -> xd.RunResult:
    return xd.run(config)


def test_of_the_designs_that_pass_the_least_total_is_recommended(config: Path, found: xd.RunResult) -> None:
    plans = [found.plan_of(design) for design in range(len(found.front))]
    passes = [xd.evaluate(config, plan).record["acceptance"]["passes"] for plan in plans]
    totals, least = found.front.criteria["total"], int(found.front.criteria["total"].argmin())
    assert not passes[least]
    assert passes[found.front.recommended]
    assert found.total == min(total for total, passing in zip(totals, passes, strict=True) if passing)
    assert found.record["acceptance"]["passes"]
    assert found.pareto["recommended"].tolist().index(True) == found.front.recommended
    assert any(
        f"Design {least + 1} has the least total" in line and f"has the least of the {sum(passes)} that are" in line
        for line in found.said.sentences
    )


def test_where_every_design_was_evaluated_none_may_be_better(found: xd.RunResult) -> None:
    assert found.front.complete
    assert "if there is one" not in found.said.sentences[-1]
    assert "Every design was evaluated: none has a smaller DUIR" in found.said.sentences[-1]


def test_next_says_what_an_evaluation_of_the_same_rows_says(config: Path, found: xd.RunResult) -> None:
    """Also where the expected total error is below 1 tolerance."""
    least = int(found.front.criteria["total"].argmin())
    recorded = xd.simulate(config, found.plan_of(least)).frame
    proposed = xd.plan_next(config, recorded, count=1)
    assert proposed.totals[0] < 1.0
    text = " ".join(proposed.said.sentences)
    assert "not expected to pass" in text
    assert "needed" not in text
    both = pd.concat([found.plan_of(least), proposed.frame], ignore_index=True)
    for rows, decided in ((found.plan_of(least), proposed.decisions[0]), (both, proposed.decisions[1])):
        assert xd.evaluate(config, rows).record["acceptance"]["passes"] is decided.robot_passes
    assert ("with 1 more the robot is expected to pass" in text) is proposed.decisions[1].robot_passes
    enough = xd.plan_next(config, xd.simulate(config, both).frame, count=1)
    assert "No further measurement is needed" in " ".join(enough.said.sentences)


def test_next_widens_by_student_where_the_noise_is_estimated(config: Path, found: xd.RunResult) -> None:
    """As `identify --targets` does of the same recordings."""
    rows = pd.concat([found.plan_of(0), found.plan_of(len(found.front) - 1)], ignore_index=True)
    rows["sequence"] = rows["series"] = np.arange(len(rows)) + 1
    recorded = xd.simulate(config, rows).frame.drop(columns=["sx_m", "sy_m"])
    proposed = xd.plan_next(config, recorded, count=2)
    identified = xd.identify(TWO_LEGS["robot"], recorded, targets=config).acceptance
    assert identified is not None
    now, *later = (decision.budget.factor[decision.budget.matters].max() for decision in proposed.decisions)
    assert now > 2.1
    assert now == pytest.approx(identified.budget.factor[identified.budget.matters].max(), rel=0.1)
    assert all(factor < now for factor in later)

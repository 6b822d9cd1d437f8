"""Further measurements that leave less to be hidden."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from tests.commands.calls import call
from tests.model_error.problems import CONFIGS, assessed, impact, plans, problem

from expdesign.api.plan_next import plan_next
from expdesign.design.sequential import expected_total
from expdesign.errors import InputError
from expdesign.identification.recorded_knowledge import recorded_knowledge
from expdesign.model_error.left_out import plan_points
from expdesign.model_error.next_rows import NextRows, Objective, next_rows
from expdesign.recordings.recordings import Recordings

NAME = "hexapod-h1"


def recorded(count: int) -> tuple[Recordings, np.ndarray, np.ndarray]:
    """Recordings that follow the first rows of a random plan."""
    case = problem(NAME)
    configurations, loads = (array[0] for array in plans(NAME, 1))
    points = plan_points(case.loaded, configurations[:count], loads[:count])
    axes = case.noise.axes
    made: dict[str, Any] = {"axes": axes, "deflections": np.zeros((count, len(axes))), "test": np.zeros(count, bool)}
    deviations = np.tile(np.sqrt(np.diag(case.noise.covariance)), (count, 1))
    return Recordings(**vars(points), **made, deviations=deviations), configurations[:count], loads[:count]


def found(objective: Objective, count: int = 2, rows: int = 4) -> NextRows:
    recordings, _, loads = recorded(rows)
    known = recorded_knowledge(problem(NAME), recordings, loads)
    return next_rows(impact(NAME), recordings, known, objective, count=count, accuracy=None, seed=1)


@pytest.fixture(scope="module")
def by_meir() -> NextRows:
    return found(Objective.MEIR)


def test_expected_meir_is_that_of_the_whole_plan(by_meir: NextRows) -> None:
    """What is said before and after is the MEIR of recordings and rows together, evaluated as one plan."""
    _, configurations, loads = recorded(4)
    meir = impact(NAME)
    added_poses, added_loads = problem(NAME).space.decode(by_meir.decisions)
    for count, expected in enumerate((by_meir.before, *by_meir.after)):
        poses = np.concatenate([configurations, added_poses[:count]])[None]
        weights = np.concatenate([loads, added_loads[:count]])[None]
        assert expected.meir == pytest.approx(float(meir.values(assessed(meir, poses, weights))[0]), rel=1e-6)


def test_rows_by_meir_hide_less_than_rows_by_total(by_meir: NextRows) -> None:
    by_total, both = found(Objective.TOTAL), found(Objective.BOTH)
    values = [each.meir for each in (by_meir.before, *by_meir.after)]
    assert values == sorted(values, reverse=True)
    assert by_meir.after[0].meir < by_total.after[0].meir
    assert by_total.after[0].total < by_meir.after[0].total
    # One row at a time, the sum of squares lies between the two.
    ends = [float(np.hypot(each.after[0].total, each.after[0].meir)) for each in (both, by_meir, by_total)]
    assert ends[0] <= min(ends[1:]) * (1.0 + 1e-9)


def test_an_accuracy_ends_the_search(by_meir: NextRows) -> None:
    recordings, _, loads = recorded(4)
    known = recorded_knowledge(problem(NAME), recordings, loads)
    wanted = by_meir.after[0].meir * 1.001
    ended = next_rows(impact(NAME), recordings, known, Objective.MEIR, count=5, accuracy=wanted, seed=1)
    assert len(ended.decisions) == len(ended.after) == 1


def test_an_objective_that_is_none() -> None:
    with pytest.raises(InputError, match="total, meir, both") as caught:
        plan_next(CONFIGS / "hexapod-h1.yaml", "recordings.csv", objective="duir")
    assert caught.value.where == "--objective"


def test_too_little_is_known_for_meir() -> None:
    """One row with a symmetric load may not determine six legs: the first added rows see to that."""
    recordings, _, loads = recorded(1)
    few = replace(recordings, axes=recordings.axes[:3], deflections=recordings.deflections[:, :3])
    few = replace(few, deviations=np.full((1, 3), 5e-7))
    known = recorded_knowledge(problem(NAME), few, loads)
    assert not np.isfinite(expected_total(known, problem(NAME).targets, problem(NAME).loaded.robot.compliance))
    added = next_rows(impact(NAME), few, known, Objective.MEIR, count=2, accuracy=None, seed=1)
    assert np.isinf(added.before.meir)
    assert np.isfinite(added.after[-1].meir)


def test_geometric_calibration_has_no_meir_to_lower(capsys: pytest.CaptureFixture[str]) -> None:
    """Said before the recordings are read, with what may be asked for instead."""
    config = str(CONFIGS / "hexapod-geometric.yaml")
    for objective in ("meir", "both"):
        assert call("next", config, "recordings.csv", "--objective", objective, "--out", "next.csv") == 2
        said = capsys.readouterr().err
        assert f"hexapod-geometric.yaml, experiment.calibration: `--objective {objective}` is" in said
        assert "elastostatic calibration only. `--objective total` knows every calibration" in said

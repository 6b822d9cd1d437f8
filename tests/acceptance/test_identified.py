"""Acceptance after identification: the planned budget where the noise is as planned, wider where it was estimated."""

from pathlib import Path

import numpy as np
import pytest
from tests.acceptance.test_acceptance import decision, plan_for
from tests.design.problems import HEXAPOD, problem

import expdesign as xd
from expdesign.design.plan import plan_frame
from expdesign.errors import InputError

CASE = {"experiment.load.gravity": ..., "experiment.measurements": 6}


def test_the_budget_is_the_planned_one_where_the_noise_is_as_planned() -> None:
    case = problem(HEXAPOD, CASE)
    plan = plan_for(case, 2)
    frame = plan_frame(plan, case.loaded, False)
    recorded = xd.simulate(case, frame, load_errors=False).frame
    planned = decision(case, plan).budget
    found = xd.identify(HEXAPOD["robot"], recorded, targets=case).acceptance
    assert found is not None
    names = [one.name for one in planned.contributions]
    assert [one.name for one in found.budget.contributions] == names
    np.testing.assert_allclose(found.budget.expanded, planned.expanded, rtol=1e-9)


def test_estimated_noise_has_degrees_of_freedom() -> None:
    case = problem(HEXAPOD, CASE)
    frame = plan_frame(plan_for(case, 2), case.loaded, False)
    recorded = xd.simulate(case, frame, load_errors=False).frame
    recorded = recorded.drop(
        columns=[n for n in recorded if n in ("sx_m", "sy_m", "sz_m", "srx_rad", "sry_rad", "srz_rad")]
    )
    found = xd.identify(HEXAPOD["robot"], recorded, targets=case).acceptance
    assert found is not None
    assert np.isfinite(found.budget.degrees).all()
    assert (found.budget.factor > 2.0).all()


def test_residuals_beyond_the_noise_are_a_contribution_of_the_model(tmp_path: Path) -> None:
    case = problem(HEXAPOD, CASE)
    frame = plan_frame(plan_for(case, 2), case.loaded, False)
    recorded = xd.simulate(case, frame, load_errors=False).frame
    recorded["dz_m"] += np.where(np.arange(len(recorded)) % 2 == 0, 1e-5, -1e-5)
    identified = xd.identify(HEXAPOD["robot"], recorded, targets=case)
    assert identified.acceptance is not None
    assert identified.acceptance.budget.contributions[-1].name == "model"
    assert identified.record["acceptance"]["targets"][0]["axes"][0]["budget"]["model"] > 0.0
    identified.save(tmp_path / "out")
    assert "Acceptance" in (tmp_path / "out" / "report.html").read_text()


def test_the_configuration_of_another_robot_is_refused() -> None:
    from tests.design.problems import BIPOD  # noqa: PLC0415

    case = problem(HEXAPOD, CASE)
    recorded = xd.simulate(case, plan_frame(plan_for(case, 2), case.loaded, False)).frame
    with pytest.raises(InputError, match="configuration is of a bipod"):
        xd.identify(HEXAPOD["robot"], recorded, targets=problem(BIPOD))

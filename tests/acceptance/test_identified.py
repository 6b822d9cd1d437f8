"""Acceptance after identification: the planned budget where the noise is as planned, wider where it was estimated."""

from pathlib import Path

import numpy as np
import pytest
from tests.acceptance.test_acceptance import decision, plan_for
from tests.design.problems import HEXAPOD, problem

import expdesign as xd
from expdesign.assurance.acceptance.decision import sentences
from expdesign.errors import InputError
from expdesign.planning.plan import plan_frame

CASE = {"experiment.load.gravity": ..., "experiment.measurements": 6}


def test_the_budget_is_the_planned_one_where_the_noise_is_as_planned() -> None:
    case = problem(HEXAPOD, CASE)
    plan = plan_for(case, 2)
    frame = plan_frame(plan, case.loaded, False)
    # Without noise the identified stiffness is that of the plan, about which load errors are linearised.
    recorded = xd.simulate(case, frame, noise=False, load_errors=False).frame
    planned = decision(case, plan).budget
    found = xd.identify(HEXAPOD["robot"], recorded, targets=case).acceptance
    assert found is not None
    names = [one.name for one in planned.contributions]
    assert [one.name for one in found.budget.contributions] == names
    np.testing.assert_allclose(found.budget.expanded, planned.expanded, rtol=1e-7)


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


def test_nothing_is_decided_with_a_model_that_its_recordings_refute(tmp_path: Path) -> None:
    case = problem(HEXAPOD, CASE)
    frame = plan_frame(plan_for(case, 2), case.loaded, False)
    recorded = xd.simulate(case, frame, load_errors=False).frame
    recorded["dz_m"] += np.where(np.arange(len(recorded)) % 2 == 0, 1e-5, -1e-5)
    identified = xd.identify(HEXAPOD["robot"], recorded, targets=case)
    assert identified.acceptance is not None
    assert identified.acceptance.verdict == "not decided"
    record = identified.record["acceptance"]
    assert record["verdict"] == "not decided"
    assert record["passes"] is None
    for target in record["targets"]:
        assert target["passes"] is None
        for axis in target["axes"]:
            assert axis["passes"] is None
            assert axis["probability_beyond_tolerance"] is None
    (said,) = sentences(identified.acceptance)
    assert "not decided" in said
    assert "expdesign diagnose" in said
    identified.save(tmp_path / "out")
    page = (tmp_path / "out" / "report.html").read_text()
    assert "not decided" in page
    assert "has the probability" not in page


def test_the_configuration_of_another_robot_is_refused() -> None:
    from tests.design.problems import BIPOD  # noqa: PLC0415

    case = problem(HEXAPOD, CASE)
    recorded = xd.simulate(case, plan_frame(plan_for(case, 2), case.loaded, False)).frame
    with pytest.raises(InputError, match="this is about a bipod with 2 actuators"):
        xd.identify(HEXAPOD["robot"], recorded, targets=problem(BIPOD))

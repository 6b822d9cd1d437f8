"""What a plan for a diagnosed robot attains, beside the plan for the robot that its file describes."""

import numpy as np
from benchmarks.found_robot import attained_errors, rms
from tests.design.problems import HEXAPOD
from tests.design.test_found_robot import designs, model_of, planned, written

from expdesign.planning.criteria.accuracy import Total
from expdesign.planning.plan import Plan

SOFT = {("base_compliance", "base", "diagonal"): [2.5e-8, 3.3e-8, 1.7e-8, 3.3e-7, 5e-7, 2.5e-7]}
"""m/N and rad/(N·m): of the size of that in the benchmark."""


def test_the_known_base_is_compensated_and_the_unknown_one_is_not() -> None:
    """The same plan: with the diagnosed model the error is as predicted (3 standard errors), without it far larger."""
    bare = planned(HEXAPOD["robot"], {})
    found = planned(written(model_of(HEXAPOD["robot"], SOFT, 0.9)), {})
    poses, loads = (part[0] for part in found.space.decode(designs(found, 1)))
    plan = Plan(poses, loads, np.arange(1, len(poses) + 1))
    expected = float(Total().values(found.assess(poses[None], loads[None]))[0])
    known = rms(found, attained_errors(found, found, plan, 5000, 1))
    unknown = rms(found, attained_errors(bare, found, plan, 5000, 1))
    assert abs(known.value[0] - expected) < 3.0 * known.standard_error[0]
    assert unknown.value[0] - 3.0 * unknown.standard_error[0] > 1.5 * known.value[0]

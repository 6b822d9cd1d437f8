"""The base model stands in three forms, which are one model: the chain (readings of any robot), matrices in closed form
(criteria of many designs), and an expression (the plant that compensates).
"""

import casadi as ca
import numpy as np
import pytest

from expdesign.assurance.validation.compensation import deflection_map
from expdesign.chain.chain import Chain
from expdesign.chain.row import row_data
from expdesign.mechanics.elastostatics.maps import observation_matrix
from expdesign.mechanics.elastostatics.measurements import LoadedRobot
from expdesign.mechanics.loads.load import Wrench
from tests.cases import ROBOTS, robot
from tests.chain.places import WRENCH, recordings

every_robot = pytest.mark.parametrize("name", ROBOTS)


@every_robot
def test_the_chain_without_effects_is_the_observation_matrix(name: str) -> None:
    here, points = robot(name), recordings(name, WRENCH)
    chain = Chain(here)
    predicted = chain.predict(row_data(points, here), np.ones(chain.compliances))
    matrix = observation_matrix(here.jacobians(points.configurations), points.wrenches)
    assert predicted == pytest.approx(matrix @ here.compliance, rel=1e-9, abs=1e-18)


@every_robot
def test_the_plant_s_expression_is_the_matrix_of_the_criteria(name: str) -> None:
    here, points = robot(name), recordings(name, WRENCH)
    loaded = LoadedRobot(here, Wrench(here.coordinates))
    poses, wrenches = points.configurations, points.wrenches
    closed = observation_matrix(here.jacobians(poses), wrenches)
    pose, wrench = ca.SX.sym("X", poses.shape[1]), ca.SX.sym("F", wrenches.shape[1])
    expression = ca.Function("A", [pose, wrench], [deflection_map(loaded, pose, wrench)])
    for row in range(0, len(points), 5):
        found = np.array(expression(poses[row], wrenches[row]))
        assert found == pytest.approx(closed[row], rel=1e-9, abs=1e-9 * max(np.abs(closed[row]).max(), 1e-30))

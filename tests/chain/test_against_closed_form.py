"""The base model stands in two forms, which are one model: the chain (readings of any robot), and matrices in closed
form (criteria of many designs, and the plant that compensates).
"""

import numpy as np
import pytest

from expdesign.chain.chain import Chain
from expdesign.chain.row import row_data
from expdesign.mechanics.elastostatics.maps import observation_matrix
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

"""Laws in words: every quantity that a port of a robot sees has a name, an identifier and a unit."""

from pathlib import Path

import numpy as np
import pytest
from tests.cases import robot
from tests.chain.arms import read_arm
from tests.chain.bodies import BODY

from expdesign.ports import quantities
from expdesign.ports.quantities import Quantity
from expdesign.ports.words import columns, depends_on, identifier
from expdesign.robots.robot import Robot

_AXES = {"position", "distance", "towards", "own_gravity", "latched"}


def _seen(here: Robot) -> list[Quantity]:
    """Every quantity that some port of the robot may see, at every index."""
    actuators, axes = len(here.stiffness), here.coordinates.n
    forces = range(actuators + 2 * axes)
    counts = {
        "effort": forces, "effort_sign": forces, "stop": forces, "lag": forces,
        "joint_moment": range(3 * actuators if here.links is not None else 0), "length": range(actuators),
        "pose": range(len(here.configuration)), "overlap": range(len(here.configuration)),
        "warming": range(max(actuators, 1)),
    }  # fmt: skip
    kinds = {*quantities._VALUES, "stop", "lag", "latched", "overlap", "settling"} - {"towards"}
    found = []
    for kind in sorted(kinds):
        usual = range(len(here.gravity)) if kind in _AXES else range(axes)
        found += [Quantity(kind, index, (1.0, 1.0, 1.0)) for index in counts.get(kind, usual)]
    return found


@pytest.mark.parametrize("name", ["bipod", "H1", "seven joints", "body"])
def test_every_quantity_has_words(name: str, tmp_path: Path) -> None:
    here: Robot = read_arm(tmp_path) if name == "seven joints" else BODY if name == "body" else robot(name)
    seen = _seen(here)
    assert len({q.index for q in seen if q.kind == "joint_moment"}) == (21 if name == "seven joints" else 0)
    for quantity in seen:
        assert all(text for text in depends_on((quantity,), here))
        assert identifier(quantity, here)
        assert np.shape(columns((quantity, quantity), here)) == (2,)


def test_the_moment_of_the_seventh_joint_is_named(tmp_path: Path) -> None:
    assert depends_on((Quantity("joint_moment", 20),), read_arm(tmp_path)) == ["the moment about z of joint 7"]

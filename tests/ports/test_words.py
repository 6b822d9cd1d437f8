"""Laws in words: every quantity that a port of a robot sees has a name, an identifier and a unit."""

from pathlib import Path

import numpy as np
import pytest

from expdesign.chain.ports import quantities
from expdesign.chain.ports.law import ports_of
from expdesign.chain.ports.quantities import Quantity
from expdesign.chain.ports.words import columns, depends_on, says
from expdesign.chain.row import LAGS
from expdesign.mechanics.robots.robot import Robot
from tests.cases import robot
from tests.chain.arms import read_arm
from tests.chain.bodies import BODY

_AXES = {"position", "distance", "towards", "own_gravity", "latched"}


def _seen(here: Robot) -> list[Quantity]:
    """Every quantity that some port of the robot may see, at every index."""
    actuators, axes = len(here.stiffness), here.coordinates.n
    forces = range(actuators + 2 * axes)
    counts = {
        "effort": forces, "effort_sign": forces, "stop": forces, "lag": forces,
        "joint_moment": range(3 * actuators if here.jointed else 0), "length": range(actuators),
        "pose": range(len(here.configuration)), "overlap": range(len(here.configuration)),
        "warming": range(max(actuators, 1)), "pair": range(actuators), "pair_sign": range(actuators),
        "slow_temperature": range(len(LAGS)), "slow_warmth": range(len(LAGS)), "approach": range(actuators),
    }  # fmt: skip
    kinds = set(quantities.KINDS) - {"towards"}
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
        assert quantity.identifier(here)
        assert np.shape(columns((quantity, quantity), here)) == (2,)


def test_the_moment_of_the_seventh_joint_is_named(tmp_path: Path) -> None:
    assert depends_on((Quantity("joint_moment", 20),), read_arm(tmp_path)) == ["the moment about z of joint 7"]


def test_angles_of_joints_are_in_radians(tmp_path: Path) -> None:
    arm = read_arm(tmp_path)
    assert depends_on((Quantity("length", 1),), arm) == ["the angle of joint 2"]
    assert columns((Quantity("length", 1), Quantity("effort", 1)), arm) == ("angle_rad", "moment_Nm")
    assert columns((Quantity("length", 1), Quantity("effort", 1)), robot("H1")) == ("length_m", "force_N")


def test_every_port_names_what_its_laws_add(tmp_path: Path) -> None:
    """What acts on the platform is a wrench, a centre of mass a shift, and geometry the coordinates of its joints."""
    for here in (robot("bipod"), robot("H1"), read_arm(tmp_path)):
        named = {port.name: tuple(port.outputs) for port in ports_of(here)}
        assert all(
            len(named[port.name]) == port.width == len(set(named[port.name]))
            for port in ports_of(here)
            if port.name != "joints"
        )
        assert named["payload"] == here.coordinates.wrench
    assert named["centre of mass"] == ("com_dx_m", "com_dy_m", "com_dz_m")
    parallel = {port.name: tuple(port.outputs) for port in ports_of(robot("H1"))}
    assert parallel["geometry"][0] == "base_1_x_m"
    assert parallel["actuators"][0] == "leg 1"


def test_a_law_that_is_always_the_same_depends_on_nothing() -> None:
    assert says("load", []) == "carries another load than stated"
    assert (
        says("load", ["the size of the load"]) == "carries another load than stated, depending on the size of the load"
    )
    assert says("geometry", []) == "is not as the robot file says"
    assert says("twist", ["a", "b", "c", "d"]).endswith("depending on a, b, c and others")

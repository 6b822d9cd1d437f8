"""A robot of any kind, known only by its Jacobians and its limits, is treated like a parallel one."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from expdesign.coordinates import SPATIAL
from expdesign.mechanics.elastostatics.measurements import LoadedRobot
from expdesign.mechanics.robots.robot import Robot
from expdesign.planning.optimality.certificate import Certificate
from expdesign.planning.optimality.kktpm import kktpm
from expdesign.planning.optimality.pool import BRIEF
from expdesign.planning.problem import DesignProblem
from tests.design.optimality.central_differences import criterion_gradients
from tests.design.problems import HEXAPOD, designs, problem
from tests.design.refined import refined

NAMES = ["duir", "feir", "total", "o1", "o_tp"]


def _delegate(name: str) -> Any:
    return lambda self, *arguments: getattr(self.hidden, name)(*arguments)


def disguised_as_any_robot(robot: Robot) -> Robot:
    """A hexapod that does not say that it is one: no more than what every robot gives."""
    methods = {name: _delegate(name) for name in (*Robot.__abstractmethods__, "limited")}
    methods["limits"] = property(lambda self: self.hidden.limits)
    kind = type("Disguised", (Robot,), {**methods, "kind": "disguised", "coordinates": SPATIAL})
    copy = kind()
    for name in ("name", "stiffness", "gravity", "configuration"):
        setattr(copy, name, getattr(robot, name))
    copy.hidden = robot
    return copy


@pytest.fixture(scope="module")
def both() -> tuple[DesignProblem, DesignProblem]:
    plain = problem(HEXAPOD, {"optimiser.population": 8})
    loaded = LoadedRobot(disguised_as_any_robot(plain.loaded.robot), plain.loaded.load, plain.loaded.sources)
    return plain, replace(plain, loaded=loaded)


def test_gradients_are_the_same(both: tuple[DesignProblem, DesignProblem]) -> None:
    plain = both[0]
    decisions = designs(plain, 4)
    expected, found = (criterion_gradients(here, decisions, NAMES) for here in both)
    for name in NAMES:
        np.testing.assert_allclose(found[name][0], expected[name][0], rtol=1e-9)
        scale = np.abs(expected[name][1]).max()
        np.testing.assert_allclose(found[name][1], expected[name][1], rtol=1e-6, atol=1e-9 * scale)


def test_polish_and_bound(both: tuple[DesignProblem, DesignProblem]) -> None:
    plain, disguised = both
    decisions = designs(plain, 4, seed=1)
    found = refined(disguised, decisions, generations=6)
    assert disguised.loaded.robot.usable(plain.space.decode(found)[0]).all()
    best = criterion_gradients(disguised, found, ["duir"])["duir"][0].min()
    bounds = [Certificate(here, 0.0, BRIEF).bound().value for here in both]
    assert bounds[1] == pytest.approx(bounds[0], rel=1e-3)
    assert bounds[1] is not None
    assert bounds[1] <= best
    assert np.nanmin(kktpm(disguised, found)) < 1e-6

"""What MEIR assumes, and what it refuses."""

import pytest
from tests.model_error.problems import problem

from expdesign.errors import InputError
from expdesign.model_error.impact import ModelErrorImpact
from expdesign.model_error.left_out import physics_of_problem
from expdesign.model_error.prior_sizes import SIZES, size_of
from expdesign.model_error.settings import Assumptions


@pytest.mark.parametrize("name", ["hexapod-h1", "bipod", "ur5"])
def test_every_parameter_has_a_size_with_a_source(name: str) -> None:
    for entry in physics_of_problem(problem(name), Assumptions()):
        for index in entry.free:
            assert size_of(entry.effect.physics, entry.effect.parameters[index].name) is not None, entry.key
    assert all(size.source and size.assumed == size.source.startswith("assumed") for size in SIZES)


def test_a_size_of_zero_is_refused_with_its_place() -> None:
    with pytest.raises(InputError, match=r"model_error\.sizes\.leg_backlash.*prior size 0.*without"):
        Assumptions().with_sizes({"leg_backlash": 0.0})


def test_unknown_names_are_refused_with_the_nearest() -> None:
    with pytest.raises(InputError, match="leg_backlash"):
        Assumptions().with_sizes({"leg_backlsh": 1e-6})
    with pytest.raises(InputError, match="gap_m"):
        Assumptions().with_sizes({"leg_backlash": {"gap": 1e-6}})
    with pytest.raises(InputError, match=r"model_error\.physics.*joint_backlash"):
        physics_of_problem(problem("bipod"), Assumptions(physics=frozenset({"joint_backlash"})))


def test_nothing_left_to_consider() -> None:
    only = Assumptions(physics=frozenset({"leg_backlash"}), without=frozenset({"leg_backlash"}))
    with pytest.raises(InputError, match=r"no physics is left"):
        physics_of_problem(problem("bipod"), only)


def test_a_size_of_the_configuration_replaces_that_of_the_table() -> None:
    changed = Assumptions().with_sizes({"leg_backlash": 5e-6})
    size = size_of("leg_backlash", "gap_m", changed.sizes)
    assert size is not None
    assert size.value == 5e-6
    assert not size.assumed


def test_another_calibration_is_refused() -> None:
    with pytest.raises(InputError, match="elastostatic"):
        ModelErrorImpact(problem("hexapod-geometric"))

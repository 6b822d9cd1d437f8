"""What MEIR assumes, and what it refuses."""

from pathlib import Path

import pytest
from tests.cases import robot
from tests.chain.arm_rows import six_axis
from tests.chain.arms import read_arm
from tests.chain.bodies import BODY
from tests.chain.kinds import KINDS
from tests.model_error.problems import problem

from expdesign.chain.effect import Effect
from expdesign.chain.effects.legs.backlash import LegBacklash
from expdesign.errors import InputError
from expdesign.model_error.impact import ModelErrorImpact
from expdesign.model_error.left_out import physics_of_problem
from expdesign.model_error.prior_sizes import SIZES, size_of
from expdesign.model_error.settings import Assumptions
from expdesign.model_error.words import unsized_sentence


@pytest.mark.parametrize("name", ["hexapod-h1", "bipod", "ur5"])
def test_every_parameter_has_a_size_with_a_source(name: str) -> None:
    for entry in physics_of_problem(problem(name), Assumptions()):
        for index in entry.free:
            assert size_of(entry.effect.physics, entry.effect.parameters[index].name) is not None, entry.key
    assert all(size.source and size.assumed == size.source.startswith("assumed") for size in SIZES)


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_every_shipped_effect_has_a_size_on_every_kind_of_robot(kind: type[Effect], tmp_path: Path) -> None:
    here = (robot("bipod"), robot("H1"), six_axis(), read_arm(tmp_path), BODY)
    for machine in here:
        for component in kind.components(machine):
            for variant in kind.variants(machine):
                try:
                    effect = kind.from_text(machine, str(component), str(variant))
                except ValueError:  # the component does not have this form
                    continue
                named = [parameter.name for parameter in effect.parameters if not parameter.shape]
                assert not [name for name in named if size_of(effect.physics, name) is None], machine.kind


class _Nameless(LegBacklash):
    """As somebody else would add it: of a physics that no table has."""

    physics = "wear"


def test_physics_without_a_size_is_left_out_and_said(monkeypatch: pytest.MonkeyPatch) -> None:
    others = [kind for kind in KINDS if kind.physics in ("leg_coupling", "leg_backlash")]
    for module in ("left_out", "settings"):
        place = f"expdesign.model_error.{module}.implementations"
        monkeypatch.setattr(place, lambda *_: [*others, _Nameless])
    found = ModelErrorImpact(problem("bipod"), Assumptions())
    assert found.unsized == ("wear",)
    assert {entry.effect.physics for entry in found.physics} == {"leg_coupling", "leg_backlash"}
    assert "`wear`" in unsized_sentence(found.unsized)
    stated = ModelErrorImpact(problem("bipod"), Assumptions().with_sizes({"wear": {"gap_m": 1e-6}}))
    assert not stated.unsized
    assert "wear" in {entry.effect.physics for entry in stated.physics}


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

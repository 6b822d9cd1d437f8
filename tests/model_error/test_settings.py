"""What MEIR assumes, what it refuses, and the non-centrality at which a χ² test has its power."""

from pathlib import Path

import numpy as np
import pytest
from scipy.stats import chi2, norm

from expdesign.assurance.model_error.meir import Meir
from expdesign.assurance.model_error.settings import Assumptions
from expdesign.chain.declaration import TYPICAL, Declaration, Size
from expdesign.chain.effect import Effect
from expdesign.chain.effects.legs.transmission import LegBacklash
from expdesign.chain.ports.law import port_classes
from expdesign.errors import InputError
from tests.cases import robot
from tests.chain.arm_rows import six_axis
from tests.chain.arms import read_arm
from tests.chain.bodies import BODY
from tests.chain.kinds import KINDS
from tests.model_error.problems import problem


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_every_shipped_effect_declares_itself_with_sizes_on_every_kind_of_robot(
    kind: type[Effect], tmp_path: Path
) -> None:
    declared = kind.declared
    assert declared.left_out
    assert declared.phrase
    assert declared.usually
    assert declared.port in port_classes()
    assert all(size.source for size in declared.sizes)
    here = (robot("bipod"), robot("H1"), six_axis(), read_arm(tmp_path), BODY)
    for machine in here:
        for component in kind.components(machine):
            for variant in kind.variants(machine):
                try:
                    effect = kind.from_text(machine, str(component), str(variant))
                except ValueError:  # the component does not have this form
                    continue
                named = [parameter for parameter in effect.parameters if not parameter.shape]
                assert not [p.name for p in named if effect.size(p).source == TYPICAL], machine.kind
                assert effect.port_name in port_classes()


class _Nameless(LegBacklash):
    """As somebody else would add it: it declares nothing."""

    physics = "wear"
    declared = Declaration()


def test_physics_that_declares_nothing_is_as_large_as_its_parameters_are_typically(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    others = [kind for kind in KINDS if kind.physics in ("leg_coupling", "leg_backlash")]
    monkeypatch.setattr("expdesign.assurance.model_error.physics.effect_classes", lambda: [*others, _Nameless])
    monkeypatch.setattr("expdesign.assurance.model_error.settings.effect_classes", lambda: [*others, _Nameless])
    found = Meir(problem("bipod"), Assumptions())
    sizes = dict(zip([entry.key[0] for entry in found.physics], found.deviations, strict=True))
    assert sizes["wear"] == 1e-6 != sizes["leg_backlash"]
    stated = Meir(problem("bipod"), Assumptions(sizes={"wear": {"gap_m": 3e-6}}))
    assert dict(zip([entry.key[0] for entry in stated.physics], stated.deviations, strict=True))["wear"] == 3e-6
    assert _Nameless.from_text(robot("bipod"), "leg 1", "middle").phrase == "wear (leg 1)"


def test_a_declared_size_is_a_positive_number() -> None:
    with pytest.raises(ValueError, match=r"gap_m.*prior size 0"):
        Size("gap_m", 0.0, "a catalogue")


def test_a_parameter_that_an_effect_does_not_have_is_refused_with_the_nearest() -> None:
    with pytest.raises(InputError, match="gap_m"):
        Assumptions(sizes={"leg_backlash": {"gap": 1e-6}})


def test_a_size_of_the_configuration_replaces_that_of_the_table() -> None:
    changed = Assumptions(sizes={"leg_backlash": 5e-6})
    effect = LegBacklash.from_text(robot("bipod"), "leg 1", "middle")
    assert changed.size(effect, effect.parameters[0]).value == 5e-6
    assert not changed.size(effect, effect.parameters[0]).assumed
    assert Assumptions().size(effect, effect.parameters[0]).value == 1.5e-6


def test_one_degree_of_freedom_is_the_two_sided_test_of_a_mean() -> None:
    # P(|z + √λ| > z_{0.995}) = 0.8; the other tail adds nothing that shows.
    root = norm.ppf(0.995) + norm.ppf(0.8)
    assert Assumptions().noncentrality(1) == pytest.approx(root**2, rel=1e-4)


@pytest.mark.parametrize("dof", [1, 3, 18])
def test_simulated_power(dof: int) -> None:
    shift = np.zeros(dof)
    shift[0] = np.sqrt(Assumptions().noncentrality(dof))
    drawn = np.random.default_rng(dof).normal(size=(40_000, dof)) + shift
    power = ((drawn**2).sum(axis=1) > chi2.ppf(0.99, dof)).mean()
    assert abs(power - 0.8) < 4.0 * np.sqrt(0.8 * 0.2 / 40_000)


@pytest.mark.parametrize(("level", "power"), [(0.0, 0.8), (0.5, 0.4), (0.01, 1.0)])
def test_tests_that_do_not_exist(level: float, power: float) -> None:
    with pytest.raises(InputError, match=r"model_error.*does not exist"):
        Assumptions(level, power)

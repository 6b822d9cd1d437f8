"""A law has the name of the physics whose port and inputs it has, whatever its form."""

import casadi as ca
import numpy as np
import pytest

from expdesign.chain.chain import Chain
from expdesign.chain.component import BASE, ENVIRONMENT, PAYLOAD, PLATFORM, Component, Part
from expdesign.chain.effect import Effect
from expdesign.chain.ports.features import basis_of
from expdesign.chain.ports.law import Law, LawForm
from expdesign.chain.ports.port import Channel
from expdesign.chain.ports.quantities import Quantity
from expdesign.chain.ports.words import FORMS
from expdesign.plugins import implementations
from tests.cases import robot
from tests.chain.bodies import BODY

LEG = Component(Part.LEG, 1)
EFFORT, LENGTH, TIME, WARMING = Quantity("effort"), Quantity("length"), Quantity("clock"), Quantity("warming")
SLOW, STOP, CARRIED = Quantity("lag", 0, (60.0, 1.0)), Quantity("stop", 0, (5.0,)), Quantity("carried")
EVERY = frozenset(kind.physics for kind in implementations("expdesign.chain.effects", Effect))


def law(
    port: str,
    component: Component,
    kind: str,
    seen: Quantity,
    amplitude: Quantity | None = None,
    kernel: str = "linear",
) -> Law:
    """A law of one channel on a hexapod."""
    basis = basis_of(kernel, np.ones(1), np.linspace(-1.0, 1.0, 5)[:, None], 1)
    assert basis is not None
    channel = Channel(0, 0, (seen,), amplitude)
    form = LawForm(port, component, kind, (channel,), basis, np.zeros((1, 1)), np.ones((1, 1)), 1.0)
    return Law(robot("H1"), form, 1)


@pytest.mark.parametrize(
    ("one", "name"),
    [
        (law("actuators", LEG, "creep", SLOW), "creep"),
        (law("actuators", LEG, "friction", STOP), "friction_hysteresis"),
        (law("actuators", LEG, "friction", LENGTH, STOP), "friction_hysteresis"),
        (law("actuators", LEG, "bracket", Quantity("pair", 0, (1.0,))), "leg_coupling"),
        (law("actuators", LEG, "force law", EFFORT), "leg_nonlinear_stiffness"),
        (law("actuators", LEG, "step at zero", Quantity("effort_sign")), "leg_backlash"),
        (law("actuators", LEG, "periodic", LENGTH), "encoder_periodic_error"),
        (law("actuators", LEG, "offset", WARMING), "thermal_drift"),
        (law("actuators", LEG, "offset", TIME), "thermal_drift"),
        (law("environment", ENVIRONMENT, "drift", TIME), "thermal_drift"),
        (law("platform", PLATFORM, "force law", CARRIED), "platform_compliance"),
        (law("base", BASE, "compliance", Quantity("ground"), Quantity("ground")), "base_compliance"),
        # What is always the same depends on nothing but the load.
        (law("load direction", PAYLOAD, "load", TIME, kernel="constant"), "load_direction_tilt"),
        (law("centre of mass", PAYLOAD, "load", TIME, kernel="constant"), "payload_com_offset"),
        (law("payload", PAYLOAD, "load", Quantity("weight"), Quantity("effort", 6)), "payload_mass_error"),
        (law("load direction", PAYLOAD, "load", TIME), Law.physics),
        # What a leg does with its length, and a spring that changes with time, have no name.
        (law("actuators", LEG, "offset", LENGTH), Law.physics),
        (law("actuators", LEG, "compliance", LENGTH, EFFORT), Law.physics),
        (law("actuators", LEG, "compliance", TIME, EFFORT), Law.physics),
        (law("platform", PLATFORM, "compliance", Quantity("pose"), CARRIED), Law.physics),
        (law("platform", PLATFORM, "friction", STOP), Law.physics),
    ],
    ids=lambda value: (
        " ".join([value.form.port, value.form.kind, *(q.kind for q in value.form.depends_on)])
        if isinstance(value, Law)
        else value
    ),
)
def test_a_law_has_the_name_of_its_port_and_inputs(one: Law, name: str) -> None:
    assert one.physics_among(EVERY) == name
    assert one.physics_among(EVERY - {name}) == Law.physics


def test_declared_laws_are_kinds_that_there_are() -> None:
    for kind in implementations("expdesign.chain.effects", Effect):
        assert set(kind.declared.laws) <= set(FORMS), kind.identifier
        assert kind.declared.port or not kind.declared.laws, kind.identifier


@pytest.mark.parametrize("body", [False, True])
def test_every_kind_of_physics_says_where_it_acts(body: bool) -> None:
    """Also where recordings decide which forms there are, as of what a body stands on."""
    here = BODY if body else robot("H1")
    asked = [
        kind.port_at(component)
        for kind in implementations("expdesign.chain.effects", Effect)
        for component in kind.components(here)
    ]
    assert len(asked) > 3
    assert all(isinstance(port, str) for port in asked)


def test_a_law_that_is_always_the_same_asks_no_time_of_points() -> None:
    one = law("load direction", PAYLOAD, "load", TIME, kernel="constant")
    chain = Chain(robot("H1"), (one,))
    row = chain.row_symbols()
    reading, _ = chain.expression(row, ca.SX.zeros(0), ca.SX.sym("theta", len(chain.parameters)))
    assert not ca.depends_on(reading, row.clock)

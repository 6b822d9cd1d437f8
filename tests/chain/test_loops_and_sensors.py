"""Joints that open and close again, and force sensors: answers that are known without the chain."""

import numpy as np
import pytest

from expdesign.chain.chain import Chain
from expdesign.chain.component import PAYLOAD, Component, Part
from expdesign.chain.effect import Effect
from expdesign.chain.effects.actuators.actuators import SelfCentring
from expdesign.chain.effects.load.payload import ForceSensor
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.row import row_data
from expdesign.diagnosis.diagnose import diagnose
from tests.cases import robot
from tests.chain.places import WRENCH, rows
from tests.chain.test_known_answers import ROBOT, base, forces, in_legs, one_series, predicted
from tests.identification.experiments import read
from tests.oracle import Array

LEG = 1
UP_AND_DOWN = [0.0, 0.3, 0.6, 1.0, 0.8, 0.6, 0.3, 0.0, -0.6, -1.0, -0.6, 0.0]


def opening(**at: float) -> tuple[Array, Array, Array]:
    """Forces of a leg, its elongations and the base model's, where it opens at 0.5 of the largest force.

    `at`: friction as a share of the largest force, and the ratio.
    """
    frame = one_series(UP_AND_DOWN)
    force = forces(frame)[:, LEG]
    largest = float(np.abs(force).max())
    one = SelfCentring(robot(ROBOT), Component(Part.LEG, LEG + 1), SelfCentring.forms[0])
    found = predicted(one, [at["ratio"], 0.5 * largest, at["friction"] * largest], frame)
    return force / largest, in_legs(found, frame)[:, LEG], in_legs(base(frame), frame)[:, LEG]


def test_a_joint_without_friction_is_a_spring_of_two_slopes_and_dissipates_nothing() -> None:
    force, found, linear = opening(ratio=0.7, friction=0.0)
    beyond = np.sign(force) * np.maximum(np.abs(force) - 0.5, 0.0)
    largest = linear[np.abs(force).argmax()] / force[np.abs(force).argmax()]
    np.testing.assert_allclose(found, linear + 0.7 * largest * beyond, rtol=0.0, atol=1e-9 * abs(largest))
    assert np.trapezoid(force, found) == pytest.approx(0.0, abs=1e-9 * abs(largest))


def test_it_closes_later_than_it_opens_and_always_returns() -> None:
    """Half the largest force opens it, friction of a tenth holds it open until three tenths."""
    force, found, linear = opening(ratio=0.7, friction=0.1)
    compliance = linear[3] / force[3]
    sign = np.sign(force[3])
    open_by = (found - linear) / (0.7 * compliance)
    # Up to 1: F − 0.5; back to 0.8: held at 0.5 = u(0.8); 0.6 and 0.3 along F − 0.3; the same on the other side.
    expected = sign * np.array([0.0, 0.0, 0.1, 0.5, 0.5, 0.3, 0.0, 0.0, -0.1, -0.5, -0.3, 0.0])
    np.testing.assert_allclose(open_by, expected, rtol=0.0, atol=1e-9)
    assert abs(np.trapezoid(force, found)) > 0.0


def test_loads_that_do_not_open_it_do_nothing() -> None:
    frame = one_series([0.0, 0.4, -0.4, 0.2])
    one = SelfCentring(robot(ROBOT), Component(Part.ALL_LEGS), SelfCentring.forms[0])
    largest = float(np.abs(forces(frame)).max())
    np.testing.assert_array_equal(predicted(one, [2.0, 1.01 * largest, 0.3 * largest], frame), base(frame))


@pytest.mark.parametrize("axis", range(6))
def test_a_sensor_that_is_wrong_by_a_share_is_another_wrench(axis: int) -> None:
    """Of the change of the load; the base model under the load that really acts."""
    name = robot(ROBOT).coordinates.wrench[axis]
    frame = rows(ROBOT, WRENCH)
    one = ForceSensor.from_text(robot(ROBOT), "payload", name.rsplit("_", 1)[0])
    true = frame.assign(**{name: 1.03 * frame[name], f"abs_{name}": 1.03 * frame[f"abs_{name}"]})
    expected = base(true)
    np.testing.assert_allclose(predicted(one, [0.03], frame), expected, rtol=0.0, atol=1e-12 * np.abs(expected).max())


def test_an_error_that_grows_is_that_of_the_whole_load_less_that_of_the_reference() -> None:
    frame, name = rows(ROBOT, WRENCH), "fz_N"
    now, before = frame["abs_fz_N"], frame["abs_fz_N"] - frame["fz_N"]
    true = frame.assign(fz_N=frame["fz_N"] + 0.02 * (now * now.abs() - before * before.abs()) / 100.0)
    one = ForceSensor.from_text(robot(ROBOT), "payload", f"{name[:2]} growing")
    expected = base(true)
    np.testing.assert_allclose(predicted(one, [0.02], frame), expected, rtol=0.0, atol=1e-12 * np.abs(expected).max())


def test_weights_are_no_force_sensor() -> None:
    frame = rows(ROBOT)
    assert ForceSensor.places(robot(ROBOT), read(frame, robot(ROBOT))) == []


def _recorded(one: Effect, parameters: list[float], seed: int) -> Recordings:
    """Series that load and unload by free wrenches, with noise; the last three are held out."""
    here, generator = robot(ROBOT), np.random.default_rng(seed)
    frame = rows(ROBOT, WRENCH, series=12, loads=8)
    wrench = list(here.coordinates.wrench)
    frame = frame.drop(columns=[f"abs_{name}" for name in wrench])
    steps = np.tile([0.0, 0.5, 1.0, 1.4, 1.1, 0.7, 0.3, -0.8], 12)
    each = np.repeat(frame[wrench].to_numpy()[::8], 8, axis=0)
    frame[wrench] = steps[:, None] * each
    frame = frame.assign(split=np.where(frame["series"] > 9, "test", "train"))
    recordings = read(frame, here)
    chain = Chain(here, (one,))
    exact = chain.predict(row_data(recordings, here), np.concatenate([np.ones(chain.compliances), parameters]))
    scatter = generator.standard_normal(exact.shape) * np.array(recordings.deviations)
    return type(recordings)(**{**vars(recordings), "deflections": exact + scatter})


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "component", "variant", "sizes"),
    [
        (SelfCentring, Component(Part.LEG, 3), "flag", (2.0, 0.35, 0.1)),
        (ForceSensor, PAYLOAD, "fx", (0.3,)),
        (ForceSensor, PAYLOAD, "fy growing", (0.3,)),
    ],
    ids=lambda value: getattr(value, "__name__", str(value)),
)
def test_it_is_named_and_predicts_rows_that_were_held_out(
    kind: type[Effect], component: Component, variant: str, sizes: tuple[float, ...]
) -> None:
    one = kind.from_text(robot(ROBOT), str(component), variant)
    frame = rows(ROBOT, WRENCH, series=12, loads=8)
    largest = float(np.abs(forces(frame)[:, 2]).max())
    parameters = [sizes[0], *(size * largest for size in sizes[1:])]
    recordings = _recorded(one, parameters, seed=5)
    found = diagnose(robot(ROBOT), recordings)
    assert {(finding.physics, finding.component) for finding in found.findings} == {(one.physics, str(component))}
    assert found.errors.test_after < 1.1
    assert found.errors.test_before > 1.5

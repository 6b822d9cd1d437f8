"""What must hold for every effect at every place, also for those that nobody has written yet."""

import re
import string
from dataclasses import replace
from itertools import product
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from expdesign.chain.chain import Chain
from expdesign.chain.component import INSTRUMENT, Part, component_from_text
from expdesign.chain.effect import Effect
from expdesign.chain.effects.instrument.frame import FrameWander
from expdesign.chain.effects.joints.geometry import CalibratedGeometryError
from expdesign.chain.effects.joints.readings import JointHarmonics
from expdesign.chain.row import row_data
from expdesign.diagnosis.findings import reported
from expdesign.diagnosis.library import library
from expdesign.estimation.fit import summarise
from tests.cases import robot
from tests.chain import bodies
from tests.chain.arm_rows import arm_rows, six_axis
from tests.chain.arms import configurations, read_arm, recordings_of
from tests.chain.kinds import KINDS, kind_for
from tests.chain.places import (
    ARM,
    BEYOND_LEGS,
    ON_LEGS,
    PAYLOAD,
    WRENCH,
    Place,
    away_from_neutral,
    machine,
    one_of_each,
    places,
    recordings,
    rows,
)
from tests.fitting import data_of
from tests.identification.experiments import read
from tests.oracle import Array

PLACES_AND_LOADS = [*product(ON_LEGS, (PAYLOAD, WRENCH)), *((place, PAYLOAD) for place in BEYOND_LEGS)]
every_place_and_load = pytest.mark.parametrize(("place", "load"), PLACES_AND_LOADS, ids=str)
each_kind = pytest.mark.parametrize("place", ON_LEGS, ids=str)
each_kind_anywhere = pytest.mark.parametrize("place", [*ON_LEGS, *BEYOND_LEGS], ids=str)

# file-formats.md, diagnosis.json: names that are fixed, where they differ by form with the form.
FIXED = {
    ("payload_com_offset", "payload", ""): {"com_dx_m", "com_dy_m", "com_dz_m"},
    ("payload_mass_error", "payload", "newton"): {"relative_mass_error"},
    ("load_direction_tilt", "payload", ""): {"tilt_x_rad", "tilt_y_rad"},
    ("leg_backlash", "leg", ""): {"gap_m"},
    ("friction_hysteresis", "leg", ""): {"friction_N"},
    ("creep", "leg", ""): {"creep_ratio", "tau_s"},
    ("thermal_drift", "leg", ""): {"alpha_per_K"},
    ("passive_joint_stiffness", "leg", ""): {"joint_Nm_per_rad"},
    ("encoder_periodic_error", "leg", ""): {"amplitude_m", "pitch_m", "phase_rad"},
    ("instrument_misalignment", "instrument", ""): {"rot_x_rad", "rot_y_rad", "rot_z_rad"},
    ("instrument_scale", "instrument", ""): {"scale_x", "scale_y", "scale_z"},
}
IDENTIFIERS = {
    "payload_com_offset", "payload_mass_error", "load_direction_tilt", "platform_compliance", "base_compliance",
    "passive_joint_compliance", "passive_joint_stiffness", "leg_nonlinear_stiffness", "leg_backlash", "joint_backlash",
    "friction_hysteresis", "creep", "thermal_drift", "leg_coupling", "geometric_stiffness", "joint_position_error",
    "instrument_misalignment", "instrument_scale", "encoder_periodic_error", "link_compliance", "joint_compliance",
}  # fmt: skip


def base_model(name: str, load: str, compliance: Array | None = None) -> Array:
    """J̌·(c∘JᵀF) of every row, without the chain."""
    here, points = machine(name), recordings(name, load)
    jacobians = here.jacobians(points.configurations)
    force = np.einsum("nij,ni->nj", jacobians.forward, points.wrenches)
    elongation = force * here.compliance * (1.0 if compliance is None else compliance)
    return np.einsum("nij,nj->ni", jacobians.pose, elongation)


@pytest.mark.parametrize(
    ("place", "load"),
    [*PLACES_AND_LOADS, *((place, PAYLOAD) for place in one_of_each("moving-xyz"))],  # and the other orientation
    ids=str,
)
def test_a_neutral_effect_leaves_the_base_model(place: Place, load: str) -> None:
    chain = place.chain
    generator = np.random.default_rng(3)
    values = chain.start()
    values[: chain.compliances] = generator.uniform(0.5, 2.0, chain.compliances)
    found = chain.predict(row_data(recordings(place.name, load), place.robot), values)
    expected = base_model(place.name, load, values[: chain.compliances])
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-12 * np.abs(expected).max())


@every_place_and_load
def test_sensitivities_are_central_differences(place: Place, load: str) -> None:
    """Per parameter, to 1e-5 of its largest sensitivity, where friction and play are away from their kinks."""
    chain = place.chain
    data = row_data(recordings(place.name, load), place.robot)
    values, step = away_from_neutral(chain), 1e-5 * chain.scales()
    predicted, exact = chain.predict_with_sensitivities(data, values)
    np.testing.assert_allclose(predicted, chain.predict(data, values), rtol=1e-13, atol=0.0)
    largest = np.maximum(np.abs(exact).max(axis=(0, 1)), 1e-300)
    away = np.abs(chain.sensitivities(data, values) - exact)
    assert (away <= 1e-10 * largest + 1e-15 * np.abs(exact).max()).all()  # one way may round where the other has zero
    for index in range(len(values)):
        ahead, back = values.copy(), values.copy()
        ahead[index] += step[index]
        back[index] -= step[index]
        slope = (chain.predict(data, ahead) - chain.predict(data, back)) / (ahead[index] - back[index])
        rounding = 1e-14 * np.abs(predicted).max() / step[index]
        largest = np.abs(exact[..., index]).max()
        np.testing.assert_allclose(slope, exact[..., index], rtol=0.0, atol=1e-5 * largest + rounding)


@each_kind
def test_away_from_neutral_it_does_something_that_no_compliances_do(place: Place) -> None:
    """The directions that an effect adds are not all those of the legs' compliances; nothing pulls on a bipod that
    only ever carries weights, so that its loads are free here.
    """
    chain = place.chain
    points = recordings(place.name, PAYLOAD if place.kind.physics.startswith("payload") else WRENCH)
    _, sensitivities = chain.predict_with_sensitivities(row_data(points, place.robot), away_from_neutral(chain))
    matrix = sensitivities.reshape(-1, len(chain.parameters)) * chain.scales()
    base, own = np.split(matrix, [chain.compliances], axis=1)
    left = own - base @ np.linalg.lstsq(base, own, rcond=None)[0]
    assert np.linalg.norm(left) > 1e-4 * np.linalg.norm(own) > 0.0


@each_kind
def test_predictions_are_finite_at_the_bounds(place: Place) -> None:
    chain = place.chain
    data = row_data(recordings(place.name), place.robot)
    far = chain.start() - 1e3 * chain.scales(), chain.start() + 1e3 * chain.scales()
    low, high = (np.clip(limit, *chain.bounds()) for limit in far)
    for limit in (low, high):
        settings = [limit]
        for index in range(chain.compliances, len(limit)):
            settings.append(chain.start())
            settings[-1][index] = limit[index]
        for values in settings:
            predicted, sensitivities = chain.predict_with_sensitivities(data, values)
            assert np.isfinite(predicted).all()
            assert np.isfinite(sensitivities).all()


@each_kind_anywhere
def test_its_starts_are_shapes_of_nothing(place: Place) -> None:
    """Whatever shape a search starts from, the effect is still neutral there, and within its bounds."""
    chain, points = place.chain, recordings(place.name)
    effect = chain.effects[0]
    starts = effect.starts(points)
    low, high = chain.bounds()
    data, expected = row_data(points, place.robot), base_model(place.name, PAYLOAD)
    for start in starts[:: max(1, len(starts) // 5)]:
        values = np.concatenate([np.ones(chain.compliances), start])
        assert ((values >= low) & (values <= high)).all()
        found = chain.predict(data, values)
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-12 * np.abs(expected).max())


@each_kind_anywhere
def test_people_get_a_sentence_and_parameters_by_their_fixed_names(place: Place) -> None:
    chain, points = place.chain, recordings(place.name)
    effect = chain.effects[0]
    fitted = summarise(chain, data_of(points, place.robot), away_from_neutral(chain))
    values = reported(effect, fitted, chain.slices[0], 1.0)
    for name, (estimate, low, high) in values.items():
        assert set(name) <= set(string.ascii_letters + string.digits + "_")
        assert low <= estimate <= high
    sentence = effect.sentence(values)
    assert sentence[0] == sentence[0].upper()
    assert sentence.endswith(".")
    assert not {"nan", "inf"} & set(sentence.split())
    for (physics, component, variant), names in FIXED.items():
        here = str(effect.component).removeprefix("all ").startswith(component)
        form = str(effect.variant)
        here = here and form.endswith(variant) and (bool(variant) or form not in ("forgotten", "every"))
        timed = physics == "thermal_drift" and form == "time"
        if effect.physics == physics and here and not timed:
            wanted = names if place.robot.coordinates.n > 2 else _in_the_plane(names)
            assert wanted <= set(values)


def test_sentences_hold_values_with_their_intervals_in_the_units_of_the_place() -> None:
    play = kind_for(robot("irregular"), recordings("irregular"), "leg_backlash")
    said = play.from_text(robot("irregular"), "leg 3", "middle").sentence({"gap_m": (1.5e-6, 1.2e-6, 1.8e-6)})
    assert said == "Leg 3 has 1.5 (1.2 to 1.8) µm of play."
    creep = kind_for(robot("irregular"), recordings("irregular"), "creep").from_text(robot("irregular"), "all legs")
    values = {"creep_ratio": (0.02, 0.015, 0.025), "tau_s": (120.0, 90.0, 150.0), "applied": (0.5, 0.0, 1.0)}
    assert creep.sentence(values) == (
        "Under constant load all legs creep by a further 2.0 % (1.5 to 2.5 %), time constant 120 s."
    )
    bearing = kind_for(machine(ARM), recordings(ARM), "joint_compliance").from_text(machine(ARM), "joint 2")
    said = bearing.sentence({"lateral_rad_per_Nm": (2e-6, 1e-6, 3e-6)})
    assert said == "The bearing of joint 2 tilts across its axis by 2 (1 to 3) µrad per N·m."


def _in_the_plane(names: set[str]) -> set[str]:
    if "tilt_x_rad" in names or "rot_x_rad" in names:
        return {name.replace("_x_", "_z_") for name in names if "_x_" in name}
    return {name for name in names if name != "scale_z"}


def test_a_sine_and_a_cosine_are_reported_as_amplitude_and_phase() -> None:
    """Amplitude and phase of a sine and a cosine."""
    place = next(p for p in ON_LEGS if p.kind.physics == "encoder_periodic_error")
    effect = place.effect()
    theta = ca.SX.sym("theta", 3)
    expressions = ca.vertcat(*effect.reported(theta).values())
    found = np.array(ca.Function("f", [theta], [expressions])([3e-6, 4e-6, 2e-3])).ravel()
    np.testing.assert_allclose(found, [5e-6, 2e-3, np.arctan2(4.0, 3.0)], rtol=1e-12)
    # sin(x + φ)·A = A·cos φ·sin x + A·sin φ·cos x
    x = np.linspace(0.0, 6.0, 7)
    np.testing.assert_allclose(
        3e-6 * np.sin(x) + 4e-6 * np.cos(x), found[0] * np.sin(x + found[2]), rtol=0.0, atol=1e-18
    )


@each_kind
def test_a_row_depends_on_the_rows_before_it_in_its_series_only(place: Place) -> None:
    chain = place.chain
    values = away_from_neutral(chain)
    frame = rows(place.name)
    whole = chain.predict(row_data(recordings(place.name), place.robot), values)
    # Later rows of its own series may be other ones, or none.
    for cut in (1, 6, 11):
        part = chain.predict(row_data(read(frame.iloc[:cut], place.robot), place.robot), values)
        np.testing.assert_allclose(part, whole[:cut], rtol=1e-12, atol=0.0)
    # The series at its side may have their rows in another order, under other loads and temperatures.
    other = frame.copy()
    own = other["series"] == 2
    for column in ("mass_kg", "leg1_degC"):
        other.loc[~own, column] = other.loc[~own, column].to_numpy()[::-1]
    found = chain.predict(row_data(read(other, place.robot), place.robot), values)
    np.testing.assert_allclose(found[own], whole[own], rtol=1e-12, atol=0.0)


@each_kind
def test_series_may_be_recorded_by_turns(place: Place) -> None:
    """Rows of the series between each other, in any order of the file: each series is the same as on its own."""
    values = away_from_neutral(place.chain)
    turns = np.argsort(np.tile(np.arange(4), 4), kind="stable")
    mixed = rows(place.name).iloc[turns].assign(sequence=np.arange(1, 17), time_s=40.0 * np.arange(16))
    shuffled = mixed.iloc[np.random.default_rng(0).permutation(16)]
    found = place.chain.predict(row_data(read(shuffled, place.robot), place.robot), values)
    for number in range(1, 5):
        own = (mixed["series"] == number).to_numpy()
        alone = place.chain.predict(row_data(read(mixed[own], place.robot), place.robot), values)
        np.testing.assert_allclose(found[own], alone, rtol=1e-12, atol=0.0)


def test_the_library_is_every_effect_at_every_place_once() -> None:
    for name in ("irregular", "bipod-unequal"):
        keys = [effect.key for effect in library(robot(name), recordings(name))]
        assert keys == [place.effect().key for place in places(name)]
        assert len(set(keys)) == len(keys)


@pytest.mark.parametrize("name", ["irregular", "bipod-unequal"])
def test_names_are_those_of_the_interface(name: str) -> None:
    """Physics is a word; components are parts that there are, with numbers of legs that there are."""
    for place in places(name):
        assert re.fullmatch(r"[a-z]+(_[a-z]+)*", place.kind.physics)
        assert component_from_text(str(place.component)) == place.component
        if place.component.part is Part.LEG:
            assert str(place.component) in robot(name).actuators


def test_every_physics_of_the_interface_is_in_the_library() -> None:
    assert {kind.physics for kind in KINDS} >= IDENTIFIERS


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.physics)
def test_every_effect_has_a_place_on_some_robot(kind: type[Effect], tmp_path: Path) -> None:
    arm, lift = six_axis(), read_arm(tmp_path)  # the latter stands on a sliding joint
    untimed = replace(recordings_of(lift, configurations(20, 1), np.zeros((20, 3))), time=None)
    deflections = read(arm_rows(arm), arm)
    positions = replace(deflections, marker=np.zeros(len(deflections), dtype=np.int64), markers=("ball",))
    assert (
        any(place.kind is kind for place in places("irregular"))
        or kind.places(bodies.BODY, bodies.recordings(lifting=True))
        or kind.places(arm, deflections)
        or kind.places(arm, positions)
        or kind.places(lift, untimed)
        or kind.places(robot("irregular"), replace(recordings("irregular", WRENCH), poses=True))
        or kind in (CalibratedGeometryError, JointHarmonics, FrameWander)  # which a calibration puts there itself
    )


def test_effects_together_are_neutral_together() -> None:
    """One of every physics on one chain: still the base model; sensitivities still exact."""
    chosen = {place.kind.physics: place for place in places("irregular")}
    chain = Chain(robot("irregular"), tuple(place.effect() for place in chosen.values()))
    data = row_data(recordings("irregular"), robot("irregular"))
    expected = base_model("irregular", PAYLOAD)
    np.testing.assert_allclose(
        chain.predict(data, chain.start()), expected, rtol=0.0, atol=1e-12 * np.abs(expected).max()
    )
    values = away_from_neutral(chain)
    direction = chain.scales() * np.random.default_rng(0).standard_normal(len(values))
    _, exact = chain.predict_with_sensitivities(data, values)
    ahead, back = (chain.predict(data, values + sign * 1e-6 * direction) for sign in (1.0, -1.0))
    slope = (ahead - back) / 2e-6
    np.testing.assert_allclose(exact @ direction, slope, rtol=0.0, atol=1e-5 * np.abs(slope).max())


def test_without_the_instrument_the_chain_ends_at_the_platform() -> None:
    chosen = [p for p in places("irregular") if str(p.component) in ("instrument", "leg 3")]
    data = row_data(recordings("irregular"), robot("irregular"))
    for place in chosen:
        effects = (place.effect(),)
        read_chain, platform = Chain(place.robot, effects), Chain(place.robot, effects, instrument=False)
        values = away_from_neutral(read_chain)
        same = np.array_equal(read_chain.predict(data, values), platform.predict(data, values))
        assert same == (place.component != INSTRUMENT)

"""What acts at a target: errors of the weights that were recorded stay with them, a payload of its own has its own."""

from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import expdesign as xd
from expdesign.assurance.acceptance.planned import own_payload
from expdesign.chain.chain import Chain
from expdesign.chain.recordings.points import points_from_table
from expdesign.chain.row import row_data
from expdesign.errors import InputError
from expdesign.estimation.compensation.compensate import compensate
from expdesign.estimation.compensation.prediction import chain_of
from expdesign.estimation.compensation.target_loads import TargetLoads
from expdesign.io.output import csv_text
from expdesign.io.table import parse_table
from tests.compensation.test_prediction import model_of
from tests.design.problems import HEXAPOD, plan_table, problem
from tests.diagnosis.samples import effect
from tests.identification.experiments import experiment

POSES = ["x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad"]
PAYLOAD = ["mass_kg", "com_x_m", "com_y_m", "com_z_m"]
OFFSET = np.array([2e-3, -1e-3, 3e-3])
"""m, of the centre of mass of the weights that were recorded."""


def targets(**columns: Any) -> pd.DataFrame:
    """Two targets with a payload each."""
    frame = pd.DataFrame([[1, 1, 0.01, 0, 0, 0, 0.05, 0, 25.0, 0.02, 0.01, 0.15],
                          [2, 2, 0, -0.01, 0, 0.03, 0, 0.1, 20.0, 0.0, 0.05, 0.1]],
                         columns=["sequence", "series", *POSES, *PAYLOAD])  # fmt: skip
    return frame.assign(**columns)


def read(frame: pd.DataFrame, model: Any) -> tuple[Any, TargetLoads]:
    table, robot = parse_table(csv_text(frame), "targets.csv"), model.chain.robot
    return points_from_table(table, robot), TargetLoads.of_table(table, robot.coordinates)


def with_offset() -> tuple[Any, Any]:
    """A model in which the recorded weights' centre of mass is off, and the same without."""
    here, offset = experiment("H1", 1).robot, effect("H1", "payload_com_offset", "payload")
    chain = Chain(here, (offset,))
    compliance = np.linspace(0.8, 1.2, 6)
    return model_of(chain, np.r_[compliance, OFFSET], 1e-6 * np.eye(9)), model_of(Chain(here), compliance)


def test_an_error_of_the_weights_moves_only_targets_that_carry_them() -> None:
    """By as much as a payload whose centre of mass is there."""
    model, plain = with_offset()
    own, carried = (compensate(model, *read(targets(same_as=word), model)).commands for word in ("", "experiment"))
    np.testing.assert_allclose(own, compensate(plain, *read(targets(), plain)).commands, atol=1e-15)
    moved = targets()
    moved[PAYLOAD[1:]] += OFFSET
    np.testing.assert_allclose(carried, compensate(plain, *read(moved, plain)).commands, atol=1e-11)
    assert np.abs(carried - own).max() > 1e-7


def test_knowing_the_weights_error_better_does_not_help_a_target_with_a_payload_of_its_own() -> None:
    """Nor does it harm it: its uncertainty is that of the other parameters."""
    model, plain = with_offset()
    without = model_of(plain.chain, plain.values, 1e-6 * np.eye(6))
    own = compensate(model, *read(targets(), model)).deviations
    np.testing.assert_allclose(own, compensate(without, *read(targets(), without)).deviations, rtol=1e-12)


def test_the_errors_of_a_target_s_own_payload_are_in_its_uncertainty() -> None:
    """U² of the model and (D·L·σ)² of every component, here by finite differences of the load."""
    _, plain = with_offset()
    model = model_of(plain.chain, plain.values, 1e-6 * np.eye(6))
    stated = {"error_mass_kg": 0.2, "error_com_x_m": 1e-3, "error_com_y_m": 2e-3, "error_com_z_m": 5e-4}
    frame = targets(**stated)
    found, exact = compensate(model, *read(frame, model)), compensate(model, *read(targets(), model))
    chain, squares = chain_of(model, platform=True, from_command=True), exact.deviations**2
    for name, deviation in zip(PAYLOAD, stated.values(), strict=True):
        ends = []
        for sign in (0.5, -0.5):
            points, _ = read(targets(**{name: targets()[name] + sign * deviation}), model)
            ends.append(chain.predict(row_data(points, model.chain.robot), model.values))
        squares = squares + (ends[0] - ends[1]) ** 2
    np.testing.assert_allclose(found.deviations, np.sqrt(squares), rtol=1e-9)


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({"same_as": "campaign"}, "carries the weights of the `experiment`"),
        ({"error_mass_kg": 0.0}, "says nothing"),
        ({"error_mass_kg": 30.0}, "there is none or a smaller one"),
        ({"error_mass_kg": 0.1, "same_as": "experiment"}, "whose errors the recordings state"),
        ({"mass_kg": 0.0, "error_com_x_m": 1e-3}, "there is none or a smaller one"),
    ],
)
def test_errors_of_payloads_that_cannot_be(columns: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        read(targets(**columns), with_offset()[0])


CASE = {"experiment.load.gravity": ..., "experiment.measurements": 8, "model_error": {"physics": ["leg_coupling"]}}
OWN = {"targets.0.payload.std": {"mass_kg": 0.1, "com_m": [1e-3, 1e-3, 2e-3]}}
ANEW = {
    "experiment.load_error": [
        {"source": "com", "std": [1e-3, 1e-3, 2e-3], "shared": False},
        {"source": "direction", "std": [1e-3, 2e-3], "shared": False},
        {"source": "mass", "std": 0.1},
    ],
    "targets.0.payload.same_as": "experiment",
}


@pytest.mark.parametrize(
    "changes", [{}, OWN, ANEW], ids=["exact payloads", "a payload of its own", "weights hung on anew"]
)
def test_one_u_for_a_target_in_every_command(tmp_path: Path, changes: dict[str, Any]) -> None:
    """`identify` and `compensate` state it along the axes of the tolerances, to the last digits of a file."""
    case = problem(HEXAPOD, CASE | changes)
    plan = plan_table(case)
    recorded = xd.simulate(case, plan).frame
    identified = xd.identify(HEXAPOD["robot"], recorded, targets=case)
    assert identified.acceptance is not None
    commands = xd.compensate(identified, case).frame
    budget = identified.acceptance.budget
    expected = commands[[f"U_{name}" for name in POSES]].to_numpy()
    shown = np.isfinite(budget.tolerance)
    np.testing.assert_allclose(expected[shown], budget.expanded[shown], rtol=1e-9)
    own = {one.name: one.deviation for one in budget.contributions}.get("own payload")
    expected_own = own_payload(case)
    assert (own is not None) == (expected_own is not None) == bool(changes)
    if own is not None and expected_own is not None:
        # A plan has the stiffnesses and load errors that are declared, a fit those that the recordings show.
        np.testing.assert_allclose(expected_own.deviation[shown], own[shown], rtol=0.2)
        evaluated = xd.evaluate(case, plan).record["acceptance"]["targets"][0]["axes"][0]
        assert evaluated["budget"]["own payload"] == pytest.approx(expected_own.deviation[0, 0])


def test_what_recordings_showed_of_weights_and_gravity_is_applied_at_the_target(tmp_path: Path) -> None:
    """The robot is commanded to where it stands right under the weights as they are, on the base as it is."""
    errors = [{"source": "com", "std": [0.02, 0.02, 0.02]}, {"source": "direction", "std": [0.02, 0.02]}]
    changes = {"experiment.load_error": errors, "experiment.measurements": 8, "experiment.load.gravity": ...}
    case = problem(HEXAPOD, changes | {"targets.0.payload.same_as": "experiment"})
    robot = case.loaded.robot
    chain = Chain(
        robot, (effect("H1", "payload_com_offset", "payload"), effect("H1", "load_direction_tilt", "payload"))
    )
    values = np.r_[np.linspace(0.9, 1.1, 6), 0.02, -0.03, 0.01, 0.02, -0.01]
    truth = model_of(chain, values, np.zeros((11, 11)))
    plan = plan_table(case)
    recorded = xd.simulate(case, plan, noise=False, load_errors=False).frame
    table = parse_table(csv_text(recorded), "rec.csv")
    readings = chain.predict(row_data(points_from_table(table, robot), robot), values)
    recorded[list(robot.coordinates.deflection)] = readings[np.argsort(np.argsort(table.lines))]
    identified = xd.identify(HEXAPOD["robot"], recorded, targets=case)
    found = xd.compensate(identified, case)
    poses = found.frame[[f"target_{name}" for name in POSES]].set_axis(POSES, axis=1)
    wanted = pd.concat([found.frame[["sequence", "series", *PAYLOAD, "same_as"]], poses], axis=1)
    expected = compensate(truth, *read(wanted, truth))
    stiffness_alone = model_of(Chain(robot), values[:6], np.zeros((6, 6)))
    plain = compensate(stiffness_alone, *read(wanted.drop(columns="same_as"), truth))
    away = found.compensation.commands - expected.commands
    assert (np.abs(away) < 0.5 * found.corrections.expanded).all()
    assert (np.abs(plain.commands - expected.commands) > 2.0 * found.corrections.expanded).any()
    assert "applied at every target: the identified direction of gravity" in " ".join(found.scope)
    commanded = found.frame[POSES].to_numpy(dtype=float)
    predicted = xd.predict(identified, found.frame, platform=True).prediction
    np.testing.assert_allclose(commanded + predicted.deflections, poses.to_numpy(dtype=float), atol=1e-8)
    np.testing.assert_allclose(2.0 * predicted.deviations, found.corrections.expanded, rtol=1e-3)
    rehearsed = simulated(case, found.frame, model=identified)
    np.testing.assert_allclose(rehearsed, predicted.deflections, rtol=1e-3)
    campaign = simulated(case, recorded, model=identified)
    left = np.abs(campaign - recorded[list(robot.coordinates.deflection)].to_numpy(dtype=float))
    assert left.max() < 0.05 * np.abs(campaign).max()
    identified.save(tmp_path / "out")
    read_again = xd.compensate(tmp_path / "out" / "model.yaml", case)
    pd.testing.assert_frame_equal(read_again.frame, found.frame, rtol=1e-12)
    assert identified.acceptance is not None
    assert {"com", "direction"} <= {one.name for one in identified.acceptance.budget.contributions}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"targets.0.payload.std": {"mass_kg": 1e3}}, "larger than the mass"),
        ({"targets.0.payload.std": {"mass_kg": 0.1}, "targets.0.payload.same_as": "experiment"}, "load_error"),
    ],
)
def test_a_configuration_s_payloads_that_cannot_be(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        problem(HEXAPOD, changes)


def simulated(case: Any, frame: pd.DataFrame, **options: Any) -> Any:
    """Deflections (N, 6) of a table, without noise."""
    made = xd.simulate(case, frame, noise=False, **options).frame
    return made[["dx_m", "dy_m", "dz_m", "drx_rad", "dry_rad", "drz_rad"]].to_numpy(dtype=float)


def test_a_rehearsed_check_has_the_loads_of_its_targets() -> None:
    """The base of the campaign at all, its weights where they are carried, and a payload's own errors once for each."""
    sources = {
        "com": {"source": "com", "std": [0.02, 0.02, 0.02]},
        "direction": {"source": "direction", "std": [0.02, 0.02]},
        "wrench": {"source": "wrench", "std": [5.0] * 3 + [0.5] * 3, "shared": False},
    }
    change = {"experiment.load.gravity": ...}
    weights, base, each = (problem(HEXAPOD, change | {"experiment.load_error": [one]}) for one in sources.values())
    plain = targets()
    there = {f"target_{name}": plain[name] for name in POSES}
    exact = simulated(base, plain, load_errors=False)
    np.testing.assert_allclose(simulated(base, plain.assign(**there)), simulated(base, plain), rtol=1e-12)
    for case in (weights, each):
        np.testing.assert_allclose(simulated(case, plain.assign(**there)), exact, rtol=1e-12)
        carried = simulated(case, plain.assign(same_as=["experiment", ""], **there))
        np.testing.assert_allclose(carried[1], exact[1], rtol=1e-12)
        assert np.abs(carried[0] / exact[0] - 1.0).max() > 1e-3
    np.testing.assert_allclose(
        simulated(weights, plain.assign(same_as="experiment", **there)), simulated(weights, plain)
    )
    alike = pd.concat([plain.iloc[:1]] * 2).assign(sequence=[1, 2], series=[1, 2], error_mass_kg=0.5)
    alike = alike.assign(**{f"target_{name}": alike[name] for name in POSES})
    first, second = simulated(weights, alike)
    np.testing.assert_array_equal(first, second)
    ratio = first / exact[0]
    np.testing.assert_allclose(ratio, ratio[0], rtol=1e-9)
    assert 1e-4 < abs(ratio[0] - 1.0) < 0.1  # of 25 kg


def test_the_weights_of_a_seed_are_the_same_whatever_is_measured() -> None:
    """Also where errors that every measurement has for itself are declared before."""
    first = {"source": "wrench", "std": [5.0] * 3 + [0.5] * 3, "shared": False}
    shared = {"source": "mass", "std": 1.0}
    both, alone = (
        problem(HEXAPOD, {"experiment.load_error": errors, "experiment.load.gravity": ...})
        for errors in ([first, shared], [shared])
    )
    there = targets(same_as="experiment").assign(**{f"target_{name}": targets()[name] for name in POSES})
    plan = pd.concat([targets()] * 3).assign(sequence=range(1, 7), series=range(1, 7))
    campaign = simulated(alone, plan)
    assert np.abs(campaign / simulated(alone, plan, load_errors=False) - 1.0).min() > 1e-3
    np.testing.assert_allclose(simulated(alone, there), campaign[:2], rtol=1e-9)
    silent = deepcopy(both.config)
    silent["experiment"]["load_error"][0]["std"] = [1e-9] * 6
    hardly = problem(silent, {})
    np.testing.assert_allclose(simulated(hardly, there), simulated(alone, there), rtol=1e-6)


def test_the_noise_of_a_check_is_not_that_of_the_campaign_before() -> None:
    """The same seed would tell a rehearsal that the model is right where it follows its noise."""
    case = problem(HEXAPOD, {"experiment.load.gravity": ...})
    plain = targets()
    there = plain.assign(**{f"target_{name}": plain[name] for name in POSES})
    campaign, check = (xd.simulate(case, frame, load_errors=False).frame for frame in (plain, there))
    exact = xd.simulate(case, plain, load_errors=False, noise=False).frame
    noises = [(each["dx_m"] - exact["dx_m"]).to_numpy() for each in (campaign, check)]
    assert np.abs(noises[0] - noises[1]).min() > 1e-9

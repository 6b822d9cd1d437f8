"""Physics of arms with a telescope, a tool nobody weighed, steps that are not finished and warming without a clock."""

from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pandas as pd
import pytest

from expdesign.chain.chain import Chain
from expdesign.chain.effect import Effect
from expdesign.chain.effects.environment.thermal_drift import WarmUpByRows
from expdesign.chain.effects.joints.backlash import ExtensionPlay
from expdesign.chain.effects.joints.bearings import ExtensionCompliance, JointCompliance
from expdesign.chain.effects.joints.readings import ReadBeforeSettled
from expdesign.chain.effects.load.payload import UnknownTool
from expdesign.chain.models.estimable import Calibrated
from expdesign.chain.models.model_file import Model
from expdesign.chain.readings.choice import reading_of
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.row import Row, row_data
from expdesign.diagnosis.evidence.search import Search
from expdesign.diagnosis.library import candidates, library
from expdesign.diagnosis.names import Names
from expdesign.errors import InputError
from expdesign.estimation.compensation.prediction import after_campaign, require_history
from expdesign.estimation.fit import Fit, fit
from expdesign.mechanics.robots.serial import SerialRobot
from tests.chain.arms import DEVIATION, READING, configurations, recordings_of
from tests.fitting import data_of
from tests.identification.experiments import table_of
from tests.oracle import Array


def untimed(robot: SerialRobot, q: Array, wrenches: Array | None = None) -> Recordings:
    """Rows without time, at the loads of free wrenches if given."""
    rows = replace(recordings_of(robot, q, np.zeros((len(q), 3))), time=None)
    return rows if wrenches is None else replace(rows, wrenches=wrenches, absolute=wrenches)


def positions(robot: SerialRobot, effects: tuple[Effect, ...], parameters: list[float], rows: Recordings) -> Array:
    chain = Chain(robot, effects, reading=READING)
    return chain.predict(row_data(rows, robot), np.concatenate([chain.start()[: chain.base], parameters]))


def deflections(robot: SerialRobot, effect: Effect, parameters: list[float], rows: Recordings) -> Array:
    return deflections_of(robot, (effect,), parameters, rows)


def deflections_of(robot: SerialRobot, effects: tuple[Effect, ...], parameters: list[float], rows: Recordings) -> Array:
    chain = Chain(robot, effects)
    values = np.concatenate([np.ones(7), parameters])
    return chain.predict(row_data(replace(rows, marker=None, markers=()), robot), values)


def found(robot: SerialRobot, effect: Effect, read: Array, rows: Recordings) -> Fit:
    data = replace(rows, deflections=read + DEVIATION * np.random.default_rng(4).standard_normal(read.shape))
    chain = Chain(robot, (effect,), reading=reading_of(robot, data))
    return fit(chain, data_of(data, robot))


def require_recovered(result: Fit, truth: list[float]) -> None:
    error = (result.values - [*np.zeros(result.chain.base), *truth])[result.chain.base :]
    deviation = np.sqrt(np.diag(result.covariance))[result.chain.base :]
    assert np.isfinite(deviation).all()
    assert np.abs(error / deviation).max() < 4.0


def test_steps_that_are_not_finished(arm: SerialRobot) -> None:
    """Oracle: the settled arm at the joints that it reached; what is left is of second order in ρ·step."""
    q = configurations(60, 3)
    effect = ReadBeforeSettled.from_text(arm, "all joints", "logged before settled")
    rows, rho = untimed(arm, q), 2e-4
    reached = q.copy()
    for row in range(1, len(q)):
        reached[row] = q[row] - rho * (q[row] - reached[row - 1])
    read = positions(arm, (effect,), [rho], rows)
    settled = positions(arm, (), [], untimed(arm, reached))
    np.testing.assert_allclose(read, settled, atol=2e-6)
    assert np.abs(read - positions(arm, (), [], rows)).max() > 1e-4
    require_recovered(found(arm, effect, settled, rows), [rho])
    assert not ReadBeforeSettled.places(arm, replace(rows, series=np.arange(60)))


def test_warming_along_the_sequence(arm: SerialRobot) -> None:
    q = configurations(80, 5)
    effect = WarmUpByRows.from_text(arm, "joint 2", "warm-up along sequence")
    rows = untimed(arm, q)
    drift, constant = 1e-3, 20.0
    read = positions(arm, (effect,), [drift, constant], rows)
    turned = q + np.outer(drift * (1.0 - np.exp(-np.arange(80) / constant)), np.eye(7)[1])
    np.testing.assert_allclose(read, positions(arm, (), [], untimed(arm, turned)), atol=2e-6)
    assert WarmUpByRows.places(arm, rows)
    assert not WarmUpByRows.places(arm, replace(rows, time=10.0 * np.arange(80)))


def test_rows_given_alone_are_where_their_number_says(arm: SerialRobot) -> None:
    """Some rows of a campaign are predicted as among all of them, whatever else the file holds."""
    effect = WarmUpByRows.from_text(arm, "joint 2", "warm-up along sequence")
    rows, some = untimed(arm, configurations(80, 5)), np.array([7, 8, 60])
    every, alone = (positions(arm, (effect,), [1e-3, 20.0], each) for each in (rows, rows.rows(some)))
    np.testing.assert_allclose(alone, every[some], atol=1e-15)


def test_what_is_done_after_a_campaign_is_after_its_last_row(arm: SerialRobot) -> None:
    """Two equal targets get equal commands, wherever they stand in their file."""
    effect = WarmUpByRows.from_text(arm, "joint 2", "warm-up along sequence")
    rows = untimed(arm, configurations(80, 5))
    chain = Chain(arm, (effect,), reading=READING)
    model = Model(chain, chain.start(), np.eye(len(chain.start())), {}, Path(), "")
    model = replace(model, calibrated=Calibrated.of(rows, arm, ordered=chain.counts_rows))
    targets = rows.rows(np.array([0, 5]))
    assert after_campaign(model, targets).sequence.tolist() == [81, 81]
    plain = replace(model, chain=Chain(arm, (), reading=READING))
    assert after_campaign(plain, targets) is targets
    assert "sequence" not in Calibrated.of(rows, arm).ranges


def test_deflections_are_relative_to_the_first_row_of_their_series(arm: SerialRobot) -> None:
    effect = WarmUpByRows.from_text(arm, "joint 2", "warm-up along sequence")
    rows = replace(untimed(arm, configurations(4, 5)[[0, 0, 1, 1]]), series=np.array([1, 1, 2, 2]))
    moved = deflections(arm, effect, [1e-3, 3.0], rows)
    expected = 1e-3 * (np.exp(-np.array([0, 0, 2, 2]) / 3.0) - np.exp(-np.arange(4) / 3.0))
    columns = arm.jacobians(rows.configurations).forward[:, :, 1]
    np.testing.assert_allclose(moved, columns * expected[:, None], atol=1e-15)


def test_a_model_that_counts_rows_asks_for_their_order_and_not_for_time(arm: SerialRobot) -> None:
    effect = WarmUpByRows.from_text(arm, "joint 2", "warm-up along sequence")
    chain = Chain(arm, (effect,))
    values = chain.start()
    model = Model(chain, values, np.eye(len(values)), {}, Path(), "")
    frame = pd.DataFrame({"sequence": [1, 2], "series": [1, 1]})
    require_history(model, table_of(frame))
    with pytest.raises(InputError, match="depend on history"):
        require_history(model, table_of(frame[["series"]]))


def test_a_guide_that_yields_as_it_is_extended(arm: SerialRobot) -> None:
    """At every extension it is the bearing of `joint_compliance` with the compliance there."""
    q = configurations(6, 7)
    wrenches = np.random.default_rng(0).uniform(-50.0, 50.0, (6, 6))
    rows = untimed(arm, q, wrenches)
    growing = ExtensionCompliance.from_text(arm, "joint 1", "with extension")
    constant = JointCompliance.from_text(arm, "joint 1", "")
    for reading in (deflections, lambda a, e, p, r: positions(a, (e,), p, r)):
        whole = reading(arm, growing, [1e-6, 3e-6], rows)
        for row in range(6):
            there = reading(arm, constant, [1e-6 + 3e-6 * float(q[row, 0])], rows)
            np.testing.assert_allclose(whole[row], there[row], rtol=1e-12, atol=1e-16)
    assert [str(c) for c in ExtensionCompliance.components(arm)] == ["joint 1"]


def test_bearings_of_all_joints_are_those_of_each(arm: SerialRobot) -> None:
    q = configurations(6, 7)
    rows = untimed(arm, q, np.random.default_rng(0).uniform(-50.0, 50.0, (6, 6)))
    lateral = 1e-6 * np.arange(1.0, 8.0)
    together = JointCompliance.from_text(arm, "all joints", "")
    each = tuple(JointCompliance.from_text(arm, f"joint {k}", "") for k in range(1, 8))
    for reading in (deflections_of, positions):
        whole = reading(arm, (together,), lateral.tolist(), rows)
        np.testing.assert_allclose(whole, reading(arm, each, lateral.tolist(), rows), rtol=1e-12, atol=1e-18)


def test_bearings_of_which_each_shows_as_much_are_named_together(arm: SerialRobot) -> None:
    """Eight standard deviations in all rows of every joint: one at a time, some enter in the place of the others."""
    rows = untimed(arm, configurations(90, 3))
    each = [JointCompliance.from_text(arm, f"joint {k}", "") for k in range(1, 8)]
    together = JointCompliance.from_text(arm, "all joints", "")
    neutral = positions(arm, (), [], rows)
    shown = [np.linalg.norm(positions(arm, (one,), [1e-6], rows) - neutral) / DEVIATION for one in each]
    read = positions(arm, (together,), (8e-6 / np.array(shown)).clip(max=1e-3).tolist(), rows)
    noise = DEVIATION * np.random.default_rng(4).standard_normal(read.shape)
    data = replace(rows, deflections=read + noise)
    sample = data_of(data, arm, reading_of(arm, data)).counting(~data.test)
    base = fit(Chain(arm, reading=sample.reading), sample)
    entries = candidates([*each, together], sample, arm, base.values)
    model = next(Search.over(Names(arm, sample, entries, known_noise=True)).ends()).model
    assert model.keys == (together.key,)
    singly = next(Search.over(Names(arm, sample, entries[:-1], known_noise=True)).ends()).model
    assert 1 < len(singly.keys) < 7
    assert singly.misfit > model.misfit + 10.0


def test_play_that_grows_with_the_extension(arm: SerialRobot) -> None:
    """A lift that its own weight pushes down comes up by the gap at its extension when the load pushes harder."""
    q = np.zeros((3, 7))
    q[:, 0] = [0.0, 0.5, 1.0]
    weight = 9.80665 * arm.tree.masses().sum()
    rows = untimed(arm, q, np.tile([0.0, 0.0, 2.0 * weight, 0.0, 0.0, 0.0], (3, 1)))
    effect = ExtensionPlay.from_text(arm, "joint 1", "with extension")
    gained = deflections(arm, effect, [2e-5, 4e-5], rows) - deflections(arm, effect, [0.0, 0.0], rows)
    np.testing.assert_allclose(gained[:, 2], [2e-5, 4e-5, 6e-5], rtol=1e-9)
    shrinking = deflections(arm, effect, [2e-5, -4e-5], rows) - deflections(arm, effect, [0.0, 0.0], rows)
    np.testing.assert_allclose(shrinking[:, 2], [2e-5, 0.0, 0.0], atol=1e-18)


def test_a_tool_is_a_payload_that_nobody_entered(arm: SerialRobot) -> None:
    """Oracle: the payload of mass m at c as the load of the rows; mass and centre are found from positions."""
    q = configurations(150, 9)
    mass, centre = 2.5, np.array([0.04, -0.02, 0.15])
    effect = UnknownTool.from_text(arm, "platform")
    lever = arm.jacobians(q).rotation @ centre
    force = np.tile(mass * arm.gravity, (len(q), 1))
    loaded = untimed(arm, q, np.hstack([force, np.cross(lever, force)]))
    loaded = replace(loaded, payload=np.tile([mass, *centre], (len(q), 1)))
    rows, truth = untimed(arm, q), [mass, *(mass * centre)]
    read = positions(arm, (), [], loaded)
    np.testing.assert_allclose(positions(arm, (effect,), truth, rows), read, atol=1e-15)
    stiff = replace(rows, deflections=read + 1e-6 * np.random.default_rng(2).standard_normal(read.shape))
    stiff = replace(stiff, deviations=np.full(read.shape, 1e-6))
    chain = Chain(arm, (effect,), reading=reading_of(arm, stiff))
    result = fit(chain, data_of(stiff, arm))
    deviation = np.sqrt(np.diag(result.covariance))[chain.base :]
    assert np.abs((result.values[chain.base :] - truth) / deviation).max() < 4.0
    assert deviation[0] < 1.0


def test_effects_that_do_nothing_where_they_start_are_differentiated_together(
    arm: SerialRobot, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They do nothing to each other there; a chain for each took most of the time of an arm's diagnosis."""
    rows = replace(untimed(arm, configurations(12, 2)), deviations=np.full((12, 3), DEVIATION))
    sample, effects = data_of(rows, arm, READING).counting(~rows.test), library(arm, rows)[::3]
    base = Chain(arm, reading=READING).start()
    alone = [candidates([effect], sample, arm, base) for effect in effects]
    built, expression = [], Chain.expression

    def counted(chain: Chain, row: Row, state: ca.SX, theta: ca.SX) -> tuple[ca.SX, ca.SX]:
        built.append(chain)
        return expression(chain, row, state, theta)

    monkeypatch.setattr(Chain, "expression", counted)
    together = candidates(effects, sample, arm, base)
    assert len(built) <= 2 + 3 * sum(effect.states > 0 for effect in effects) < len(effects)
    assert [each.effect for each in together] == [one.effect for each in alone for one in each]
    for each, (one,) in zip(together, filter(None, alone), strict=True):
        for columns, expected in zip(each.directions, one.directions, strict=True):
            np.testing.assert_allclose(columns.matrix(), expected.matrix(), rtol=1e-9, atol=1e-9)

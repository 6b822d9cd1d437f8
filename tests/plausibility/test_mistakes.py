"""Every mistake is refused, or warned of by name; sound inputs are not warned of."""

import logging
import re
from copy import deepcopy
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from expdesign.app.api.configuration import problem_of
from expdesign.app.api.inputs import load_robot, table_of
from expdesign.app.api.recorded import read_recordings as read
from expdesign.assurance.plausibility.mistakes.columns import axes_in_words, axis_turns
from expdesign.assurance.plausibility.problem import problem_findings
from expdesign.assurance.plausibility.recordings import recordings_findings
from expdesign.chain.recordings.reader import read_recordings, recordings_from_table
from expdesign.errors import ExpdesignError
from expdesign.mechanics.robots.robot_file import read_robot
from research.benchmarks.real_sets import CASES, VARIABLE, Case, recordings_folder
from tests.oracle import Array
from tests.plausibility.mistaken_recordings import OF_PAYLOADS, OF_WRENCHES, read_in
from tests.plausibility.mistakes import CONFIGURATIONS, RECORDINGS, put
from tests.plausibility.sound import (
    CONFIGS,
    PARALLEL,
    concealing,
    content_of,
    problem_from,
    read_out,
    recordings_of,
    with_wrenches,
)

Log = pytest.LogCaptureFixture
SHIPPED = sorted(path for path in CONFIGS.glob("*.yaml") if not path.name.startswith("sweep"))


def said(log: Log, act: Any) -> str:
    """What is said of an input: the message that refuses it, or the warnings."""
    log.clear()
    with log.at_level(logging.WARNING, logger="expdesign.assurance.plausibility"):
        refused = []
        try:
            act()
        except ExpdesignError as error:
            refused.append(error.message)
    return "\n".join([*refused, *(record.getMessage() for record in log.records)])


@cache
def _sound(base: str, rows: int, spread: float, wrenches: bool) -> pd.DataFrame:
    content = with_wrenches(content_of(base)) if wrenches else content_of(base)
    return recordings_of(content, 5, rows=rows, spread=spread)


def sound(base: str, *, rows: int = 8, spread: float = 0.15, wrenches: bool = False) -> pd.DataFrame:
    """Recordings of a shipped robot, simulated once, into which a mistake is put."""
    return _sound(base, rows, spread, wrenches).copy()


@pytest.mark.parametrize("name", CONFIGURATIONS)
def test_a_mistaken_configuration(name: str, caplog: Log) -> None:
    base, change, words = CONFIGURATIONS[name]
    content = content_of(base)
    change(content)
    assert words in said(caplog, lambda: problem_of(content))


def test_a_target_may_carry_the_heaviest_weights_of_the_experiment(caplog: Log) -> None:
    content = content_of("hexapod-h1")
    put("experiment.load.mass_kg", [5.0, 26.5])(content)
    put("targets.0.payload", {"mass_kg": 26.5, "same_as": "experiment"})(content)
    assert said(caplog, lambda: problem_of(content)) == ""


@pytest.mark.parametrize("name", RECORDINGS)
def test_mistaken_recordings(name: str, caplog: Log) -> None:
    base, change, words = RECORDINGS[name]
    frame, robot = change(sound(base)), load_robot(content_of(base)["robot"])
    assert re.search(words, said(caplog, lambda: read(frame, robot)))


@pytest.mark.parametrize("name", [*OF_PAYLOADS, *OF_WRENCHES])
def test_mistaken_rows(name: str, caplog: Log) -> None:
    base, change, words = (OF_PAYLOADS | OF_WRENCHES)[name]
    spread = 0.02 if words == "lb" else 0.15
    made = sound(base, rows=12, spread=spread, wrenches=name in OF_WRENCHES)
    frame, robot = change(made), load_robot(content_of(base)["robot"])
    assert re.search(words, said(caplog, lambda: read(frame, robot)))


@pytest.mark.parametrize("turn", axis_turns(3)[:23], ids=lambda turn: axes_in_words(turn, "base"))
def test_an_instrument_is_named_in_each_of_the_23_frames(turn: Array) -> None:
    """With how far χ² falls: below twice its degrees of freedom where it was many times as large."""
    robot = load_robot(content_of("hexapod-h1")["robot"]).robot
    recordings = recordings_from_table(table_of(read_in(turn)(sound("hexapod-h1", rows=12)), "recordings"), robot)
    finding = recordings_findings(recordings, robot)[0]
    assert f"Is the instrument's frame turned ({axes_in_words(turn, 'base')})?" in finding.likely
    before, after = (float(text) for text in re.findall(r"(?:chi2|and) ([\d.e+]+)", finding.what)[-2:])
    assert before > 10.0 * after
    assert after < 2.0 * 66


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_shipped_configurations_are_sound(path: Path, caplog: Log) -> None:
    assert said(caplog, lambda: problem_of(path)) == ""


def sane_configuration(seed: int) -> dict[str, Any]:
    """A shipped configuration of another size, stiffness, load and noise, all within what laboratories have."""
    generator = np.random.default_rng([seed, 1])
    name = str(generator.choice([*PARALLEL, "bipod", "ur5", "closed-loop"]))
    content = content_of(name)

    def factor(most: float) -> float:
        return float(np.exp(generator.uniform(-np.log(most), np.log(most))))

    robot, experiment = content["robot"], content["experiment"]
    robot["actuator_stiffness"] = [k * factor(2.0) * 1.0 for k in (np.array(robot["actuator_stiffness"]) * factor(3.0))]
    noise = factor(5.0)
    std = experiment["deflection_noise"]["std"]
    experiment["deflection_noise"]["std"] = {axis: value * noise for axis, value in std.items()}
    if generator.random() < 0.3 and len(std) > 3:
        kept = [axis for axis in std if axis.endswith("_m")]
        experiment["deflection_noise"]["std"] = {axis: std[axis] * noise for axis in kept}
    for target in content["targets"]:
        slack = factor(4.0)
        target["tolerance"] = {axis: value * slack for axis, value in target["tolerance"].items()}
    return deepcopy(content)


def assert_sound(seed: int, log: Log) -> None:
    """A sound configuration, and recordings of its robot: as they are, without deviations, and with hidden physics."""
    content, generator = sane_configuration(seed), np.random.default_rng(seed)
    assert [finding.what for finding in problem_findings(problem_from(content))] == []
    rows, series = int(generator.integers(4, 15)), int(generator.integers(1, 4))
    if seed % 3 == 2:
        content = with_wrenches(content)
    frame = recordings_of(content, seed, rows=rows, spread=0.25, series=series)
    robot = load_robot(content["robot"])
    assert said(log, lambda: read(frame, robot)) == ""
    recordings = recordings_from_table(table_of(frame, "recordings"), robot.robot)
    for made in (
        read_out(recordings),
        replace(recordings, deviations=None),
        concealing(recordings, robot.robot, generator),
        replace(concealing(recordings, robot.robot, generator), deviations=None),
    ):
        assert recordings_findings(made, robot.robot) == []


@pytest.mark.parametrize("seed", [*range(16), *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(16, 540))])
def test_sane_inputs_are_not_warned_of(seed: int, caplog: Log) -> None:
    assert_sound(seed, caplog)


@pytest.mark.skipif(not recordings_folder().is_dir(), reason=f"no recordings in {recordings_folder()} (set {VARIABLE})")
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_real_recordings_are_not_warned_of(case: Case) -> None:
    robot = read_robot(recordings_folder() / case.folder / case.robot)
    for file in (case.file, *case.others):
        assert (
            recordings_findings(read_recordings(recordings_folder() / case.folder / f"{file}.csv", robot), robot) == []
        )

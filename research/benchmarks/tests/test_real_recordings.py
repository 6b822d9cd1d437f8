"""Real recordings, where they lie beside the project: found, read, and predicted better than by the base model.

The recordings are others' and not part of the project; without them these tests are skipped.
"""

import pytest

from expdesign.chain.readings.choice import reading_of
from expdesign.chain.readings.position import MarkerPosition
from expdesign.chain.recordings.reader import read_recordings
from expdesign.diagnosis.diagnose import diagnose
from expdesign.estimation.identify import identify
from expdesign.mechanics.robots.robot_file import read_robot
from expdesign.report.identification_tables import rms
from research.benchmarks.real_sets import CASES, VARIABLE, Case, recordings_folder

ROOT = recordings_folder()
present = pytest.mark.skipif(not ROOT.is_dir(), reason=f"no recordings in {ROOT} (set {VARIABLE})")


@present
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_every_file_is_read_and_its_licence_lies_beside_it(case: Case) -> None:
    robot = read_robot(ROOT / case.folder / case.robot)
    recordings = read_recordings(ROOT / case.folder / f"{case.file}.csv", robot)
    assert recordings.test.any()
    assert "icens" in (ROOT / case.folder / "LICENSE").read_text(encoding="utf-8")


@present
def test_one_orientation_of_the_tool_is_said_of_the_one_set_where_it_is_so() -> None:
    held = {}
    for case in CASES:
        if case.folder == "jaibot-prism":
            robot = read_robot(ROOT / case.folder / case.robot)
            reading = reading_of(robot, read_recordings(ROOT / case.folder / f"{case.file}.csv", robot))
            assert isinstance(reading, MarkerPosition)
            held[case.name] = len(reading.held)
    assert {name for name, count in held.items() if count} == {"jaibot-prism-flat"}


@present
def test_a_machine_on_its_feet_is_predicted_to_the_noise() -> None:
    robot = read_robot(ROOT / "jaibot-tilt" / "robot.yaml")
    recordings = read_recordings(ROOT / "jaibot-tilt" / "flat.csv", robot)
    before = rms(identify(robot, recordings).test_residuals)
    result = diagnose(robot, recordings)
    assert before is not None
    assert before > 10.0
    assert result.errors.test_after < 1.0
    assert result.verdict == "modelled"
    # A law at the port and with the inputs of a soft base keeps its name.
    assert {(finding.physics, finding.component) for finding in result.findings} == {("base_compliance", "base")}


@present
def test_a_column_is_predicted_at_stations_that_were_held_out() -> None:
    """Guides that overlap the less the farther the column is drawn out, and more besides that is not explained."""
    robot = read_robot(ROOT / "jaibot-column" / "robot.yaml")
    result = diagnose(robot, read_recordings(ROOT / "jaibot-column" / "flat.csv", robot))
    assert result.errors.test_before > 80.0
    assert result.errors.test_after < 6.5
    assert result.verdict == "unexplained"
    assert result.findings[0].variant == "guide"

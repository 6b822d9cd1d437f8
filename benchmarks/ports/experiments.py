"""Simulated experiments of the concealed-data generator, as the program reads them."""

from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.concealed.cases import Case
from benchmarks.concealed.generate import generate, write_questions

from expdesign.app.api.inputs import robot_of
from expdesign.app.api.recorded import recordings_of
from expdesign.chain.recordings.recordings import Recordings
from expdesign.mechanics.robots.robot import Robot


def experiments(count: int, seed: int, only: str) -> Iterator[tuple[Case, Robot, Recordings]]:
    """Cases of one kind (`none`, `outside`, an identifier) with the robot and the recordings."""
    with TemporaryDirectory() as scratch:
        for case in generate(count, seed, [only], 1):
            folder = Path(scratch) / str(case.truth["case"])
            write_questions(case, folder)
            machine = robot_of(folder / "robot.yaml")
            yield case, machine.robot, recordings_of(folder / "recordings.csv", machine)

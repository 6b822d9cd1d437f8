"""The page of `expdesign check`: which leg or joint is which, drawn and in numbers."""

import numpy as np

from expdesign.mechanics.robots.robot import Robot
from expdesign.planning.problem import DesignProblem
from expdesign.report import words
from expdesign.report.blocks import Block, Paragraph, Section
from expdesign.report.design_data import target_levers, target_text
from expdesign.report.page import Page
from expdesign.report.robot_section import SCRIPTS, actuator_blocks, picture
from expdesign.report.robot_view import RobotStates, at_rest, robot_states

_NOTE = "The robot in the base frame O at its reference pose, with the numbers by which every report names its parts."


def robot_report(robot: Robot, summary: str) -> Page:
    """The page of a robot's or a model's file."""
    return _page(robot, summary, at_rest(robot), [], [])


def problem_report(problem: DesignProblem, summary: str) -> Page:
    """The page of a configuration: its robot at rest, and at every target under its load."""
    robot, targets = problem.loaded.robot, problem.targets.configurations
    states = robot_states(
        robot,
        np.concatenate([robot.reference_configuration()[None], targets]),
        np.concatenate([np.zeros((1, robot.coordinates.n)), problem.target_wrenches]),
        np.concatenate([np.zeros((1, robot.coordinates.translations)), target_levers(problem)]),
    )
    texts = [f"Target {number + 1}: {target_text(problem, number)}" for number in range(len(targets))]
    choices = ["Reference pose", *(f"Target {number + 1}" for number in range(len(targets)))]
    return _page(robot, summary, states, choices, [Paragraph(text) for text in texts])


def _page(robot: Robot, summary: str, states: RobotStates | None, choices: list[str], targets: list[Block]) -> Page:
    blocks, data = picture(robot, states, note=_NOTE, choices=choices)
    sections = [
        Section(
            "machine",
            "The robot",
            [Paragraph(words.sentence(summary.replace("`", ""))), *blocks, *actuator_blocks(robot)],
        )
    ]
    if targets:
        sections.append(Section("targets", "Targets", targets))
    return Page(
        title=robot.name, subtitle=f"{robot.kind}, as its file describes it", sections=sections, data=data,
        scripts=SCRIPTS if data else (),
    )  # fmt: skip

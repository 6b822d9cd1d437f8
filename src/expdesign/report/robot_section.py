"""Where a robot's legs or joints are: sentences for a terminal, a table, and the numbered picture of reports.

The page of `expdesign check`: which leg or joint is which, drawn and in numbers.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray
from expdesign.mechanics.robots.robot import Robot
from expdesign.report import words
from expdesign.report.blocks import Block, PageSection, Paragraph, Selector, SideBySide, choices, table_of
from expdesign.report.page import Page
from expdesign.report.robot_view import RobotStates, at_rest, levers, plan_view, robot_states, view_data, view_figure

if TYPE_CHECKING:  # an identification is drawn without planning
    from expdesign.planning.problem import DesignProblem

SCRIPTS = ("robot_view.js", "robot_page.js")
"""Scripts that a page with `picture` needs."""
_DIRECTIONS = "Directions are seen from above: counter-clockwise from the x axis of O."


def actuator_frame(robot: Robot) -> pd.DataFrame:
    """Places, lengths and limits of the actuators (m, rad, degrees); empty for a robot without any."""
    if robot.on_straight_legs:
        return _legs(robot)
    return _joints(robot) if robot.jointed else pd.DataFrame()


def _legs(robot: Robot) -> pd.DataFrame:
    drawing, legs = robot.drawing(np.zeros(len(robot.configuration))), robot.straight_legs
    assert drawing is not None
    base = np.array([drawing.points[drawing.components[name][0]] for name in robot.actuators])
    places = [("base", base)] if base.shape[1] == 2 else [("base", base), ("platform", legs.platform_joints)]
    frame = pd.DataFrame({"actuator": robot.actuators})
    for side, joints in places:
        if joints.shape[1] == 3:
            frame[f"{side}_direction_deg"] = np.degrees(np.arctan2(joints[:, 1], joints[:, 0]))
        frame = frame.assign(**{f"{side}_{axis}_m": column for axis, column in zip("xyz", joints.T, strict=False)})
    frame["length_m"] = robot.actuator_coordinates(np.zeros(len(robot.configuration)))
    low, high = robot.actuator_limits
    return frame.assign(low_m=low, high_m=high)


def _joints(robot: Robot) -> pd.DataFrame:
    drawing, links = robot.drawing(robot.reference_configuration()), robot.links
    assert drawing is not None
    units = robot.configuration[: len(robot.actuators)]
    names = [coordinate.joint for coordinate in links.tree.coordinates]
    frame = pd.DataFrame({"actuator": robot.actuators, "name": names, "column": units})
    at = np.array([drawing.points[drawing.components[name][0]] for name in robot.actuators])
    along = np.array([drawing.directions[name] for name in robot.actuators])
    for side, vectors in (("", at), ("axis_", along)):
        unit = "" if side else "_m"
        frame = frame.assign(**{f"{side}{axis}{unit}": column for axis, column in zip("xyz", vectors.T, strict=True)})
    low, high = robot.actuator_limits
    return frame.assign(low=low, high=high)


def actuator_sentences(robot: Robot) -> list[str]:
    """A line for every leg or joint, and what the directions mean."""
    frame = actuator_frame(robot)
    if robot.on_straight_legs:
        lines = [_leg_sentence(row) for _, row in frame.iterrows()]
        spatial = "base_direction_deg" in frame
        return [*lines, f"{_DIRECTIONS} Base joints in O, platform joints in P (mm)."] if spatial else lines
    lines = [_joint_sentence(row) for _, row in frame.iterrows()]
    return [*lines, "Places (mm) and axes in O, at the reference pose."] if lines else []


def _leg_sentence(row: "pd.Series[Any]") -> str:
    parts = [f"base joint{_direction(row, 'base')} {_place(row, 'base_')}"]
    if "platform_x_m" in row:
        parts.append(f"platform joint{_direction(row, 'platform')} {_place(row, 'platform_')}")
    text = f"{row['actuator']}: {', '.join(parts)}; {words.fixed(1e3 * row['length_m'], 1)} mm long at the zero pose"
    return text + _limits(1e3 * row["low_m"], 1e3 * row["high_m"], "mm")


def _joint_sentence(row: "pd.Series[Any]") -> str:
    turns = row["column"].endswith("_rad")
    axis = ", ".join(words.given(round(float(row[f"axis_{name}"]), 3) + 0.0) for name in "xyz")
    motion = f"{'turns about' if turns else 'moves along'} ({axis})"
    factor, unit = (180.0 / np.pi, "°") if turns else (1e3, "mm")
    return f"{row['actuator']} ({row['name']}): at {_place(row, '')}, {motion}" + _limits(
        factor * row["low"], factor * row["high"], unit
    )


def _direction(row: "pd.Series[Any]", side: str) -> str:
    name = f"{side}_direction_deg"
    return f" at {words.fixed(row[name], 1)}°" if name in row else ""


def _place(row: "pd.Series[Any]", prefix: str) -> str:
    names = [f"{prefix}{axis}_m" for axis in "xyz" if f"{prefix}{axis}_m" in row]
    return f"({', '.join(words.fixed(1e3 * row[name], 1) for name in names)})"


def _limits(low: float, high: float, unit: str) -> str:
    if not np.isfinite([low, high]).all():
        return ", no limits"
    return f", limits {words.given(round(low, 1))} to {words.given(round(high, 1))} {unit}"


def actuator_blocks(robot: Robot) -> list[Block]:
    """The same as a table; nothing for a robot without actuators."""
    frame = actuator_frame(robot)
    if frame.empty:
        return []
    shown = {name: [_shown(name, value) for value in frame[name]] for name in map(str, frame) if name != "column"}
    headings = [_heading(name, robot) for name in shown]
    note = _DIRECTIONS if "base_direction_deg" in frame else "Places and axes in O, at the reference pose."
    caption = f"Where every actuator is. {note} The CSV is in SI units."
    return [table_of("actuators", caption, headings, list(zip(*shown.values(), strict=True)), frame)]


def _shown(name: str, value: object) -> str:
    if isinstance(value, str):
        return value
    number = float(str(value))
    if not np.isfinite(number):
        return "none"
    if name in ("low", "high"):
        return words.number(number)
    return words.fixed(1e3 * number if name.endswith("_m") else number, 3 if name.startswith("axis") else 1)


def _heading(name: str, robot: Robot) -> str:
    unit = ", ".join(dict.fromkeys(robot.units))
    if name in ("low", "high"):
        return f"{name.capitalize()} ({unit})"
    for ending, suffix in (("_direction_deg", " joint from above (°)"), ("_m", " (mm)")):
        if name.endswith(ending):
            return words.sentence(name.removesuffix(ending).replace("_", " ")) + suffix
    return words.sentence(name.replace("_", " "))


def picture(
    robot: Robot, states: RobotStates | None, concerned: Sequence[str] = (), note: str = "", names: Sequence[str] = ()
) -> tuple[list[Block], dict[str, Any]]:
    """The robot in space and from above with its numbers, and the data of the scripts; nothing where it is not drawn.

    Args:
        robot: the robot.
        states: what is shown, at first the first one.
        concerned: components of a diagnosis that stand out.
        note: sentence for the caption.
        names: what the states are called, where there are several to choose from.
    """
    if states is None:
        return [], {}
    view = view_data(robot, states, concerned)
    space = view["dimension"] == 3
    caption = " ".join(text for text in (note, "Drag to turn it, scroll to zoom." if space else "") if text)
    figure = view_figure("robot", view["dimension"], "The robot", caption, 460)
    shown: list[Block] = [figure, *([Selector("state", "Show", choices(names), step=True)] if names else [])]
    return [SideBySide(shown, [plan_view(robot, states, concerned)])] if space else shown, {"view": view}


_NOTE = "The robot in the base frame O at its reference pose, with the numbers by which every report names its parts."


def robot_report(robot: Robot, summary: str) -> Page:
    """The page of a robot's or a model's file."""
    return _page(robot, summary, at_rest(robot), [], [])


def problem_report(problem: "DesignProblem", summary: str) -> Page:
    """The page of a configuration: its robot at rest, and at every target under its load."""
    robot, targets = problem.loaded.robot, problem.targets.configurations
    states = robot_states(
        robot,
        np.concatenate([robot.reference_configuration()[None], targets]),
        np.concatenate([np.zeros((1, robot.coordinates.n)), problem.target_wrenches]),
        np.concatenate([np.zeros((1, robot.coordinates.translations)), target_levers(problem)]),
    )
    texts = [f"Target {number + 1}: {target_text(problem, number)}" for number in range(len(targets))]
    names = ["Reference pose", *(f"Target {number + 1}" for number in range(len(targets)))]
    return _page(robot, summary, states, names, [Paragraph(text) for text in texts])


def _page(robot: Robot, summary: str, states: RobotStates | None, names: list[str], targets: list[Block]) -> Page:
    blocks, data = picture(robot, states, note=_NOTE, names=names)
    said = Paragraph(words.sentence(summary.replace("`", "")))
    sections = (
        PageSection("machine", "The robot", [said, *blocks, *actuator_blocks(robot)]),
        PageSection("targets", "Targets", targets),
    )
    return Page(robot.name, f"{robot.kind}, as its file describes it", sections, data, SCRIPTS if data else ())


def target_text(problem: "DesignProblem", target: int) -> str:
    """A target's pose and load in words."""
    robot = problem.loaded.robot
    columns = [words.plan_column(name) for name in robot.configuration]
    pose = problem.targets.configurations[target]
    places = [
        f"{column.title} {words.fixed(value * column.factor, 3)} {column.unit}" for column, value in zip(columns, pose)
    ]
    wrench = [
        f"{words.plan_column(name).title} {words.number(value, 4)} {words.plan_column(name).unit}"
        for name, value in zip(robot.coordinates.wrench, problem.target_wrenches[target])
        if abs(value) > 1e-9
    ]
    return f"{', '.join(places)}. Load: {', '.join(wrench) or 'none'}."


def target_levers(problem: "DesignProblem") -> FloatArray:
    """Where the load acts at each target in the platform frame (m), shape (t, d)."""
    return np.array([levers(loaded.load, parameters) for loaded, parameters in problem.target_loads])

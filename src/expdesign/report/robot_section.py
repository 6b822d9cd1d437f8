"""The page of `expdesign check`: which leg or joint is which, in numbers and in the picture of reports."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray
from expdesign.mechanics.robots.robot import Robot
from expdesign.report import words
from expdesign.report.blocks import (
    Block,
    DataTable,
    PageSection,
    Paragraph,
    Selector,
    Shown,
    SideBySide,
    choices,
    framed,
)
from expdesign.report.page import Page
from expdesign.report.robot_view import RobotStates, levers, robot_states, view_data, view_figure

if TYPE_CHECKING:  # an identification is drawn without planning
    from expdesign.planning.problem import DesignProblem

SCRIPTS = ("robot_view.js", "robot_page.js")
"""Scripts that a page with `picture` needs."""
_DIRECTIONS = "Directions are seen from above: counter-clockwise from the x axis of O."
_AT_REFERENCE = "Places and axes in O, at the reference pose."


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


def actuator_tables(robot: Robot) -> list[DataTable]:
    """Where every actuator is; nothing for a robot without actuators."""
    frame = actuator_frame(robot)
    if frame.empty:
        return []
    about, shown = (_DIRECTIONS, _leg_cells(frame)) if robot.on_straight_legs else (_AT_REFERENCE, _JOINT_CELLS)
    return [framed("actuators", f"Where every actuator is. {about} The CSV is in SI units.", frame, shown)]


def _leg_cells(frame: pd.DataFrame) -> Shown:
    cells: dict[str, str | Callable[[Any], str]] = {"Actuator": "actuator"}
    for side, of in (("base", "O"), ("platform", "P")):
        if f"{side}_x_m" in frame:
            cells[f"{side.capitalize()} joint in {of} (mm)"] = _place(f"{side}_")
        if f"{side}_direction_deg" in frame:
            cells[f"{side.capitalize()} joint from above (°)"] = _fixed(f"{side}_direction_deg")
    return cells | {"Length (mm)": _fixed("length_m", 1e3), "Limits (mm)": _limits("low_m", "high_m")}


def _fixed(column: str, factor: float = 1.0) -> Callable[[Any], str]:
    return lambda row: words.fixed(factor * getattr(row, column), 1)


def _place(prefix: str) -> Callable[[Any], str]:
    """A place as `(x, y, z)` in mm; `(x, y)` in the plane."""
    names = [f"{prefix}{axis}_m" for axis in "xyz"]
    return lambda row: (
        f"({', '.join(words.fixed(1e3 * getattr(row, name), 1) for name in names if hasattr(row, name))})"
    )


def _limits(low: str, high: str, factor: float = 1e3) -> Callable[[Any], str]:
    def cell(row: Any) -> str:
        ends = [factor * getattr(row, name) for name in (low, high)]
        return " to ".join(words.given(round(end, 1)) for end in ends) if np.isfinite(ends).all() else "none"

    return cell


def _turns(row: Any) -> bool:
    return bool(row.column.endswith("_rad"))


def _joint_limits(row: Any) -> str:
    text = _limits("low", "high", 180.0 / np.pi if _turns(row) else 1e3)(row)
    return text if text == "none" else f"{text} {'°' if _turns(row) else 'mm'}"


_JOINT_CELLS: Shown = {
    "Actuator": "actuator",
    "Name": "name",
    "Place (mm)": _place(""),
    "Motion": lambda row: "turns about" if _turns(row) else "moves along",
    "Axis": lambda row: f"({', '.join(words.given(round(getattr(row, f'axis_{axis}'), 3) + 0.0) for axis in 'xyz')})",
    "Limits": _joint_limits,
}


_ABOVE = "The same, seen from above: x to the right and y upwards, so that angles grow counter-clockwise from x."


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
    above = view_figure("robot-above", 2, "Seen from above", _ABOVE, 460)
    return [SideBySide(shown, [above])] if space else shown, {"view": view}


_NOTE = "The robot in the base frame O at its reference pose, with the numbers by which every report names its parts."


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
    return robot_report(robot, summary, states, names, [Paragraph(text) for text in texts])


def robot_report(
    robot: Robot, summary: str, states: RobotStates | None, names: Sequence[str] = (), targets: Sequence[Block] = ()
) -> Page:
    """The page of a robot's or a model's file, or of a configuration with its targets."""
    blocks, data = picture(robot, states, note=_NOTE, names=names)
    said = Paragraph(words.sentence(summary.replace("`", "")))
    sections = (
        PageSection("machine", "The robot", [said, *blocks, *actuator_tables(robot)]),
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

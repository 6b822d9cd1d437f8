"""The robot with its loads as a picture: what `robot_view.js` draws, in space or in the plane.

The geometry comes from `Robot.drawing`; nothing here depends on the kind of robot.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.loads.load import Load
from expdesign.report.blocks import Figure
from expdesign.robots.drawing import Drawing
from expdesign.robots.robot import Robot

_ARROW_SHARE = 0.3
"""Length of the largest force's arrow as a share of the robot's size."""


@dataclass(frozen=True)
class RobotStates:
    """Configurations of one robot under load.

    Attributes:
        drawing: the robot, batch shape (s,).
        contact: where the force acts, in O (m), shape (s, d).
        force: in O (N), shape (s, d).
    """

    drawing: Drawing
    contact: FloatArray
    force: FloatArray


def robot_states(
    robot: Robot, configurations: FloatArray, wrenches: FloatArray, lever: FloatArray
) -> RobotStates | None:
    """States of a robot, or None for a kind that is not drawn.

    Args:
        robot: the robot.
        configurations: shape (s, n_q).
        wrenches: on the platform, shape (s, n).
        lever: where the force acts in the platform frame (m), shape (s, d).
    """
    drawing = robot.drawing(configurations)
    if drawing is None:
        return None
    rotation = robot.jacobians(configurations).rotation
    contact = drawing.origin + (rotation @ lever[..., None])[..., 0]
    return RobotStates(drawing, contact, wrenches[:, : robot.coordinates.translations])


def levers(load: Load, parameters: FloatArray) -> FloatArray:
    """Where the force of loads (..., k) acts in the platform frame (m): the centre of mass, or the frame's origin."""
    dimension = len(load.coordinates.gravity)
    names = load.coordinates.centre_of_mass
    if not names or not set(names) <= set(load.columns):
        return np.zeros((*parameters.shape[:-1], dimension))
    return parameters[..., [load.columns.index(name) for name in names]]


def view_data(states: RobotStates) -> dict[str, Any]:
    """The states as data for `robot_view.js`: points as flat lists, and the paths between them.

    After the drawing's own points come the origin of P, the point where the force acts, and the tip of its arrow.
    """
    drawn, origin = states.drawing.points, states.drawing.origin
    count, dimension = drawn.shape[-2:]
    low, high = drawn.min(axis=(0, 1)), drawn.max(axis=(0, 1))
    size = float(np.linalg.norm(high - low)) or 1.0
    largest = float(np.linalg.norm(states.force, axis=-1).max()) or 1.0
    tip = states.contact + states.force * (_ARROW_SHARE * size / largest)
    points = np.concatenate([drawn, np.stack([origin, states.contact, tip], axis=-2)], axis=-2)
    low, high = points.min(axis=(0, 1)) - 0.03 * size, points.max(axis=(0, 1)) + 0.03 * size
    decimals = 4 - int(np.floor(np.log10(size)))
    return {
        "dimension": dimension,
        "size": size,
        "bounds": np.stack([low, high], axis=-1),
        # Of the same length whatever the proportions, so that a tall robot is not cut off.
        "aspect": 1.75 * (high - low) / np.linalg.norm(high - low),
        "parts": [{"name": part.name, "role": part.role, "paths": part.paths} for part in states.drawing.parts],
        "origin": count,
        "contact": count + 1,
        "tip": count + 2,
        "states": np.round(points, decimals).reshape(len(points), -1),
    }


def view_figure(id: str, dimension: int, title: str, caption: str, height: int) -> Figure:
    """An empty figure that `robot_view.js` fills."""
    if dimension == 2:
        layout: dict[str, Any] = {
            "xaxis": {"title": {"text": "x (m)"}, "scaleanchor": "y", "constrain": "domain"},
            "yaxis": {"title": {"text": "y (m)"}},
        }
    else:
        layout = {
            "scene": {
                "aspectmode": "manual",
                "xaxis": {"title": {"text": "x (m)"}},
                "yaxis": {"title": {"text": "y (m)"}},
                "zaxis": {"title": {"text": "z (m)"}},
                "camera": {"eye": {"x": 1.38, "y": -1.78, "z": 0.69}, "center": {"x": 0, "y": 0, "z": -0.12}},
            },
            "margin": {"l": 0, "r": 0, "t": 8, "b": 60},
            "dragmode": "orbit",
        }
    layout["uirevision"] = "keep"
    description = f"{title}. The numbers are in the table of the plan."
    return Figure(id, title, {"data": [], "layout": layout}, caption, description, height=height, filename="robot")

"""The robot with its loads as a picture: what `robot_view.js` draws, in space or in the plane.

The geometry comes from `Robot.drawing`; nothing here depends on the kind of robot.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.mechanics.loads.load import Load
from expdesign.mechanics.robots.drawing import Drawing
from expdesign.mechanics.robots.robot import Robot
from expdesign.report.blocks import Figure
from expdesign.report.page import plot_text

_AXIS = 0.1
"""Length of a joint's axis as a share of the robot's size."""
_LABEL = 0.11
"""Distance of a leg's number from its base joint, likewise."""
_ARROW = 0.3
"""Length of the largest force's arrow, likewise."""

_FLAT: dict[str, dict[str, Any]] = {
    "xaxis": {"title": {"text": "x (m)"}, "scaleanchor": "y", "constrain": "domain", "tickangle": 0, "nticks": 6},
    "yaxis": {"title": {"text": "y (m)"}},
}


@dataclass(frozen=True)
class RobotStates:
    """Configurations of one robot under load.

    Attributes:
        drawing: the robot, batch shape (s,).
        contact: where the force acts, in O (m), shape (s, d).
        force: in O (N), shape (s, d).
        rotation: R, axes of the platform or tip in O, shape (s, d, d).
    """

    drawing: Drawing
    contact: FloatArray
    force: FloatArray
    rotation: FloatArray


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
    return RobotStates(drawing, contact, wrenches[:, : robot.coordinates.translations], rotation)


def levers(load: Load, parameters: FloatArray) -> FloatArray:
    """Where the force of loads (..., k) acts in the platform frame (m): the centre of mass, or the frame's origin."""
    dimension = len(load.coordinates.gravity)
    names = load.coordinates.centre_of_mass
    if not names or not set(names) <= set(load.columns):
        return np.zeros((*parameters.shape[:-1], dimension))
    return parameters[..., [load.columns.index(name) for name in names]]


def at_rest(robot: Robot, configuration: FloatArray | None = None) -> RobotStates | None:
    """A robot without load, at its reference configuration if none is given; None for a kind that is not drawn."""
    if configuration is None:
        configuration = robot.reference_configuration()
    return robot_states(
        robot,
        configuration[None],
        np.zeros((1, robot.coordinates.n)),
        np.zeros((1, robot.coordinates.translations)),
    )


def labels(robot: Robot, drawing: Drawing) -> dict[str, FloatArray]:
    """Where the names of actuators stand in O (m), shapes (s, d): outside base joints, or at ends of joints' axes."""
    size = _size(drawing)
    named = [name for name in robot.actuators if name in drawing.components]
    starts = {name: drawing.points[..., drawing.components[name][0], :] for name in named}
    places = {}
    for name, start in starts.items():
        if name in drawing.directions:
            places[name] = start + _AXIS * size * drawing.directions[name]
            continue
        outward = start - np.mean(list(starts.values()), axis=0)
        length = np.linalg.norm(outward, axis=-1, keepdims=True)
        places[name] = start + _LABEL * size * outward / np.where(length > 0.0, length, 1.0)
    return places


def view_data(robot: Robot, states: RobotStates, concerned: Sequence[str] = ()) -> dict[str, Any]:
    """The states as data for `robot_view.js`: points as flat lists, and the paths between them.

    After the drawing's own points come the origin of P, the point where the force acts, the tip of its arrow, the
    places of the names, and the markers.

    Args:
        robot: the robot.
        states: its states.
        concerned: components of a diagnosis, which are drawn in another colour.
    """
    drawing = states.drawing
    count, dimension = drawing.points.shape[-2:]
    size = _size(drawing)
    largest = float(np.linalg.norm(states.force, axis=-1).max())
    tip = states.contact + states.force * (_ARROW * size / (largest or 1.0))
    named = labels(robot, drawing)
    markers = {name: drawing.origin + (states.rotation @ place) for name, place in robot.markers.items()}
    further = [drawing.origin, states.contact, tip, *named.values(), *markers.values()]
    whole = np.concatenate([drawing.points, np.stack(further, axis=-2)], axis=-2)
    return {
        "dimension": dimension,
        "size": size,
        "moving": "tip" if robot.jointed else "platform",
        # Tips of an arm are so far apart that the arm would be small beside them.
        "ghosts": not robot.jointed,
        "parts": [{"name": part.name, "role": part.role, "paths": part.paths} for part in drawing.parts],
        "loaded": largest > 0.0,
        "origin": count,
        "contact": count + 1,
        "tip": count + 2,
        "labels": list(named),
        "axes": [[drawing.components[name][0], count + 3 + k] for k, name in enumerate(named)
                 if name in drawing.directions],
        "markers": [plot_text(name) for name in markers],
        "concerned": [path for name in concerned for path in drawing.paths(name)],
        "states": np.round(whole, 4 - int(np.floor(np.log10(size)))).reshape(len(whole), -1),
    }  # fmt: skip


def _size(drawing: Drawing) -> float:
    """Largest extent of the drawing in any of its states (m)."""
    return float(np.linalg.norm(np.ptp(drawing.points, axis=-2), axis=-1).max()) or 1.0


def view_figure(id: str, dimension: int, title: str, caption: str, height: int) -> Figure:
    """An empty figure, in space or in the plane, that `robot_view.js` fills."""
    if dimension == 2:
        layout: dict[str, Any] = dict(_FLAT)
    else:
        layout = {
            "scene": {
                "aspectmode": "manual",
                "xaxis": {"title": {"text": "x (m)"}},
                "yaxis": {"title": {"text": "y (m)"}},
                "zaxis": {"title": {"text": "z (m)"}},
                "camera": {"eye": {"x": 1.2, "y": -1.55, "z": 0.8}},
            },
            "margin": {"l": 0, "r": 0, "t": 8, "b": 60},
            "dragmode": "orbit",
        }
    layout["uirevision"] = "keep"
    description = f"{title}. The numbers of legs or joints stand beside them."
    return Figure(id, title, {"data": [], "layout": layout}, caption, description, height=height, filename=id)

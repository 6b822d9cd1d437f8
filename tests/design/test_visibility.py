"""Reflectors in sight: cones and lines of sight of known geometry, and plans that keep to them."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml

import expdesign as xd
from expdesign.app.api.configuration import problem_of
from expdesign.errors import InfeasibleError, InputError
from expdesign.mechanics.robots.serial import SerialRobot
from expdesign.planning.visibility import Visibility, distance_between
from tests.commands.calls import yaml_file
from tests.design.problems import changed, searched
from tests.oracle import Array
from tests.robots.urdf import joint_text, link_text, robot_of

ARM = (
    '<robot name="arm"><link name="base"/>'
    + link_text("column", 4.0)
    + joint_text("turn", "base", "column", "0 0 0.5", "0 0 1")
    + link_text("beam", 3.0)
    + joint_text("lift", "column", "beam", "0 0 0.5", "0 1 0")
    + link_text("wrist", 1.0)
    + joint_text("roll", "beam", "wrist", "1 0 0", "1 0 0")
    + link_text("tool", 0.1)
    + joint_text("flange", "wrist", "tool", "0.2 0 0", "1 0 0", kind="fixed")
    + "</robot>"
)
FILE = (
    "name: arm\nkind: serial\nurdf: robot.urdf\nbase_link: base\ntip_link: tool\nactuator_stiffness: [1e4, 1e4, 1e4]\n"
)
CONFIG: dict[str, Any] = {
    "schema_version": 1,
    "robot": "robot.yaml",
    "experiment": {
        "calibration": "geometric",
        "measurements": 16,
        "poses": {"bounds": {"q1_rad": [-2.5, 2.5], "q2_rad": [-0.8, 0.8], "q3_rad": [-2.5, 2.5]}},
        "deflection_noise": {"std": dict.fromkeys(("dx_m", "dy_m", "dz_m"), 1e-5)},
        "constraints": {
            "visibility": {
                "station_m": [3.0, 0.0, 1.0],
                "link_radius_m": 0.05,
                "reflectors": [{"at_m": [0.0, 0.0, 0.1], "direction": [1.0, 0.0, 0.5], "acceptance_rad": 1.0}],
            }
        },
    },
    "targets": [{"pose": [0.0, 0.1, 0.0], "tolerance": dict.fromkeys(("dx_m", "dy_m", "dz_m"), 1e-4)}],
    "objectives": ["duir"],
    "optimiser": {"population": 8, "generations": 2, "seed": 1, "effort": "quick"},
}
FORWARD = (np.zeros(3), np.array([1.0, 0.0, 0.0]), np.deg2rad(30.0))


def looked(station: Array, reflectors: list[Any], radius: float, least: int | None = None) -> Visibility:
    """What reflectors with place, direction and acceptance show a station."""
    places, directions, acceptances = (np.array(column) for column in zip(*reflectors, strict=True))
    return Visibility(station, places, directions, acceptances, radius, np.zeros(len(places), dtype=np.int64), least)


def arm(folder: Path) -> SerialRobot:
    return robot_of(folder, ARM, FILE)


def written(folder: Path, **change: Any) -> Path:
    arm(folder)
    changes = {f"experiment.constraints.visibility.{key}": value for key, value in change.items()}
    return yaml_file(folder / "config.yaml", changed(CONFIG, changes))


def test_the_cone_is_the_angle_to_the_station(tmp_path: Path) -> None:
    """The tip stands at (1.2·cos a, 1.2·sin a, 1) and looks along a; the station is straight ahead at a = 0."""
    seen, robot = looked(np.array([3.0, 0.0, 1.0]), [FORWARD], 0.0), arm(tmp_path)
    for angle in (0.0, 0.1, 0.3, 1.0, 2.0):
        line = np.array([3.0 - 1.2 * np.cos(angle), -1.2 * np.sin(angle)])
        away = angle - np.arctan2(line[1], line[0])
        assert seen.excess(robot, np.array([angle, 0.0, 0.0]))[0] == pytest.approx(away - np.deg2rad(30.0), abs=1e-7)


def test_links_hide_what_is_behind_them(tmp_path: Path) -> None:
    """A station behind the base sees the tip through the beam, by its whole radius; from above it sees past it."""
    back = (np.array([0.0, 0.0, 0.1]), np.array([-1.0, 0.0, 0.0]), 3.1)
    robot, still = arm(tmp_path), np.zeros(3)
    # From (-2, 0, 1) the line rises from the beam's height to 0.1 m above the tip: nearest at the column's head.
    height = 0.1 * 2.0 / 3.2
    hidden = looked(np.array([-2.0, 0.0, 1.0]), [back], 0.2).excess(robot, still)[1]
    assert hidden == pytest.approx(0.2 - height * np.cos(np.arctan2(0.1, 3.2)), abs=1e-6)
    above = looked(np.array([1.2, 0.0, 4.0]), [back], 0.05).excess(robot, still)[1]
    assert above == pytest.approx(0.05 - np.hypot(0.2, 0.1), abs=1e-9)  # the beam ends 0.2 m before the tip


def test_distances_of_segments_are_the_least_of_many_points() -> None:
    random = np.random.default_rng(1)
    a, b, c, d = random.normal(size=(4, 50, 3))
    d[:5] = c[:5] + (b - a)[:5]  # parallel
    b[5:8] = a[5:8]  # a point
    places = np.linspace(0.0, 1.0, 201)[:, None, None]
    first, second = a + places * (b - a), c + places * (d - c)
    least = np.linalg.norm(first[:, None] - second[None], axis=-1).min(axis=(0, 1))
    found = distance_between(a, b, c, d)
    assert (found <= least + 1e-12).all()
    np.testing.assert_allclose(found, least, atol=0.02)


def test_of_several_reflectors_as_many_have_to_be_seen_as_asked(tmp_path: Path) -> None:
    robot, station = arm(tmp_path), np.array([3.0, 0.0, 1.0])
    away = (np.zeros(3), np.array([-1.0, 0.0, 0.0]), np.deg2rad(30.0))
    still = np.zeros(3)
    assert looked(station, [FORWARD, away], 0.0, least=1).excess(robot, still).max() < 0.0
    assert looked(station, [FORWARD, away], 0.0).excess(robot, still)[0] == pytest.approx(np.deg2rad(150.0))


@pytest.mark.parametrize("listed", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_plans_keep_reflectors_in_sight(tmp_path: Path, listed: bool) -> None:
    """Of listed poses in every run; within bounds, where descents have to keep them in sight, as a proof."""
    poses = np.random.default_rng(1).uniform([-2.5, -0.8, -2.5], [2.5, 0.8, 2.5], (120, 3))
    config = written(tmp_path)
    if listed:
        document = yaml.safe_load(config.read_text(encoding="utf-8"))
        document["experiment"]["poses"] = {"candidates": poses.tolist()}
        config.write_text(yaml.safe_dump(document), encoding="utf-8")
    problem = problem_of(config)
    seen = problem.constraints.visibility.excess(problem.loaded.robot, poses).max(axis=-1) <= 0.0
    assert 0.05 < seen.mean() < 0.9
    chosen = searched(config).plan[["q1_rad", "q2_rad", "q3_rad"]].to_numpy()
    assert (problem.constraints.visibility.excess(problem.loaded.robot, chosen) <= 0.0).all()
    frame = pd.DataFrame(np.vstack([chosen, poses[~seen][:1]]), columns=["q1_rad", "q2_rad", "q3_rad"])
    with pytest.raises(InputError, match=r"row 17.*visibility|visibility"):
        xd.evaluate(config, frame)


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        (
            {"reflectors": [{"direction": [-1.0, 0.0, 0.0], "acceptance_rad": 0.02}], "station_m": [30.0, 0.0, 40.0]},
            InfeasibleError,
            r"broken is `visibility` at 100 %.*a reflector looks [\d.]+° past its acceptance",
        ),
        (
            {"link_radius_m": 4.0, "reflectors": [{"direction": [1, 0, 0], "acceptance_rad": 3.2}]},
            InfeasibleError,
            "a link is .* mm within the line of sight",
        ),
        ({"least": 2}, InputError, "2 are more than the 1 reflectors"),
        ({"reflectors": [{"direction": [0, 0, 0], "acceptance_rad": 1.0}]}, InputError, "a direction has a length"),
        (
            {"reflectors": [{"direction": [0, 0, 1], "acceptance_rad": 1.0, "tip": "tool"}]},
            InputError,
            "the robot has one tip",
        ),
    ],
)
def test_demands_that_cannot_be_met_say_why(
    tmp_path: Path, change: dict[str, Any], error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message):
        xd.run(written(tmp_path, **change))

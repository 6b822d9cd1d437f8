"""Where a URDF has its frames along (nearly) parallel axes changes nothing that is identified."""

from pathlib import Path
from xml.etree import ElementTree

import casadi as ca
import numpy as np
import pytest

import expdesign as xd
from expdesign.assurance.plausibility.robot import robot_findings
from expdesign.estimation.corrected_urdf import pose_of
from expdesign.mechanics.robots.common_normals import as_in_file
from expdesign.mechanics.robots.kinematic_tree import KinematicTree
from expdesign.mechanics.robots.orientation import rotations_of, transform
from expdesign.mechanics.robots.robot_file import read_robot
from expdesign.mechanics.robots.serial import SerialRobot
from expdesign.mechanics.robots.urdf import read_urdf
from tests.oracle import Array
from tests.plant import recordings, usual_faults

FOLDER = Path("configs/robots")
TILT = 5e-4
SLIDES = {2: 316.0, 3: -459.0}
"""m; of the frames of the links beyond the third and the fourth joint."""


def written(folder: Path, tilt: float, slides: dict[int, float]) -> Path:
    """The robot file of a UR5 whose third and fourth axis are tilted, with frames slid along their axes."""
    root = ElementTree.fromstring((FOLDER / "ur5.urdf").read_text(encoding="utf-8"))
    path = read_urdf(FOLDER / "ur5.urdf").path("base", "flange")
    moving = [joint for joint in path if joint.moves]
    shifts = {moving[number].child: slide * moving[number].axis for number, slide in slides.items()}
    tilted = {moving[2].name: (0.0, tilt, 0.0), moving[3].name: (tilt, 0.0, 0.0)}
    elements = {str(element.get("name")): element for element in root.findall("joint")}
    joints = read_urdf(FOLDER / "ur5.urdf").joints
    for name, joint in joints.items():
        before, beyond = (shifts.get(link, np.zeros(3)) for link in (joint.parent, joint.child))
        turned = joint.origin @ transform(rotations_of(np.array(tilted.get(name, (0.0, 0.0, 0.0)))), np.zeros(3))
        x = pose_of(transform(np.eye(3), -before) @ turned @ transform(np.eye(3), beyond))
        origin = elements[name].find("origin")
        origin = ElementTree.SubElement(elements[name], "origin") if origin is None else origin
        origin.set("xyz", " ".join(map(repr, x[:3].tolist())))
        origin.set("rpy", " ".join(map(repr, x[3:].tolist())))
    for link in root.findall("link"):
        centre = link.find("inertial/origin")
        if centre is not None and link.get("name") in shifts:
            place = np.array(str(centre.get("xyz")).split(), dtype=float) - shifts[str(link.get("name"))]
            centre.set("xyz", " ".join(map(repr, place.tolist())))
    folder.mkdir()
    (folder / "ur5.urdf").write_text(ElementTree.tostring(root, encoding="unicode"), encoding="utf-8")
    (folder / "ur5.yaml").write_text((FOLDER / "ur5.yaml").read_text(encoding="utf-8"), encoding="utf-8")
    return folder / "ur5.yaml"


def arm(path: Path) -> SerialRobot:
    robot = read_robot(path)
    assert isinstance(robot, SerialRobot)
    return robot


def states(robot: SerialRobot, configurations: Array) -> Array:
    """Pose of the tip and Σ m·(1, p), at every configuration."""
    symbol = ca.SX.sym("q", robot.tree.size_of_configuration)
    whole = ca.vertcat(ca.vec(robot.tree.tip_pose(symbol)), robot.tree.weight(symbol))
    function = ca.Function("state", [symbol], [whole])
    return np.array([np.array(function(q)).ravel() for q in configurations])


def test_slid_frames_are_the_same_robot(tmp_path: Path) -> None:
    near, far = (arm(written(tmp_path / name, TILT, s)) for name, s in (("near", {}), ("far", SLIDES)))
    assert not near.tree.urdf.slides
    assert far.tree.urdf.slides
    configurations = np.random.default_rng(1).uniform(-2.0, 2.0, (8, near.tree.size_of_configuration))
    np.testing.assert_allclose(states(far, configurations), states(near, configurations), atol=1e-9)
    assert max(np.linalg.norm(joint.origin[:3, 3]) for joint in far.tree.urdf.joints.values()) < 1.0
    assert robot_findings(far) == []
    in_file = read_urdf(tmp_path / "far/ur5.urdf").joints
    for name, joint in far.tree.urdf.joints.items():
        np.testing.assert_allclose(as_in_file(far.tree.urdf, joint, joint.origin), in_file[name].origin, atol=1e-9)


def test_frames_of_a_drawing_stay() -> None:
    assert not arm(FOLDER / "ur5.yaml").tree.urdf.slides


def test_identification_does_not_depend_on_them(tmp_path: Path) -> None:
    frame = recordings(usual_faults(3, tool=0.0), 80, 5)
    found = {}
    for name, slides in (("near", {}), ("far", SLIDES)):
        identified = xd.identify(written(tmp_path / name, TILT, slides), frame)
        found[name] = identified.result.arm.accuracy["held out", "position"].after.rms
        identified.save(tmp_path / f"out {name}")
    assert found["far"] == pytest.approx(found["near"], rel=0.05)
    assert found["far"] < 1e-4
    trees = [
        KinematicTree(read_urdf(tmp_path / f"out {name}/robot.urdf"), "base", ["flange"]) for name in ("near", "far")
    ]
    q = np.random.default_rng(2).uniform(-1.5, 1.5, (8, 6))
    near, far = (states(SerialRobot(tree, np.full(6, 1e4)), q) for tree in trees)
    apart = np.linalg.norm(near[:, 12:15] - far[:, 12:15], axis=1)
    assert apart.max() < 3e-3

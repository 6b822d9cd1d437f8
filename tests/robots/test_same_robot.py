"""Two files are about one robot where their geometry is the same, up to what a calibration corrects."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from expdesign.errors import InputError
from expdesign.mechanics.robots.robot import Robot
from expdesign.mechanics.robots.robot_file import difference, read_robot, require_same_robot

FILES = Path("configs/robots")


def robot(tmp_path: Path, source: str = "hexapod-h1.yaml", **changes: Any) -> Robot:
    """A robot of the repository with some keys changed."""
    content = yaml.safe_load((FILES / source).read_text(encoding="utf-8")) | changes
    path = tmp_path / "robot.yaml"
    path.write_text(yaml.safe_dump(content), encoding="utf-8")
    return read_robot(path)


def moved(name: str, joint: int, by: float) -> list[list[float]]:
    """Base joints of which one is moved along x."""
    places = yaml.safe_load((FILES / name).read_text(encoding="utf-8"))["base_joints"]
    places[joint][0] += by
    return places  # type: ignore[no-any-return]


def test_names_and_stiffness_are_not_geometry(tmp_path: Path) -> None:
    one = read_robot(FILES / "hexapod-h1.yaml")
    assert difference(one, robot(tmp_path, name="copy", actuator_stiffness=[9e6] * 6)) is None


def test_an_identified_geometry_is_of_the_same_robot_and_another_one_is_not(tmp_path: Path) -> None:
    name = "hexapod-h1.yaml"
    one = read_robot(FILES / name)
    assert difference(one, robot(tmp_path, base_joints=moved(name, 2, 1e-3))) is None
    assert difference(one, robot(tmp_path, base_joints=moved(name, 2, 50e-3))) == "the joint `base 3` is 50 mm apart"
    home = yaml.safe_load((FILES / name).read_text(encoding="utf-8"))["home"]
    home[2] += 0.1
    assert difference(one, robot(tmp_path, home=home)) == "home is 100 mm apart"
    assert "moving-xyz" in str(difference(one, robot(tmp_path, orientation="moving-xyz")))


def test_an_axis_of_an_arm_is_its_geometry(tmp_path: Path) -> None:
    """A turned axis moves nothing at the reference: it shows where the joints are turned."""
    text = (FILES / "ur5.urdf").read_text(encoding="utf-8")
    (tmp_path / "ur5.urdf").write_text(text.replace('<axis xyz="0 0 1"/>', '<axis xyz="1 0 0"/>', 1), encoding="utf-8")
    one, other = read_robot(FILES / "ur5.yaml"), robot(tmp_path, "ur5.yaml")
    assert difference(one, one) is None
    zero = one.reference_configuration()
    np.testing.assert_allclose(one.position(zero), other.position(zero))
    assert "mm apart" in str(difference(one, other))


def test_a_refusal_names_both_files_and_may_be_confirmed(tmp_path: Path) -> None:
    one, other = read_robot(FILES / "hexapod-h1.yaml"), robot(tmp_path, name="other", home=[0.0, 0.0, 0.5])
    with pytest.raises(InputError, match=r"^run.yaml: this is about `.*`, and robot.yaml about `other`") as raised:
        require_same_robot(one, "run.yaml", other, "robot.yaml")
    assert "argument `other_robot`" in raised.value.remedy
    require_same_robot(one, "run.yaml", other, "robot.yaml", confirmed=True)
    with pytest.raises(InputError, match=r"hexapod with 6 actuators .* bipod with 2"):
        require_same_robot(one, "run.yaml", read_robot(FILES / "bipod.yaml"), "bipod.yaml", confirmed=True)

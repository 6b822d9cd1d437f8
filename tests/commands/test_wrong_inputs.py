"""Inputs that look right and are too little, given twice, or of another kind: exit status 2 and one message."""

from pathlib import Path

import pytest
import yaml

import expdesign as xd
from expdesign.errors import InputError
from tests.commands.calls import CONFIG, ROBOT, ROOT, call, plan_file, refused, yaml_file

ARM = ROOT / "configs" / "robots" / "ur5.yaml"
ONE_JOINT = """<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="revolute">
<parent link="a"/><child link="b"/><origin xyz="0 0 1"/><axis xyz="0 1 0"/></joint></robot>"""
MARKED = (
    "sequence,series,q1_rad,q2_rad,q3_rad,q4_rad,q5_rad,q6_rad,mass_kg,com_x_m,com_y_m,com_z_m,"
    "marker,px_m,py_m,pz_m,spx_m,spy_m,spz_m"
)
BODY_HEADER = (
    "sequence,series,x_m,y_m,z_m,rx_rad,ry_rad,rz_rad,fx_N,fy_N,fz_N,mx_Nm,my_Nm,mz_Nm,drx_rad,dry_rad,srx_rad,sry_rad"
)


@pytest.mark.parametrize("positions", [["0.1,0.2,0.3"], ["0.1,0.2,0.3", "0.2,0.3,0.4"], ["0,0,0", "1,1,1", "2,2,2"]])
@pytest.mark.parametrize("command", ["check", "identify", "diagnose"])
def test_positions_that_do_not_place_the_instrument(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str, positions: list[str]
) -> None:
    joints = ["0.1,-1,1,0.3,0.5,0.2", "0.5,-1.2,0.8,-0.3,0.2,0.9", "-0.4,-0.9,1.3,0.1,-0.6,0.4"]
    rows = [
        f"{k},{k},{joints[k - 1]},4,0,0,0.1,prism,{place},1e-4,1e-4,1e-4" for k, place in enumerate(positions, start=1)
    ]
    recordings = yaml_file(tmp_path / "m.csv", "\n".join([MARKED, *rows]) + "\n")
    where = ["--robot", ARM] if command == "check" else ["--out", tmp_path / "out"]
    files = [recordings] if command == "check" else [ARM, recordings]
    assert "do not tell where the instrument stands" in refused(capsys, command, *files, *where)


def test_one_row_of_a_body_is_not_set_aside_as_an_outlier(tmp_path: Path) -> None:
    robot = yaml_file(tmp_path / "body.yaml", {"name": "b", "kind": "body"})
    row = "1,1,0,0,2,0,0,0,0,0,0,100,50,0,1e-4,5e-5,2e-6,2e-6"
    recordings = yaml_file(tmp_path / "b.csv", f"{BODY_HEADER}\n{row}\n")
    assert call("diagnose", robot, recordings, "--out", tmp_path / "out") == 0
    assert {"diagnosis.json", "report.html"} <= {path.name for path in (tmp_path / "out").iterdir()}


@pytest.mark.parametrize("command", ["check", "run", "compare"])
def test_a_body_has_nothing_to_plan_for(tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str) -> None:
    content = yaml.safe_load(CONFIG.read_text()) | {"robot": {"name": "b", "kind": "body"}}
    config = yaml_file(tmp_path / "config.yaml", content)
    options = [] if command == "check" else ["--out", tmp_path / "out"]
    assert "robot: a body has no actuators" in refused(capsys, command, config, *options)


@pytest.mark.parametrize("command", ["identify", "diagnose"])
def test_a_joint_that_no_measured_axis_shows_is_not_called_unloaded(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    yaml_file(tmp_path / "r.urdf", ONE_JOINT)
    arm = {"name": "r", "kind": "serial", "urdf": "r.urdf", "base_link": "a", "tip_link": "b"}
    robot = yaml_file(tmp_path / "r.yaml", arm | {"actuator_stiffness": [1000.0]})
    text = "sequence,series,q1_rad,mass_kg,com_x_m,com_y_m,com_z_m,dx_m,dz_m,sx_m,sz_m\n"
    recordings = yaml_file(tmp_path / "r.csv", text + "1,1,0.5,10,0.1,0,0.5,1e-5,1e-5,1e-5,1e-5\n")
    message = refused(capsys, command, robot, recordings, "--out", tmp_path / "out")
    assert "measured ax" in message
    assert "no row has a load" not in message


def test_options_of_compare_are_taken_as_they_are_given(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plan = plan_file(tmp_path)
    twice = ["--plan", f"a={plan}", "--plan", f"a={plan}"]
    assert "two plans `a`" in refused(capsys, "compare", CONFIG, "--out", tmp_path / "out", *twice)
    none = ["--generations", 0]
    assert "--generations: 0 is too small" in refused(capsys, "compare", CONFIG, "--out", tmp_path / "out", *none)


def test_a_robot_in_the_place_of_the_configuration_that_is_varied(tmp_path: Path) -> None:
    sweep = {"schema_version": 1, "config": str(ROBOT), "vary": {"optimiser.seed": [1]}}
    with pytest.raises(InputError, match="this is a robot, not a run configuration"):
        xd.sweep(yaml_file(tmp_path / "sweep.yaml", sweep), tmp_path / "out")


def test_a_place_where_no_folder_can_be_made_is_refused_before_the_work(capsys: pytest.CaptureFixture[str]) -> None:
    place = Path("/proc/nothing-can-be-made-here")
    if not place.parent.is_dir():
        pytest.skip("no /proc here")
    message = refused(capsys, "montecarlo", "not-read.yaml", "not-read.csv", "--out", place)
    assert "cannot be written" in message

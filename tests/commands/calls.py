"""Commands called as the command line calls them."""

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest
import yaml

from expdesign.app.commands.main import main
from tests.design.problems import changed

ROOT = Path(__file__).parents[2]
ROBOT = ROOT / "configs" / "robots" / "hexapod-h1.yaml"
CONFIG = ROOT / "configs" / "hexapod-h1.yaml"

Printed = pytest.CaptureFixture[str]
"""What a command has printed."""

PLAN = """sequence,series,x_m,y_m,z_m,rx_rad,ry_rad,rz_rad,mass_kg,com_x_m,com_y_m,com_z_m,note
1,1,0.01,0,0,0,0,0,26.5,0.1,0.05,0.12,first
2,1,0.01,0,0,0,0,0,10,0.1,-0.05,0.12,second
3,2,-0.01,0,0,0.1,0,0,26.5,-0.1,0.05,0.12,third
4,3,-0.01,0.02,0,0.1,0.1,0,26.5,-0.1,0.0,0.12,fourth
"""


def call(*arguments: object) -> int:
    """Exit status of `expdesign` with these arguments."""
    with pytest.raises(SystemExit) as caught:
        main([str(argument) for argument in arguments])
    code = caught.value.code
    return 0 if code is None else int(code)


def refusal(capsys: Printed, *arguments: object) -> str:
    """What a call says on standard error that must end with status 2."""
    capsys.readouterr()
    assert call(*arguments) == 2
    return capsys.readouterr().err


def refused(capsys: Printed, *arguments: object) -> str:
    """The one message of a call that must be refused."""
    (message,) = refusal(capsys, *arguments).strip().splitlines()
    assert message.startswith("expdesign: ")
    return message


def yaml_file(path: Path, content: object) -> Path:
    """A file with this text, or with this content as YAML."""
    path.write_text(content if isinstance(content, str) else yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
    return path


def config_file(folder: Path, changes: dict[str, Any], name: str = "hexapod-h1") -> Path:
    """A shipped configuration with its robot and with dotted keys replaced (`changed`), as `config.yaml`."""
    content = yaml.safe_load((ROOT / "configs" / f"{name}.yaml").read_text(encoding="utf-8"))
    content["robot"] = str(ROOT / "configs" / content["robot"])
    return yaml_file(folder / "config.yaml", changed(content, changes))


def plan_file(folder: Path) -> Path:
    """A plan of four measurements of the example hexapod."""
    path = folder / "plan.csv"
    path.write_text(PLAN, encoding="utf-8")
    return path


@cache
def _recorded(*options: object) -> str:
    """Recordings of that plan, simulated once."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "recordings.csv"
        assert call("simulate", CONFIG, plan_file(Path(folder)), "--out", path, "--seed", 5, *options) == 0
        return path.read_text(encoding="utf-8")


@cache
def _model() -> str:
    """The model that those recordings identify, made once."""
    with TemporaryDirectory() as folder:
        recordings, out = recordings_file(Path(folder)), Path(folder) / "identified"
        assert call("identify", ROBOT, recordings, "--out", out) == 0
        return (out / "model.yaml").read_text(encoding="utf-8")


def recordings_file(folder: Path, *options: object) -> Path:
    """Recordings of that plan, beside it."""
    plan_file(folder)
    path = folder / "recordings.csv"
    path.write_text(_recorded(*options), encoding="utf-8")
    return path


def model_file(folder: Path) -> Path:
    """The model that those recordings identify, and they."""
    recordings_file(folder)
    path = folder / "identified" / "model.yaml"
    path.parent.mkdir(exist_ok=True)
    path.write_text(_model(), encoding="utf-8")
    return path

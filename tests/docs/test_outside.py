"""A package of extensions that is installed beside the program: all of docs/extending.md, used from outside."""

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

import expdesign as xd
from expdesign import plugins
from expdesign.chain.effect import Effect
from expdesign.chain.effects.legs.transmission import LegBacklash
from expdesign.chain.models.effect_entry import effect_classes
from expdesign.errors import InputError
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.criterion import Criterion, known_criteria
from tests.docs.test_extending import FILES, PAGE, RRR, RRR_RUN, random_plan

SOURCE = Path(xd.__file__).parents[1]
OUTSIDE = ("planar_rrr", "ellipsoid", "weak_axes", "ratio", "leg_settling", "shared_line")


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder in which pip has put the package of the page."""
    folder = tmp_path_factory.mktemp("outside")
    package = folder / "source" / "our_machines"
    package.mkdir(parents=True)
    (package / "__init__.py").write_text('"""Extensions."""\n', encoding="utf-8")
    for path, text in FILES.items():
        if Path(path).stem in OUTSIDE:
            (package / Path(path).name).write_text(text, encoding="utf-8")
    project = PAGE.split('```toml title="pyproject.toml"\n')[1].split("```")[0]
    (folder / "source" / "pyproject.toml").write_text(project, encoding="utf-8")
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-build-isolation", "--no-index"]
    subprocess.run([*pip, "--target", folder / "beside", folder / "source"], check=True)
    return folder / "beside"


def command(beside: Path, *arguments: object) -> str:
    """Standard output of a command of a program that has the package beside it."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(beside), str(SOURCE)])}
    done = subprocess.run(
        [sys.executable, "-m", "expdesign", *map(str, arguments)],
        check=False,
        env=environment,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.slow
def test_everything_of_an_installed_package_is_used(installed: Path, tmp_path: Path) -> None:
    """Robot and load error in a run, criteria as objectives, physics in MEIR, `simulate`, `diagnose` and `next`."""
    experiment = {**RRR_RUN["experiment"], "load_error": [{"source": "ratio", "std": 0.01}]}  # type: ignore[dict-item]
    only = {"physics": ["leg_settling", "leg_backlash"]}
    run = {**RRR_RUN, "experiment": experiment, "objectives": ["total", "weak_axes"], "model_error": only}
    (tmp_path / "run.yaml").write_text(yaml.safe_dump(run), encoding="utf-8")
    (tmp_path / "robot.yaml").write_text(yaml.safe_dump(RRR), encoding="utf-8")
    assert "washers and new threads" in command(installed, "physics", tmp_path / "robot.yaml")
    command(installed, "run", tmp_path / "run.yaml", "--out", tmp_path / "plan")
    front = pd.read_csv(tmp_path / "plan" / "pareto.csv")
    assert {"total", "weak_axes", "ellipsoid", "meir"} <= set(front.columns)
    assert np.isfinite(front["weak_axes"]).all()
    assert (front["feir"] > 0.0).all()
    page = (tmp_path / "plan" / "report.html").read_text(encoding="utf-8")
    assert "weak directions" in page
    assert "seat of leg" in page
    plan, _, _ = random_plan(tmp_path, 40)
    recordings = tmp_path / "recordings.csv"
    command(installed, "simulate", tmp_path / "run.yaml", plan, "--conceal", "leg_settling at leg 2, 4e-4",
            "--no-load-errors", "--seed", "4", "--out", recordings)  # fmt: skip
    command(installed, "diagnose", tmp_path / "robot.yaml", recordings, "--targets", tmp_path / "run.yaml",
            "--out", tmp_path / "diagnosed")  # fmt: skip
    found = json.loads((tmp_path / "diagnosed" / "diagnosis.json").read_text(encoding="utf-8"))
    effect = found["effects"][0]
    assert effect["component"] == "leg 2"
    assert "leg_settling" in (effect["physics"], *effect["indistinguishable_from"])
    command(installed, "predict", tmp_path / "diagnosed" / "model.yaml", plan, "--out", tmp_path / "predicted.csv")
    sound = tmp_path / "sound.csv"
    command(installed, "simulate", tmp_path / "run.yaml", plan, "--no-load-errors", "--seed", "4", "--out", sound)
    command(installed, "diagnose", tmp_path / "robot.yaml", sound, "--targets", tmp_path / "run.yaml",
            "--out", tmp_path / "sound")  # fmt: skip
    hidden = json.loads((tmp_path / "sound" / "diagnosis.json").read_text(encoding="utf-8"))["hidden"]
    assert {"leg_settling", "leg_backlash"} == {each["physics"] for each in hidden["effects"]}
    command(installed, "next", tmp_path / "run.yaml", sound, "--count", "2", "--out", tmp_path / "next.csv")
    assert len(pd.read_csv(tmp_path / "next.csv")) == 2


@pytest.mark.slow
def test_a_law_at_a_port_of_an_installed_package_is_found_and_kept(installed: Path, tmp_path: Path) -> None:
    """Leg 2 gives way with the square of what leg 3 carries, which no shipped effect or port has."""
    robot = tmp_path / "robot.yaml"
    robot.write_text(yaml.safe_dump(RRR), encoding="utf-8")
    (tmp_path / "run.yaml").write_text(yaml.safe_dump(RRR_RUN), encoding="utf-8")
    plan, poses, wrenches = random_plan(tmp_path, 80)
    made = tmp_path / "recordings.csv"
    command(installed, "simulate", tmp_path / "run.yaml", plan, "--no-load-errors", "--seed", "4", "--out", made)
    frame = pd.read_csv(made)
    columns = ["dx_m", "dy_m", "drz_rad"]
    code = (
        "import sys, numpy as np, expdesign as xd; machine = xd.load(sys.argv[1]).robot; "
        "poses, wrenches = np.load(sys.argv[2]).transpose(1, 0, 2); maps = machine.jacobians(poses); "
        "forces = np.einsum('nij,ni->nj', maps.forward, wrenches); "
        "np.save(sys.argv[3], maps.pose[:, :, 1] * (3e-3 * (forces[:, 2:3] / 100.0) ** 2))"
    )
    np.save(tmp_path / "points.npy", np.stack([poses, wrenches], axis=1))
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(installed), str(SOURCE)])}
    subprocess.run([sys.executable, "-c", code, robot, tmp_path / "points.npy", tmp_path / "more.npy"], check=True,
                   env=environment)  # fmt: skip
    frame[columns] += np.load(tmp_path / "more.npy")
    frame.to_csv(made, index=False)
    command(installed, "diagnose", robot, made, "--out", tmp_path / "out")
    effects = yaml.safe_load((tmp_path / "out" / "model.yaml").read_text(encoding="utf-8"))["effects"]
    laws = [(entry["component"], entry["law"]["port"]) for entry in effects if entry.get("law")]
    assert ("leg 2", "shared line") in laws, effects
    command(installed, "predict", tmp_path / "out" / "model.yaml", plan, "--out", tmp_path / "predicted.csv")


class _Wear(LegBacklash):
    """Play by another name, from a script."""

    identifier = "wear"
    physics = "wear"


class _Count(Criterion):
    """As many as there are parameters."""

    name = "count"
    title = "parameters"
    differentiable = False

    def values(self, assessment: Assessment) -> np.ndarray:
        return np.full(assessment.batch, float(assessment.parameters))


@pytest.fixture
def extended() -> Iterator[None]:
    xd.extend(_Wear)
    xd.extend(_Count)
    yield
    plugins.remove(_Wear)
    plugins.remove(_Count)


def test_a_script_registers_its_classes(extended: None) -> None:
    assert _Wear in effect_classes()
    assert known_criteria()["count"].title == "parameters"


def test_what_is_not_registered_is_not_known() -> None:
    assert _Wear not in effect_classes()
    assert "count" not in known_criteria()


def test_what_cannot_be_registered_is_refused(extended: None) -> None:
    class Twin(LegBacklash):
        identifier = "wear"
        physics = "wear"

    with pytest.raises(InputError, match=r"Twin.*wear.*already"):
        xd.extend(Twin)
    assert _Wear in effect_classes()
    with pytest.raises(InputError, match="nothing that can be added"):
        xd.extend(dict)
    with pytest.raises(InputError, match="`3` is not a class"):
        xd.extend(3)  # type: ignore[type-var]

    class Half(Effect):
        physics = "half"

    with pytest.raises(InputError, match=r"Half.*it lacks `at`"):
        xd.extend(Half)


def test_an_entry_point_that_cannot_be_loaded_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    info = tmp_path / "broken-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: broken\nVersion: 1.0\n", encoding="utf-8")
    (info / "entry_points.txt").write_text("[expdesign.criteria]\nbad = nowhere:Criterion\n", encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    plugins.forget()
    try:
        assert plugins.extensions() == {"broken": "1.0"}
        with pytest.raises(InputError, match=r"`bad` of `broken`, group `expdesign.criteria`.*nowhere.*uninstall"):
            known_criteria()
    finally:
        monkeypatch.undo()
        plugins.forget()

"""The concealed cases are what they claim: independent of the program, hidden at the size stated, fair to answer."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

pytest.importorskip("exudyn", reason="the virtual laboratory needs the engine exudyn")
from research.benchmarks.concealed.bench import Order
from research.benchmarks.concealed.case import generate, write_questions
from research.benchmarks.concealed.cases import INSIDE, OUTSIDE, NoisyBench, draw_case, orders
from research.benchmarks.concealed.experiments import Wishes, draw_experiment
from research.benchmarks.concealed.hidden import Sized, element
from research.benchmarks.concealed.mimicry import remaining_misfit
from research.benchmarks.concealed.robots import HEXAPODS, bipod, h1

ROOT = Path(__file__).parents[3]
SOURCES = sorted((ROOT / "research" / "benchmarks" / "concealed").rglob("*.py"))


def test_nothing_is_imported_from_the_program_under_test():
    for source in SOURCES:
        for node in ast.walk(ast.parse(source.read_text(encoding="utf-8"))):
            names = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            assert not [name for name in names if name.split(".")[0] == "expdesign"], source
    loaded = "print([m for m in sys.modules if m.startswith('expdesign')])"
    check = f"import sys, research.benchmarks.concealed.run; {loaded}"
    done = subprocess.run([sys.executable, "-c", check], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_two_hundred_cases_have_the_shares_that_are_asked_for():
    wanted = orders(200, seed=5)
    assert Counter(order.family for order in wanted) == {"none": 50, "two": 30, "outside": 20, "one": 100}
    alone = Counter(order.physics[0] for order in wanted if order.family == "one")
    assert set(alone) == set(INSIDE)
    assert min(alone.values()) >= 5
    assert set(Counter(order.physics[0] for order in wanted if order.family == "outside").values()) == {4}
    assert 0.08 <= sum(order.robot == "bipod" for order in wanted) / 200 <= 0.16
    assert [order.family for order in wanted] != sorted(order.family for order in wanted)


def test_only_selects():
    assert {order.physics for order in orders(6, 1, ["creep"])} == {("creep",)}
    assert {order.family for order in orders(6, 1, ["creep", "none"])} == {"one", "none"}
    assert {order.physics for order in orders(3, 1, ["cable"])} == {("cable",)}
    with pytest.raises(SystemExit, match="known are"):
        orders(2, 1, ["no such physics"])


def test_a_seed_repeats_and_another_does_not():
    first, again, other = ([*generate(draw_case, orders(2, seed, ["none"]), seed)] for seed in (3, 3, 4))
    for one, two in zip(first, again, strict=True):
        assert one.truth == two.truth
        pd.testing.assert_frame_equal(one.recordings, two.recordings)
    assert not first[0].recordings.equals(other[0].recordings)


def test_without_effect_chi2_is_that_of_noise():
    cases = list(generate(draw_case, orders(12, 11, ["none"]), 11))
    chi2 = sum(case.truth["chi2_dof"] * case.truth["dof"] for case in cases)
    dof = sum(case.truth["dof"] for case in cases)
    assert abs(chi2 - dof) < 4 * np.sqrt(2 * dof)
    assert all(case.truth["effects"] == [] for case in cases)
    assert len({case.truth["made_for"][0] for case in cases}) > 6


@pytest.mark.parametrize("physics", [*INSIDE, *OUTSIDE])
def test_every_physics_shows_and_is_told_in_the_truth(physics):
    kind = "one" if physics in INSIDE else "outside"
    case = draw_case(Order(kind, (physics,), "H1"), np.random.default_rng(2))
    (effect,) = case.truth["effects"]
    assert effect["physics"] == physics
    assert 1.5 <= case.truth["chi2_dof"] < 60
    assert abs(case.truth["chi2_dof"] - effect["chi2_dof_alone"]) < 0.5 + 0.15 * effect["chi2_dof_alone"]
    assert 60 <= len(case.recordings) <= 200
    assert case.recordings["series"].nunique() >= 10
    assert {"sequence", "series", "x_m", "y_m"} <= set(case.recordings.columns)
    assert any(name in case.recordings for name in ("mass_kg", "fx_N"))
    yaml.safe_dump(case.truth)


@pytest.mark.parametrize("robot", [*HEXAPODS, "bipod"])
def test_two_effects_show_each_alone(robot):
    case = draw_case(Order("two", ("thermal_drift", "leg_nonlinear_stiffness"), robot), np.random.default_rng(4))
    assert [effect["physics"] for effect in case.truth["effects"]] == ["thermal_drift", "leg_nonlinear_stiffness"]
    assert min(effect["chi2_dof_alone"] for effect in case.truth["effects"]) >= 1.5
    assert case.truth["alike"] < 0.8


def test_chi2_is_that_of_the_program_and_the_folder_tells_nothing(tmp_path):
    """The judge's own least squares agree with `expdesign identify`, which reads the files as they are written."""
    case = draw_case(Order("one", ("base_compliance",), "irregular"), np.random.default_rng(8))
    write_questions(case, tmp_path / "case")
    assert sorted(path.name for path in (tmp_path / "case").iterdir()) == ["recordings.csv", "robot.yaml"]
    assert "compliance" not in "".join(path.read_text(encoding="utf-8") for path in (tmp_path / "case").iterdir())
    program = str(Path(sys.executable).with_name("expdesign"))
    call = [program, "identify", "case/robot.yaml", "case/recordings.csv", "--out", "found"]
    subprocess.run(call, cwd=tmp_path, capture_output=True, check=True)
    found = json.loads((tmp_path / "found" / "identification.json").read_text(encoding="utf-8"))
    assert found["dof"] == case.truth["dof"]
    assert found["chi2"] / found["dof"] == pytest.approx(case.truth["chi2_dof"], rel=1e-3)


def bench_of(machine_of, wishes=None, seed=1):
    rng = np.random.default_rng(seed)
    return NoisyBench(draw_experiment(machine_of(rng), wishes or Wishes(), rng), seed=7)


@pytest.mark.parametrize("machine_of", [*HEXAPODS.values(), bipod])
def test_the_linear_model_is_the_laboratory_without_effects(machine_of):
    bench = bench_of(machine_of)
    deflection = np.abs(bench.clean / bench.experiment.std).max()
    assert deflection > 5
    assert bench.fit.misfit(bench.clean) < 1e-3 * np.sum((bench.clean / bench.experiment.std) ** 2) / 100


@pytest.mark.parametrize(
    "effects",
    [
        [element("payload_com_offset", com_dx_m=2e-3, com_dz_m=-1e-3)],
        [element("load_direction_tilt", tilt_x_rad=2e-3, tilt_y_rad=1e-3)],
        [element("instrument_misalignment", rot_x_rad=2e-3, rot_y_rad=1e-3, rot_z_rad=1e-3)],
        [element("instrument_scale", scale_x=1e-2, scale_z=2e-2)],
        [element("platform_compliance", stiffness=[3e9, 5e9, 2e9, 1e8, 2e8, 5e7])],
        [element("base_compliance", stiffness=[3e9, 5e9, 2e9, 1e8, 2e8, 5e7])],
        [element("joint_position_error", component="leg 2", end="platform", dx_m=2e-4, dz_m=1e-4)],
        [element("leg_backlash", component="leg 5", gap_m=1e-6)],
        [element("leg_nonlinear_stiffness", component="leg 5", law="bilinear", relative_change=0.01)],
        [element("instrument_scale", scale_y=2e-2), element("leg_backlash", component="leg 1", gap_m=4e-7)],
    ],
    ids=lambda effects: "+".join(each["physics"] for each in effects),
)
def test_known_physics_is_no_effect_outside_the_library(effects):
    """What the laboratory's own element leaves in the base fit is what the linear known effects take out again."""
    bench = bench_of(h1, Wishes(load="payload", reversals=True), seed=3)
    bench = NoisyBench(replace(bench.experiment, std=bench.experiment.std / 100), seed=7)  # so that small amounts show
    sized = Sized(tuple(effects))
    before = bench.fit.misfit(bench.seen_clean(sized))
    curvature = bench.fit.misfit(bench.clean)  # the change of geometry, which is in every equilibrium
    assert before > 50 * curvature
    assert remaining_misfit(bench.experiment, bench.fit, bench.seen_clean, sized) < 0.02 * before + 2 * curvature


def test_play_sits_in_a_leg_whose_force_changes_sign():
    case = draw_case(Order("one", ("leg_backlash",), "moving-xyz"), np.random.default_rng(6))
    leg = int(case.truth["effects"][0]["parts"][0].split()[1]) - 1
    from research.benchmarks.concealed.linear_model import leg_forces  # noqa: PLC0415
    from research.laboratory import Robot  # noqa: PLC0415

    forces = leg_forces(Robot.from_mapping(case.robot), case.recordings)[:, leg]
    loaded = forces[np.abs(forces) > 1e-6]
    assert 0.15 < np.mean(loaded > 0) < 0.85

"""The functions of the package are found by their place, import late, and do what the commands do."""

import ast
import importlib
import inspect
import re
import subprocess
import sys
from pathlib import Path
from typing import cast

import numpy as np
import pandas as pd
import pytest

import expdesign as xd
from expdesign.app.commands.help import function_of, listed_commands
from expdesign.chain.models.model_file import Model
from expdesign.chain.recordings.recordings import Recordings
from expdesign.errors import ArgumentError, InputError
from expdesign.io.output import csv_text
from expdesign.io.table import read_table
from expdesign.mechanics.robots.robot_file import RobotFile
from expdesign.planning.problem import DesignProblem
from expdesign.report.result import numeric
from tests.commands.calls import CONFIG, ROBOT, ROOT, Printed, call, plan_file, recordings_file


def test_the_package_imports_late() -> None:
    code = "import sys, expdesign; print(sorted({'casadi', 'numpy', 'pandas'} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout == "[]\n"


def test_load_tells_files_by_what_they_hold(tmp_path: Path) -> None:
    recordings = recordings_file(tmp_path)
    assert isinstance(xd.load(CONFIG), DesignProblem)
    robot = xd.load(ROBOT)
    assert isinstance(robot, RobotFile)
    frame = xd.load(recordings)
    assert isinstance(frame, pd.DataFrame)
    assert frame["dz_m"].dtype == float
    assert isinstance(xd.load(recordings, robot), Recordings)
    identified = xd.identify(robot, [recordings])
    identified.save(tmp_path / "out")
    assert isinstance(xd.load(tmp_path / "out" / "model.yaml"), Model)
    (tmp_path / "else.yaml").write_text("a: 1\n")
    with pytest.raises(InputError, match="neither"):
        xd.load(tmp_path / "else.yaml")


def test_what_is_saved_is_what_the_command_writes(tmp_path: Path) -> None:
    """From frames and objects in Python as from files at the command line, to the last digit."""
    plan, robot = plan_file(tmp_path), xd.load(ROBOT)
    simulated = xd.simulate(xd.load(CONFIG), xd.load(plan), seed=5)  # type: ignore[arg-type]
    recorded = xd.load(recordings_file(tmp_path))
    assert isinstance(recorded, pd.DataFrame)
    pd.testing.assert_frame_equal(simulated.frame, recorded, check_exact=True)
    identified = xd.identify(robot, simulated.frame)  # type: ignore[arg-type]
    assert call("identify", ROBOT, tmp_path / "recordings.csv", "--out", tmp_path / "command") == 0
    written = xd.load_model(tmp_path / "command" / "model.yaml")
    # The file holds compliances in m/N, of which the chain has the ratios to the nominal ones: the last bit may differ.
    np.testing.assert_allclose(written.values, identified.model.values, rtol=1e-15)
    for name, function in (("predict", xd.predict), ("compensate", xd.compensate)):
        out = tmp_path / f"{name}.csv"
        assert call(name, tmp_path / "command" / "model.yaml", plan, "--out", out) == 0
        function(written, plan).save(tmp_path / f"api-{name}.csv")
        assert (tmp_path / f"api-{name}.csv").read_bytes() == out.read_bytes()


def test_numbers_of_a_text_frame_are_exact(tmp_path: Path) -> None:
    frame = pd.DataFrame({"a": [0.1, 1e-300, -0.0], "b": [1, 2, 3], "c": ["x", "1", "2"], "d": [1.5, None, 2.0]})
    (tmp_path / "t.csv").write_text(csv_text(frame))
    table = numeric(read_table(tmp_path / "t.csv").frame)
    assert table["a"].tolist() == frame["a"].tolist()
    assert table["b"].tolist() == [1, 2, 3]
    assert table["c"].tolist() == ["x", "1", "2"]
    assert table["d"].isna().tolist() == [False, True, False]


def test_results_have_plain_attributes_and_print_as_their_command(tmp_path: Path) -> None:
    identified = xd.identify(ROBOT, recordings_file(tmp_path))
    record = identified.record
    assert identified.chi2 == record["chi2"]
    assert identified.p_value == record["p_value"]
    np.testing.assert_array_equal(identified.covariance, record["covariance"])
    shown = str(identified).splitlines()
    assert shown == [*identified.lines, *identified.notes]
    assert len(shown) > 2
    judged = xd.evaluate(CONFIG, plan_file(tmp_path))
    assert judged.total == judged.record["total"]


@pytest.mark.parametrize("name", sorted({str(function_of(name)) for name in listed_commands()} - {"None"}))
def test_signatures_read_in_an_editor_and_a_wrong_argument_is_answered_with_the_nearest(name: str) -> None:
    function = getattr(xd, name)
    assert not re.search(r" at 0x|\w\.\w", str(inspect.signature(function)))
    known = list(inspect.signature(function).parameters)
    with pytest.raises(TypeError, match=f"`{name}` has no argument `{known[-1]}x`. Did you mean `{known[-1]}`"):
        function(**{f"{known[-1]}x": 1})


def test_a_text_for_a_number_is_named_with_its_argument() -> None:
    for samples in (100.5, float("nan")):
        with pytest.raises(ArgumentError, match="is not a whole number"):
            xd.montecarlo(CONFIG, "plan.csv", samples=samples)  # type: ignore[arg-type]
    with pytest.raises(ArgumentError, match=r"seconds.*'a' is not a number"):
        xd.run(CONFIG, seconds=cast("float", "a"))


FILES_ALONE = {"new"}


"""Commands that write files, and compute nothing."""


def test_every_command_is_a_function() -> None:
    for name in set(listed_commands()) - FILES_ALONE:
        assert "Raises:" in getattr(xd, str(function_of(name))).__doc__, name
    with pytest.raises(AttributeError, match="nothing"):
        _ = xd.nothing


def test_every_result_is_exported() -> None:
    """Public classes that a function of the API returns, by its annotation."""
    for file in sorted((ROOT / "src/expdesign/app/api").glob("[a-z]*.py")):
        tree = ast.parse(file.read_text(encoding="utf-8"))
        module = importlib.import_module(f"expdesign.app.api.{file.stem}")
        classes = {node.name for node in tree.body if isinstance(node, ast.ClassDef)}
        for node in tree.body:
            returns = isinstance(node, ast.FunctionDef) and node.name == file.stem and node.returns
            if returns and ast.unparse(returns) in classes:
                assert getattr(xd, ast.unparse(returns)) is getattr(module, ast.unparse(returns))


def test_type_checkers_see_what_is_there() -> None:
    tree = ast.parse(Path(xd.__file__).read_text(encoding="utf-8"))
    imports = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    for node in imports:
        for alias in node.names:
            assert getattr(xd, alias.name) is getattr(importlib.import_module(str(node.module)), alias.name)
    assert set(dir(xd)) == {"__version__", *(alias.name for node in imports for alias in node.names)}


def test_check_returns_what_the_command_prints(tmp_path: Path, capsys: Printed) -> None:
    recordings = recordings_file(tmp_path)
    problem = xd.check(CONFIG)
    assert problem.feasibility is not None
    assert problem.feasibility.identifying == 1.0
    identified = xd.check(recordings, ROBOT)
    assert identified.identification is not None
    for file, checked, options in ((CONFIG, problem, []), (recordings, identified, ["--robot", ROBOT])):
        capsys.readouterr()
        assert call("check", file, *options) == 0
        assert capsys.readouterr().out == "\n".join(checked.lines) + "\n"
        assert " ".join(checked.lines) == f"{file}: {checked.summary}"

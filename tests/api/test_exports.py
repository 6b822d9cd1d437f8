"""Every command is a function of the package, and every result's type can be imported from it."""

import ast
import importlib
from pathlib import Path

import pytest

import expdesign as xd
from expdesign.app.commands.help import function_of, listed_commands
from tests.commands.calls import CONFIG, ROBOT, ROOT, Printed, call, recordings_file

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

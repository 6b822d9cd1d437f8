"""`make results NAME`: every page has commands whose modules are there, and the shortest is carried out."""

import importlib.util
import re

import pytest

from research.benchmarks.page import commands, main, pages


@pytest.mark.parametrize("name", pages())
def test_commands_of_a_page_run_what_is_there(name: str) -> None:
    found = commands(pages()[name])
    assert found
    for command in found:
        module = re.match(r"python -m ([\w.]+)", command)
        assert module is None or importlib.util.find_spec(module[1]) is not None, command
        assert module is not None or command.split()[0] in ("expdesign", "make"), command


def test_a_page_that_is_not_there(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["nothing"]) == 2
    assert "closed-loop" in capsys.readouterr().err

"""Commands are made of signatures and docstrings: nothing is said twice, and nothing is left unsaid."""

import inspect
from collections.abc import Mapping
from typing import get_args

import pytest

import expdesign as xd
from expdesign.app.commands.docstring import Docstring
from expdesign.app.commands.listed import function_of, listed_commands
from expdesign.app.commands.maker import made
from expdesign.app.commands.spelling import SPELLINGS


def options_of(name: str) -> Mapping[str, str]:
    """Help of every argument and option of a command."""
    command, _ = made(name)
    return {key: get_args(kind)[1].help for key, kind in command.__annotations__.items() if key != "return"}


@pytest.mark.parametrize("name", [name for name in listed_commands() if function_of(name)])
def test_every_option_has_help_and_every_argument_is_an_option(name: str) -> None:
    options = options_of(name)
    assert all(text.endswith(".") and text[0] == text[0].upper() for text in options.values()), options
    function = getattr(xd, str(function_of(name)))
    docstring, parameters = Docstring.of(function.__doc__), inspect.signature(function).parameters
    assert set(docstring.arguments) == set(parameters)
    spelling = SPELLINGS.get(name)
    left_out = {"progress", "callback", "executors", "ended", "searched"}
    if spelling is not None:
        left_out |= {*spelling.hidden, *spelling.always}
    names = {spelling.name(argument) if spelling else argument for argument in parameters}
    assert names - set(options) <= left_out


def test_a_docstring_in_its_parts() -> None:
    text = """Do it.

    And more
    of it.

    Args:
        file: what is read, over
            two lines. In Python also a frame.
        seed: of chance.

    Command:
        Ctrl-C ends it.

        expdesign do file.csv
    """
    found = Docstring.of(text)
    assert found.description == ("Do it.", "And more of it.")
    assert found.option("file") == "What is read, over two lines."
    assert found.option("seed") == "Of chance."
    assert found.option("other") == ""
    assert found.help.splitlines()[::2] == [
        "Do it.",
        "And more of it.",
        "Ctrl-C ends it.",
        "Example: expdesign do file.csv",
    ]

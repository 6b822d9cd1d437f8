"""Messages speak of arguments in Python and of options on the command line."""

import re
from pathlib import Path

import pytest

import expdesign as xd
from expdesign.app.commands.spelling import SPELLINGS, Spelling
from expdesign.errors import ExpdesignError
from tests.commands.calls import CONFIG, ROBOT, Printed, call, plan_file, refusal

SOURCES = Path(xd.__file__).parent
_OPTION = re.compile(r"(?<!var)[( `]--[a-z]")
_COMMAND = re.compile(
    r"expdesign [a-z]+ |wrote \(`--out`|`--out` filled|dask worker| --targets {|    --conceal |--plant equ"
)
"""Where an option stands in a command that is named, which is the same for everybody."""


def test_a_message_is_spelled_by_whoever_reads_it() -> None:
    text = "Give argument `prior`, or argument `frames=unknown` (argument `other_robot`)."
    assert Spelling().said(text) == "Give --prior, or --frames unknown (--other-robot)."
    assert (
        Spelling().said("argument `force=True` or argument `shared_reference=False`")
        == "--force or --no-shared-reference"
    )
    assert SPELLINGS["register"].said("argument `deviation`") == "--std"


def test_the_same_refusal_in_python_and_as_a_command(tmp_path: Path, capsys: Printed) -> None:
    plan = plan_file(tmp_path)
    for arguments, options, python, command in (
        ({"conceal": "creep"}, ["--conceal", "creep"], "argument `conceal`: `creep`", "--conceal: `creep`"),
        ({"seed": -1}, ["--seed=-1"], "argument `seed`: -1", "--seed: -1"),
    ):
        with pytest.raises(ExpdesignError) as caught:
            xd.simulate(CONFIG, plan, **arguments)  # type: ignore[arg-type]
        assert caught.value.message.startswith(python)
        said = refusal(capsys, "simulate", CONFIG, plan, *options, "--out", tmp_path / "x.csv")
        assert f"expdesign: {command}" in said


def test_results_speak_of_arguments_too(tmp_path: Path, capsys: Printed) -> None:
    plan = plan_file(tmp_path)
    assert "argument `readings` adds" in xd.predict(ROBOT, plan).notes[0]
    assert call("predict", ROBOT, plan, "--out", tmp_path / "x.csv") == 0
    assert "--readings adds" in capsys.readouterr().err


def test_no_message_of_the_library_names_an_option() -> None:
    """Options stand in commands alone; docstrings are help."""
    found = []
    for file in SOURCES.rglob("*.py"):
        if "commands" in file.parts:
            continue
        text = re.sub(r'"""(.|\n)*?"""', "", file.read_text(encoding="utf-8"))
        text = text.replace("var(--", "")
        found += [f"{file.name}: {x}" for x in text.splitlines() if _OPTION.search(x) and not _COMMAND.search(x)]
    assert found == []

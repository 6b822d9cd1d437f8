"""Commands are made of signatures and docstrings: help, options, completion, and words for whoever reads a message."""

import inspect
import re
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import get_args

import pytest

import expdesign as xd
from expdesign.app.commands.help import COMMANDS, GROUPS, Docstring, function_of, listed_commands
from expdesign.app.commands.main import main
from expdesign.app.commands.maker import made
from expdesign.app.commands.spelling import SPELLINGS, Spelling
from expdesign.errors import ExpdesignError
from tests.commands.calls import CONFIG, ROBOT, Printed, call, plan_file, refusal, refused

HEAVY = ("casadi", "numpy", "pandas", "plotly", "pymoo", "scipy")


@pytest.mark.parametrize("name", listed_commands())
def test_every_command_has_help_with_an_example(name: str, capsys: Printed) -> None:
    """An option is a noun or an imperative, not the rest of a sentence, and stands in its group."""
    assert call(name, "--help") == 0
    text = capsys.readouterr().out
    assert f"expdesign {name} " in text.split("Example:")[1]
    first = listed_commands()[name]
    assert first.endswith(".")
    assert first.split()[0] in text
    assert not re.search(r"^ .*(> | {2})Of ", text, re.MULTILINE)
    titles = re.findall(r"^(\w+):$", text, re.MULTILINE)
    assert titles == [title for title in ("Arguments", "Options", *GROUPS) if title in titles]


def test_the_list_of_commands_imports_no_library() -> None:
    code = (
        "import sys\n"
        "from expdesign.app.commands.main import main\n"
        "try:\n    main(['--help'])\n"
        f"finally:\n    print(sorted(set(sys.modules) & set({HEAVY!r})), file=sys.stderr)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert done.stderr.strip() == "[]"
    for name, first in listed_commands().items():
        assert name in done.stdout
        assert first.split()[0] in done.stdout


def test_the_commands_stand_in_three_groups(capsys: Printed) -> None:
    assert call("--help") == 0
    text = capsys.readouterr().out
    places = [text.index(f"{title}:") for title in COMMANDS]
    assert places == sorted(places)
    names = [line.split()[0] for line in text[places[0] :].splitlines() if re.match("  [a-z]", line)]
    assert names == list(listed_commands())
    assert names == [name for group in COMMANDS.values() for name in group]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("evalate", "no such command `evalate`. Did you mean `evaluate`? `expdesign --help` says"),
        ("identify --ouut x a b", "identify: no such option: --ouut (Possible options: --out). `expdesign identify"),
        ("identify robot.yaml", "identify: missing argument `recordings`. `expdesign identify --help` says"),
        ("run a.yaml --seconds soon", "--seconds: input should be a valid number"),
    ],
)
def test_words_that_are_no_command(words: str, said: str, capsys: Printed) -> None:
    """Answered like everything else: where, what, and what to do, in one line."""
    assert refused(capsys, *words.split()).startswith(f"expdesign: {said}")


@pytest.mark.parametrize(("words", "wanted"), [("expdesign ide", "identify"), ("expdesign run --o", "--out")])
def test_a_shell_can_complete(words: str, wanted: str, monkeypatch: pytest.MonkeyPatch, capsys: Printed) -> None:
    environment = {"_EXPDESIGN_COMPLETE": "complete_bash", "COMP_WORDS": words, "COMP_CWORD": str(words.count(" "))}
    for key, value in environment.items():
        monkeypatch.setenv(key, value)
    monkeypatch.setattr(sys, "argv", ["expdesign"])
    monkeypatch.setattr(sys.modules["__main__"], "__package__", "")  # as where pytest is no `python -m`
    with pytest.raises(SystemExit):
        main()
    assert wanted in capsys.readouterr().out.split()


def test_choices_of_an_option_that_is_repeated_are_listed_and_checked(capsys: Printed) -> None:
    assert call("identify", "--help") == 0
    assert "--further <list[masses|tool|harmonics|drift]>" in capsys.readouterr().out
    said = refused(capsys, "identify", ROBOT, "recordings.csv", "--out", "x", "--further", "mases")
    assert "mases" in said
    assert "masses" in said


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

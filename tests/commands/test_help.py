"""Help of every command, with an example; and no library is imported for the list of commands."""

import re
import subprocess
import sys

import pytest

from expdesign.app.commands.grouped import GROUPS
from expdesign.app.commands.listed import COMMANDS, listed_commands
from expdesign.app.commands.main import main
from tests.commands.calls import ROBOT, Printed, call, refused

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
    with pytest.raises(SystemExit):
        main()
    assert wanted in capsys.readouterr().out.split()


def test_choices_of_an_option_that_is_repeated_are_listed_and_checked(capsys: Printed) -> None:
    assert call("identify", "--help") == 0
    assert "--further <list[masses|tool|harmonics|drift]>" in capsys.readouterr().out
    said = refused(capsys, "identify", ROBOT, "recordings.csv", "--out", "x", "--further", "mases")
    assert "mases" in said
    assert "masses" in said

"""Help of every command, with an example; and no library is imported for the list of commands."""

import subprocess
import sys

import pytest
from tests.commands.calls import call

from expdesign.commands.main import command_modules

HEAVY = ("casadi", "numpy", "pandas", "plotly", "pymoo", "scipy")


@pytest.mark.parametrize("name", command_modules())
def test_every_command_has_help_with_an_example(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert call(name, "--help") == 0
    text = capsys.readouterr().out
    assert f"expdesign {name} " in text.split("Example:")[1]
    first = command_modules()[name]
    assert first.endswith((".", "not identifiable."))
    assert first.split()[0] in text


def test_the_list_of_commands_imports_no_library() -> None:
    code = (
        "import sys\n"
        "from expdesign.commands.main import main\n"
        "try:\n    main(['--help'])\n"
        f"finally:\n    print(sorted(set(sys.modules) & set({HEAVY!r})), file=sys.stderr)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert done.stderr.strip() == "[]"
    for name, first in command_modules().items():
        assert name in done.stdout
        assert first.split()[0] in done.stdout


def test_a_command_that_is_nearly_right(capsys: pytest.CaptureFixture[str]) -> None:
    assert call("evalate") == 2
    assert "Did you mean 'evaluate'?" in capsys.readouterr().err


@pytest.mark.parametrize(("words", "wanted"), [("expdesign ide", "identify"), ("expdesign run --o", "--out")])
def test_a_shell_can_complete(words: str, wanted: str, monkeypatch: pytest.MonkeyPatch) -> None:
    environment = {"_EXPDESIGN_COMPLETE": "complete_bash", "COMP_WORDS": words, "COMP_CWORD": str(words.count(" "))}
    for key, value in environment.items():
        monkeypatch.setenv(key, value)
    code = "import sys; sys.argv = ['expdesign']; from expdesign.commands.main import main; main()"
    done = subprocess.run([sys.executable, "-c", code], check=False, capture_output=True, text=True)
    assert wanted in done.stdout.split()

"""The list of commands. Nothing is imported for it: what a command does is read off its source."""

import ast
from functools import lru_cache
from pathlib import Path

from expdesign.app.commands.docstring import Docstring

COMMANDS = {
    "The way, from a plan to a certificate": (
        "new", "check", "run", "sheet", "identify", "diagnose", "compensate", "verify",
    ),
    "Data": ("register", "correct", "simulate", "predict", "table", "physics"),
    "Research": ("compare", "montecarlo", "sweep", "evaluate", "next", "schema"),
}  # fmt: skip
"""Commands by the titles of their groups, in the order in which they are listed."""
_FUNCTIONS = {"next": "plan_next"}
"""Functions that are not called as their commands: `next` is a builtin."""
_HERE = Path(__file__).parent
_API = _HERE.parent / "api"


def function_of(name: str) -> str | None:
    """The function of the package that a command calls, in a module of its name; None where there is none."""
    function = _FUNCTIONS.get(name, name)
    return function if (_API / f"{function}.py").is_file() else None


@lru_cache(maxsize=1)
def listed_commands() -> dict[str, str]:
    """What each command does, in one sentence, in the order of the list."""
    return {name: _first(name) for names in COMMANDS.values() for name in names}


def _first(name: str) -> str:
    function = function_of(name)
    path, wanted = (_HERE / f"{name}.py", "command") if function is None else (_API / f"{function}.py", function)
    tree = ast.parse(path.read_text(encoding="utf-8"))
    node = next(node for node in tree.body if isinstance(node, ast.FunctionDef) and node.name == wanted)
    return Docstring.of(ast.get_docstring(node)).description[0]

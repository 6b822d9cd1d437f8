"""Robots are asked what they offer, and effects say what shows them: what the sources must not contain."""

import ast
from functools import cache
from pathlib import Path

import expdesign

SOURCES = Path(expdesign.__file__).parent
KINDS = {"Robot", "ParallelRobot", "SerialRobot", "Hexapod", "Bipod", "Body"}


@cache
def _sources() -> list[tuple[str, list[ast.AST]]]:
    """Every module of the package with all nodes of its syntax tree."""
    return [
        (path.relative_to(SOURCES).as_posix(), list(ast.walk(ast.parse(path.read_text(encoding="utf-8")))))
        for path in sorted(SOURCES.rglob("*.py"))
    ]


def test_no_one_asks_for_the_kind_of_a_robot() -> None:
    asked = []
    for name, nodes in _sources():
        for node in nodes:
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "isinstance":
                names = {part.id for part in ast.walk(node.args[1]) if isinstance(part, ast.Name)}
                if names & KINDS:
                    asked.append(f"{name}:{node.lineno}")
    assert asked == []


def test_effects_declare_the_readings_that_show_them() -> None:
    """None of them asks recordings what they are of."""
    asked = [
        f"{name}:{node.lineno}"
        for name, nodes in _sources()
        if name.startswith("chain/effects/")
        for node in nodes
        if isinstance(node, ast.Attribute)
        and node.attr in ("absolute", "marker", "markers")
        and not (isinstance(node.value, ast.Name) and node.value.id in ("row", "points") and node.attr == "absolute")
    ]
    assert asked == []

"""Robots are asked what they offer, and readings are chosen once: what the sources must not contain."""

import ast
from functools import cache
from pathlib import Path

import expdesign

SOURCES = Path(expdesign.__file__).parent
KINDS = {"Robot", "ParallelRobot", "SerialRobot", "Hexapod", "Bipod", "Body"}
#: Where the kind of reading is decided: what recordings hold, and the strategies.
STRATEGIES = ("chain/recordings/recordings.py", "chain/readings/", "diagnosis/base_models.py")


@cache
def _sources() -> list[tuple[str, list[ast.AST]]]:
    """Every module of the package with all nodes of its syntax tree."""
    return [
        (path.relative_to(SOURCES).as_posix(), list(ast.walk(ast.parse(path.read_text(encoding="utf-8")))))
        for path in sorted(SOURCES.rglob("*.py"))
    ]


def _modules(*without: str) -> list[tuple[str, list[ast.AST]]]:
    return [(name, nodes) for name, nodes in _sources() if not name.startswith(without)]


def test_no_one_asks_for_the_kind_of_a_robot() -> None:
    asked = []
    for name, nodes in _modules("robots/"):
        for node in nodes:
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "isinstance":
                names = {part.id for part in ast.walk(node.args[1]) if isinstance(part, ast.Name)}
                if names & KINDS:
                    asked.append(f"{name}:{node.lineno}")
    assert asked == []


ELSEWHERE = ("axis", "one", "part")
"""Owners of other things of these names: noise of an axis' reading, a fit to markers; files that are joined."""


#: Where a reading is compared with another, and why.
COMPARED = {
    # A deflection is the motion of the platform itself where nothing acts on the reading.
    "assurance/model_error/left_out.py": 1,
}


def test_no_one_branches_on_markers_but_the_strategies() -> None:
    asked: dict[str, int] = {}
    for name, nodes in _modules(*STRATEGIES):
        for node in nodes:
            if isinstance(node, ast.Compare) and any(isinstance(op, ast.Is | ast.IsNot) for op in node.ops):
                left = node.left
                called = left.attr if isinstance(left, ast.Attribute) else getattr(left, "id", "")
                owner = getattr(getattr(left, "value", None), "id", "")
                if called in ("marker", "markers", "reading", "positions") and owner not in ELSEWHERE:
                    asked[name] = asked.get(name, 0) + 1
    assert asked == COMPARED


#: Where a branch on the kind of reading still stands, and why: how often each module asks.
BRANCHES = {
    # What deflections leave undetermined is made least; of positions, knowledge beforehand decides.
    "estimation/fit.py": 1,
    # Positions are another estimator, and of arms a third, chosen here once; unloaded rows of them measure something.
    "estimation/identify.py": 3,
    # Measured poses and positions see where a platform is, deflections how it moved: loads are brought in otherwise.
    "assurance/acceptance/attained.py": 1,
    # Deflections have no part of a calibrated geometry; the tip of an arm that positions placed has one.
    "assurance/acceptance/fitted.py": 2,
    # Whether a chain without effects is linear.
    "chain/chain.py": 1,
    # What is identified beside geometry shows in absolute readings of an arm alone.
    "app/api/identify.py": 1,
    # A geometry that a configuration calibrates shows in absolute readings alone; that is said before the search.
    "app/api/diagnose.py": 1,
    # Whether the calibration that is asked for can be read off the columns, and which is usual.
    "estimation/geometric.py": 2,
    # Positions have no unloaded reading that rows could share.
    "chain/recordings/references.py": 1,
    # Units and signs of deflections are judged by the base model, which positions do not have alone.
    "assurance/plausibility/recordings.py": 1,
}


def test_branches_on_the_kind_of_reading_are_few_and_counted() -> None:
    """`reading.linear` and `measurand.absolute` outside the strategies, by module; a new one has to be argued for."""
    asked: dict[str, int] = {}
    for name, nodes in _modules(*STRATEGIES, "chain/recordings/measurand.py"):
        for node in nodes:
            if isinstance(node, ast.Attribute) and node.attr in ("linear", "absolute"):
                owner = node.value.attr if isinstance(node.value, ast.Attribute) else getattr(node.value, "id", "")
                if owner in ("reading", "measurand"):
                    asked[name] = asked.get(name, 0) + 1
    assert asked == BRANCHES


def test_effects_declare_the_readings_that_show_them() -> None:
    """None of them asks recordings what they are of."""
    asked = [
        f"{name}:{node.lineno}"
        for name, nodes in _modules()
        if name.startswith("chain/effects/")
        for node in nodes
        if isinstance(node, ast.Attribute)
        and node.attr in ("absolute", "marker", "markers")
        and not (isinstance(node.value, ast.Name) and node.value.id in ("row", "points") and node.attr == "absolute")
    ]
    assert asked == []

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


COMPARED = {
    "assurance/plausibility/instrument.py": "scale and jumps of an instrument show in positions alone",
    "assurance/model_error/physics.py": "a deflection is the motion of the platform where nothing acts on the reading",
    "estimation/identify.py": "all three components of a position are translations",
}
"""Modules that compare a reading with another, and why."""


def test_no_one_branches_on_markers_but_the_strategies() -> None:
    asked = set()
    for name, nodes in _modules(*STRATEGIES):
        for node in nodes:
            if isinstance(node, ast.Compare) and any(isinstance(op, ast.Is | ast.IsNot) for op in node.ops):
                left = node.left  # a name alone is a local value that there may be
                owner = getattr(left.value, "id", "") if isinstance(left, ast.Attribute) else "one"
                called = getattr(left, "attr", "")
                if called in ("marker", "markers", "reading", "positions") and owner not in ELSEWHERE:
                    asked.add(name)
    assert asked == set(COMPARED)


BRANCHES = {
    "estimation/fit.py": "what deflections leave undetermined is made least; of positions, prior knowledge decides",
    "estimation/identify.py": "positions are another estimator, of arms a third; their unloaded rows measure something",
    "assurance/acceptance/attained.py": "poses and positions see where a platform is, deflections how it moved",
    "assurance/acceptance/fitted.py": "deflections have no part of a calibrated geometry",
    "chain/chain.py": "whether a chain without effects is linear",
    "app/api/identify.py": "what is identified together with geometry shows in absolute readings of an arm alone",
    "app/api/diagnose.py": "a geometry that a configuration calibrates shows in absolute readings alone",
    "estimation/geometric.py": "whether the calibration that is asked for can be read off the columns",
    "chain/recordings/references.py": "positions have no unloaded reading that rows could share",
}
"""Modules that branch on the kind of reading, and why; a further one has to be argued for."""


def test_modules_that_branch_on_the_kind_of_reading_are_few() -> None:
    """`reading.linear` and `measurand.absolute` outside the strategies."""
    asked = set()
    for name, nodes in _modules(*STRATEGIES, "chain/recordings/measurand.py"):
        for node in nodes:
            if isinstance(node, ast.Attribute) and node.attr in ("linear", "absolute"):
                owner = node.value.attr if isinstance(node.value, ast.Attribute) else getattr(node.value, "id", "")
                if owner in ("reading", "measurand"):
                    asked.add(name)
    assert asked == set(BRANCHES)


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

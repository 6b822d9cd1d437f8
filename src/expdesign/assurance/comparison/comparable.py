"""Whether accuracies of several configurations can be laid over each other, and if not, why.

An error in tolerances means the same only where the targets, their loads and tolerances, the noise of the instrument
and the way of averaging are the same. Robots, poses, loads of the experiment, and numbers of measurements may differ:
they are what one wants to compare.
"""

from typing import Any

from expdesign.errors import InputError
from expdesign.io.schema import shortened
from expdesign.planning.problem import DesignProblem

PARTS = (("targets",), ("aggregate",), ("experiment", "deflection_noise"))


def require_comparable(problems: list[DesignProblem]) -> None:
    """Raise an `InputError` that says what differs where configurations cannot be laid over each other."""
    first = problems[0]
    for other in problems[1:]:
        found = differences(first, other)
        if found:
            more = f"; and {len(found) - 4} more" if len(found) > 4 else ""
            what = f"not comparable with {first.source}: {'; '.join(found[:4])}{more}"
            remedy = "Make them the same, or compare each by itself (argument `separate`)."
            raise InputError(what, where=other.source, remedy=remedy)


def differences(first: DesignProblem, second: DesignProblem) -> list[str]:
    """What differs so that accuracies of two configurations do not mean the same, in words (`here`: in the second)."""
    found: list[str] = []
    for path in PARTS:
        pair = []
        for problem in (first, second):
            content: Any = problem.config
            for key in path:
                content = content.get(key, {})
            pair.append(content)
        found += _differences(pair[0], pair[1], ".".join(path))
    return found


def _differences(first: Any, second: Any, place: str) -> list[str]:
    if isinstance(first, dict) and isinstance(second, dict):
        keys = list(dict.fromkeys([*first, *second]))
        return [text for key in keys for text in _differences(first.get(key), second.get(key), f"{place}.{key}")]
    if isinstance(first, list) and isinstance(second, list) and len(first) == len(second):
        pairs = zip(first, second, strict=True)
        return [text for i, (one, two) in enumerate(pairs) for text in _differences(one, two, f"{place}[{i}]")]
    if first == second:
        return []
    if isinstance(first, list) and isinstance(second, list):
        return [f"`{place}` has {len(second)} entries here and {len(first)} there"]
    return [f"`{place}` is {_said(second)} here and {_said(first)} there"]


def _said(value: Any) -> str:
    return "not given" if value is None else shortened(value)

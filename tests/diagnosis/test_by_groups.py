"""Groups of effects and what held-out rows say of those that go on with time."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from expdesign.diagnosis import by_groups as module
from expdesign.diagnosis.by_groups import by_groups
from expdesign.diagnosis.frame import framed
from expdesign.diagnosis.group_library import GroupLibrary
from expdesign.diagnosis.held_out import HeldOut
from tests.chain.bodies import BODY
from tests.identification.experiments import read
from tests.ports.test_supports import column_rows


@pytest.mark.parametrize(("of_all", "kept"), [(1.5, "all"), (40.0, "lasting")])
def test_held_out_rows_speak_against_groups_that_go_on(
    monkeypatch: pytest.MonkeyPatch, of_all: float, kept: str
) -> None:
    """Groups with memory that predict left-out blocks and not the rows marked `test` give way to those without."""
    frame = column_rows()
    frame["split"] = np.where(np.arange(len(frame)) % 5 == 0, "test", "train")
    asked: list[GroupLibrary] = []

    def grouped(*arguments: Any) -> Any:
        asked.append(arguments[-1])
        name = "all" if len(asked) == 1 else "lasting"
        return SimpleNamespace(name=name, after=1.0, noise=1.0, before=60.0, found=(1,))

    def errors(groups: Any, frame: Any) -> HeldOut:
        return HeldOut(50.0, 1.0, 50.0, of_all if groups.name == "all" else 10.0, 1.0, "rows marked `test`")

    monkeypatch.setattr(module, "grouped", grouped)
    monkeypatch.setattr(module, "_errors", errors)
    here = framed(BODY, read(frame, BODY), without=frozenset(), report=lambda stage, detail: None)
    found: Any = by_groups(here)[0]
    assert found.groups.name == kept
    if kept == "lasting":
        everything, lasting = asked
        assert 0 < len(lasting.groups) < len(everything.groups)
        assert not any(group.goes_on for group in lasting.groups)

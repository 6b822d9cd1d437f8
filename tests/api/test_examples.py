"""The examples in the docstrings of the functions that are used most, one after the other in one folder."""

import doctest
import inspect
from pathlib import Path

import pytest

import expdesign as xd
from tests.commands.calls import ROOT

PLAN = """sequence,series,x_m,y_m,fx_N,fy_N
1,1,0.03,-0.3,0,-1000
2,2,-0.1,-0.2,500,-800
3,3,0.1,-0.1,-500,-800
4,4,0,-0.3,0,-1000
"""
IN_ORDER = (
    "run", "evaluate", "simulate", "identify", "diagnose", "predict", "compensate", "montecarlo", "plan_next", "verify",
)  # fmt: skip


def test_examples_say_what_they_say(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "configs").symlink_to(ROOT / "configs")
    (tmp_path / "plan.csv").write_text(PLAN, encoding="utf-8")
    for name in IN_ORDER:
        if name == "verify":
            commands = xd.compensate("identified/model.yaml", "configs/bipod.yaml").save("commands.csv")
            xd.simulate("configs/bipod.yaml", commands, seed=2).save("check.csv")
        text = inspect.getdoc(getattr(xd, name)) or ""
        example = doctest.DocTestParser().get_doctest(text, {"xd": xd}, name, name, 0)
        assert example.examples, f"{name} has no example"
        said: list[str] = []
        doctest.DocTestRunner(verbose=False).run(example, out=said.append)
        assert said == []
        if name == "simulate":
            xd.simulate("configs/bipod.yaml", "plan.csv", seed=1).save("recordings.csv")

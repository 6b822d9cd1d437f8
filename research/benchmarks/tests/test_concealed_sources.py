"""Sources by engines of others: cases that repeat and are what they claim, truths that stay apart, no shared code."""

from __future__ import annotations

import ast
from importlib import import_module
from pathlib import Path
from types import ModuleType

import numpy as np
import pandas as pd
import pytest

from research.benchmarks import concealed
from research.benchmarks.concealed.case import asked_of, kept_cases, write_questions, write_truth
from research.benchmarks.concealed.concealment import orders

COMMON = {"arms", "campaigns", "case", "concealment", "hexapods"}
ENGINES = {"second_source": ("mujoco", "openseespy", "Pynite"), "third_source": ("skfem",)}


def cases_of(source: str) -> ModuleType:
    for engine in ENGINES[source]:
        pytest.importorskip(engine, reason=f"its extra is {source.replace('_', '-')}")
    return import_module(f"research.benchmarks.concealed.{source}.cases")


def rms_of_base(later: pd.DataFrame) -> float:
    """What the base model leaves of the held-out rows without noise, in standard deviations."""
    names = [str(name)[5:] for name in later if str(name).startswith("true_")]
    error = later[[f"true_{name}" for name in names]].to_numpy() - later[[f"base_{name}" for name in names]].to_numpy()
    std = later[[f"s{name}" if name.startswith("p") else f"s{name[1:]}" for name in names]].to_numpy()
    return float(np.sqrt(np.mean((error / std) ** 2)))


@pytest.mark.parametrize(
    ("source", "kind"),
    [
        *(("second_source", kind) for kind in ("leg_gap", "leg_warm", "undeclared_tool", "wrong_centre_of_mass")),
        *(("third_source", kind) for kind in ("presliding", "plate_base", "turning_bearing", "umbilical")),
    ],
)
def test_a_case_repeats_by_its_seed_and_keeps_its_truth_apart(source: str, kind: str, tmp_path: Path) -> None:
    draw_case = cases_of(source).draw_case
    case, again = (draw_case((kind, False), np.random.default_rng([1, 4])) for _ in range(2))
    pd.testing.assert_frame_equal(case.recordings, again.recordings)
    assert case.truth == again.truth
    assert case.truth["family"] == source
    assert 1.8 <= case.truth["mismatch_in_std"] <= 11.0
    assert 0.15 <= (case.recordings["split"] == "test").mean() <= 0.35
    case.truth["case"] = "case-001"
    write_questions(case, tmp_path / "cases" / "case-001")
    write_truth(case, tmp_path / "truth" / "case-001")
    shown = "".join(path.read_text(encoding="utf-8") for path in (tmp_path / "cases").rglob("*.*"))
    assert not [word for word in ("true_", "base_m", kind, "mismatch", "parts") if word in shown]
    readings = [name[5:] for name in case.later if str(name).startswith("true_")]
    held = case.recordings[case.recordings["split"] == "test"]
    for name in readings:  # held-out rows show what was read, never what it would have been without noise
        assert (held[name].to_numpy() != case.later[f"true_{name}"].to_numpy()).all()
    asked, held_out = asked_of(case)  # the whole campaign, without readings
    assert len(asked) == len(case.recordings)
    assert asked["sequence"][held_out].tolist() == held["sequence"].tolist()
    assert not set(readings) & set(asked)
    (kept,) = kept_cases(tmp_path)
    assert kept.robot == case.robot
    assert kept.files == case.files
    pd.testing.assert_frame_equal(kept.later, case.later)


@pytest.mark.parametrize(
    ("source", "kind"),
    [("second_source", "leg_contact"), ("third_source", "oil_film"), ("third_source", "warm_link")],
)
def test_healthy_cases_hide_nothing(source: str, kind: str) -> None:
    case = cases_of(source).draw_case((kind, True), np.random.default_rng(8))
    assert case.truth["effects"] == []
    assert rms_of_base(case.later) < 0.8


@pytest.mark.parametrize("source", ENGINES)
def test_every_kind_has_its_turn(source: str) -> None:
    kinds = tuple(cases_of(source).KINDS)
    assert len(kinds) >= 12
    assert sorted(kind for kind, bare in orders(kinds, len(kinds), 6, seed=3) if not bare) == sorted(kinds)


@pytest.mark.parametrize("source", ENGINES)
def test_it_shares_no_code_with_the_laboratory_nor_with_the_program(source: str) -> None:
    """What makes cases imports neither, nor another source; only `run` uses the first source's asking and judging."""
    folder = Path(concealed.__path__[0])
    for path in (*(folder / source).glob("*.py"), *(folder / f"{name}.py" for name in COMMON)):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [str(node.module)] if isinstance(node, ast.ImportFrom) else []
            assert not [name for name in names if name.startswith(("research.laboratory", "expdesign"))], path
            if path.name != "run.py" and isinstance(node, ast.ImportFrom) and node.level > 1:
                assert node.module is None or node.module in COMMON, path

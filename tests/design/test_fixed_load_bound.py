"""A bound where nothing of the load can be chosen, and every pose is of a grid."""

from pathlib import Path

import yaml

from expdesign.planning.optimality.certificate import Certificate
from expdesign.planning.problem_file import read_problem
from expdesign.planning.search import search
from tests.sweeps.small import SMALL


def test_a_fixed_load_has_a_bound(tmp_path: Path) -> None:
    """One corner of the range of loads, with no coordinate: it once could not be laid out."""
    (tmp_path / "config.yaml").write_text(yaml.safe_dump(SMALL), encoding="utf-8")
    problem = read_problem(tmp_path / "config.yaml")
    front = search(problem)
    bound = Certificate(problem, 0.0).bound(front.decisions).value
    assert bound is not None
    assert 0.0 < bound <= float(front.criteria["duir"].min()) * (1.0 + 1e-9)

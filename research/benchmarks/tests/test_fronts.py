"""Random configurations of the benchmark of fronts: the same by number, and problems that a search can solve."""

from pathlib import Path

import numpy as np
import pytest

from expdesign.planning.sampling import require_identifiable, starting_designs
from research.benchmarks.fronts.configurations import problem, write


@pytest.mark.parametrize("number", [1, 3, 4])
def test_a_number_is_a_configuration(number: int, tmp_path: Path) -> None:
    once, again = (write(number, tmp_path / name) for name in ("once", "again"))
    assert once.read_bytes() == again.read_bytes()
    assert once.read_bytes() != write(number + 1, tmp_path / "once").read_bytes()


def test_what_is_drawn_can_be_searched(tmp_path: Path) -> None:
    kinds = set()
    for number in range(1, 13):
        found = problem(number, tmp_path)
        kinds.add((found.loaded.robot.kind, found.noise.shared_reference))
        require_identifiable(found, starting_designs(found, 40, np.random.default_rng(0)))
        assert found.loaded.sources
    assert len(kinds) >= 4

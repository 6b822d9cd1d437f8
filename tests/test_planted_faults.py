"""The faults that `research.benchmarks.planted_faults` plants stand in the sources, once each."""

import pytest

from research.benchmarks.planted_faults import FAULTS, FILES, FOLDERS, ROOT, Fault


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.what)
def test_a_fault_can_be_planted(fault: Fault) -> None:
    assert (ROOT / "src" / "expdesign" / fault.file).read_text(encoding="utf-8").count(fault.right) == 1
    assert all((ROOT / "tests" / folder).is_dir() for folder in fault.tests)


def test_what_is_copied_is_there() -> None:
    assert all((ROOT / name).is_dir() for name in FOLDERS)
    assert all((ROOT / name).is_file() for name in FILES)

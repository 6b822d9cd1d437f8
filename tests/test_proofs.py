"""Every proof that is named is there."""

from pathlib import Path

import pytest

from tests.proofs import PROOFS

HERE = Path(__file__).parent


def place(file: str) -> Path:
    return HERE.parent / file if file.startswith("research/") else HERE / file


@pytest.mark.parametrize("beginning", PROOFS)
def test_what_is_named_is_there(beginning: str) -> None:
    file, _, test = beginning.partition("::")
    assert place(file).exists()
    assert not test or f"def {test.partition('[')[0]}" in place(file).read_text(encoding="utf-8")

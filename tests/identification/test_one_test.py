"""One test and one threshold decide everywhere whether recordings refute a model."""

from pathlib import Path

import pytest
from scipy.stats import chi2

import expdesign
from expdesign.diagnosis.verdict import within_noise
from expdesign.estimation.goodness import FIT, StatementOfFit

ROOT = Path(expdesign.__file__).parent


@pytest.mark.parametrize("dof", [3, 40, 400])
def test_at_the_threshold_all_say_the_same(dof: int) -> None:
    limit = float(chi2.isf(FIT.refuted, dof))
    for value in (0.999 * limit, 1.001 * limit):
        refuted = StatementOfFit.of_chi2(value, dof).refuted
        assert refuted == (value > limit)
        assert FIT.allows(value, dof) is not refuted
        assert within_noise((value, dof)) is not refuted


def test_no_other_module_holds_a_threshold_to_a_p_value_of_its_own() -> None:
    """`refuted` is a field of one options class, and of that which names mistakes."""
    fields = {
        str(path.relative_to(ROOT))
        for path in ROOT.rglob("*.py")
        for line in path.read_text(encoding="utf-8").splitlines()
        if line.startswith("    refuted: float")
    }
    assert fields == {"estimation/goodness.py", "assurance/plausibility/evidence.py"}

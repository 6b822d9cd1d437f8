"""What changes between two rows and stays changed is one weight at an unknown time."""

import casadi as ca
import numpy as np
import pytest

from expdesign.chain.chain import Chain
from expdesign.chain.row import Row
from expdesign.diagnosis.evidence.dictionary import Dictionary
from expdesign.diagnosis.evidence.refinement import refined
from expdesign.diagnosis.evidence.state import linearised
from tests.cases import robot
from tests.diagnosis.samples import base_fit, sample_of
from tests.ports.machines import recordings_of

NAME = "bipod"


@pytest.mark.parametrize("share", [0.33, 0.62], ids=["early", "late"])
def test_a_leg_that_comes_loose_between_two_rows_is_one_weight_at_that_time(share: float) -> None:
    """Leg 1 yields by half more from there on; the time is found to 3 % of all of it."""
    here, plain = robot(NAME), recordings_of(None, NAME)
    assert plain.time is not None
    first, whole = float(plain.time[0]), float(np.ptp(plain.time))

    def loose(row: Row, force: ca.SX) -> ca.SX:
        return ca.if_else(row.clock > share * whole, 0.5, 0.0) * force

    sample = sample_of(NAME, recordings_of(loose, NAME))
    base = base_fit(NAME, sample)
    dictionary = Dictionary(here, sample, np.ones(Chain(here).compliances))
    present = linearised(base, sample)
    best = max((atom for atom in dictionary.atoms if atom.entry), key=lambda atom: present.gain(atom.directions)[0])
    found, _ = refined(best, dictionary.made, present) or (best, 0.0)
    assert found.entry is not None
    assert (found.entry.form, str(found.entry.component)) == ("compliance", "leg 1")
    (seen,) = found.entry.inputs
    assert seen.kind == "after"
    assert seen.setting[0] == pytest.approx(share * whole, abs=0.03 * whole)
    assert first == pytest.approx(0.0, abs=whole)

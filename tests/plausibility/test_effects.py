"""Physics that the base model leaves out is not taken for a mistake of units or signs."""

from dataclasses import replace

import numpy as np
import pytest

from expdesign.assurance.plausibility.recordings import recordings_findings
from expdesign.chain.chain import Chain
from expdesign.chain.effect import Effect
from expdesign.chain.row import row_data
from tests.cases import robot
from tests.chain.kinds import KINDS
from tests.chain.places import rows
from tests.identification.experiments import read


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_an_effect_of_typical_size_is_not_warned_of(kind: type[Effect]) -> None:
    here, generator = robot("irregular"), np.random.default_rng(0)
    exact = read(rows("irregular", "payload", series=6), here)
    for effect in kind.candidates(here, exact)[:2]:
        chain = Chain(here, (effect,))
        sizes = np.array([parameter.scale for parameter in effect.parameters])
        values = effect.neutral() + sizes * generator.choice([-1.0, 1.0], len(sizes))
        compliances = np.exp(0.15 * generator.standard_normal(chain.compliances))
        deflections = chain.predict(row_data(exact, here), np.concatenate([compliances, values]))
        if not np.isfinite(deflections).all():
            continue
        deviations = np.broadcast_to(0.01 * np.abs(deflections).mean(axis=0), deflections.shape)
        noisy = deflections + deviations * generator.standard_normal(deflections.shape)
        assert recordings_findings(replace(exact, deflections=noisy, deviations=deviations), here) == []
        assert recordings_findings(replace(exact, deflections=noisy, deviations=None), here) == []

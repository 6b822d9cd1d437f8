"""The directions of all effects at once against each effect alone on the chain."""

import numpy as np
import pytest

from expdesign.assurance.model_error.physics import (
    Directions,
    left_out,
    offsets,
    plan_points,
    sampled_points,
)
from expdesign.assurance.model_error.settings import Assumptions
from expdesign.chain.chain import Chain
from expdesign.chain.row import row_data
from tests.model_error.problems import ROBOTS, plans, problem


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("instrument", [True, False])
def test_every_effect_as_alone_on_the_chain(name: str, instrument: bool) -> None:
    few = frozenset({"joint_position_error", "friction_hysteresis", "encoder_periodic_error", "instrument_scale"})
    loaded = problem(name).loaded
    physics = left_out(problem(name), sampled_points(problem(name)), Assumptions(physics=few))
    configurations, loads = (array[0] for array in plans(name, 1))
    n_p = len(loaded.robot.stiffness)
    directions = Directions(Chain(loaded.robot), np.ones(n_p), physics)
    rows = row_data(plan_points(loaded, configurations, loads), loaded.robot)
    found = directions.at(rows, platform=not instrument)
    for entry, start in zip(physics, offsets(physics)[:-1], strict=True):
        chain = Chain(loaded.robot, (entry.effect,), instrument=instrument)
        values = np.concatenate([np.ones(n_p), entry.start])
        if entry.step:
            ends = [chain.predict(rows, np.concatenate([np.ones(n_p), v])) for v in (entry.at(entry.step), entry.start)]
            assert np.allclose(found[..., start], (ends[0] - ends[1]) / entry.step, rtol=1e-7, atol=1e-15)
            continue
        alone = chain.predict_with_sensitivities(rows, values)[1][:, :, n_p:][:, :, entry.free]
        mine = found[..., start : start + len(entry.free)]
        size = np.abs(alone).max(axis=(0, 1), keepdims=True)
        # What moves nothing is zero to rounding.
        assert (np.abs(mine - alone) <= 1e-7 * size + 1e-16).all(), entry.key

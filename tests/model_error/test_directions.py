"""The directions of all effects at once against each effect alone on the chain, and their adjoint."""

import numpy as np
import pytest
from tests.model_error.problems import ROBOTS, impact, plans, problem

from expdesign.arrays import FloatArray
from expdesign.assurance.model_error.directions import Directions
from expdesign.assurance.model_error.left_out import effects_of_problem, left_out, offsets, plan_points
from expdesign.assurance.model_error.prior import with_steps
from expdesign.assurance.model_error.settings import Assumptions
from expdesign.chain.chain import Chain
from expdesign.chain.row import row_data
from expdesign.mechanics.differentiation import gradient, independent


@pytest.mark.parametrize("name", ROBOTS)
def test_every_effect_as_alone_on_the_chain(name: str) -> None:
    """In what is measured and at the targets, where no instrument is."""
    few = frozenset({"joint_position_error", "friction_hysteresis", "encoder_periodic_error", "instrument_scale"})
    loaded = problem(name).loaded
    assumptions = Assumptions(physics=few)
    physics = with_steps(problem(name), left_out(*effects_of_problem(problem(name)), assumptions), assumptions)
    configurations, loads = (array[0] for array in plans(name, 1))
    directions = Directions(loaded.robot, physics)
    at_targets = [directions.at_target(loaded.load, *states) for states in zip(configurations, loads, strict=True)]
    measured = directions.at(loaded.load, configurations, loads, loaded.robot.jacobians(configurations))
    rows = row_data(plan_points(loaded, configurations, loads), loaded.robot)
    n_p = len(loaded.robot.stiffness)
    for entry, start in zip(physics, offsets(physics)[:-1], strict=True):
        for found, instrument in ((measured, True), (np.array(at_targets), False)):
            chain = Chain(loaded.robot, (entry.effect,), instrument=instrument)
            values = np.concatenate([np.ones(n_p), entry.start])
            if entry.step:
                ends = [chain.predict(rows, np.concatenate([np.ones(n_p), v])) for v in (entry.stepped, entry.start)]
                assert np.allclose(found[..., start], (ends[0] - ends[1]) / entry.step, rtol=1e-7, atol=1e-15)
                continue
            alone = chain.predict_with_sensitivities(rows, values)[1][:, :, n_p:][:, :, entry.free]
            mine = found[..., start : start + entry.columns]
            size = np.abs(alone).max(axis=(0, 1), keepdims=True)
            assert np.allclose(mine / (size + 1e-30), alone / (size + 1e-30), atol=1e-7), entry.key


@pytest.mark.parametrize("name", ROBOTS)
def test_adjoint_against_differences(name: str) -> None:
    columns = impact(name).directions.columns
    size = np.random.default_rng(7).normal(size=(6, columns)) * impact(name).deviations

    def at(configurations: FloatArray, loads: FloatArray) -> FloatArray:
        maps = problem(name).loaded.measure(configurations, loads).jacobians
        return impact(name).directions.along(problem(name).loaded.load, configurations, loads, maps, size)

    configurations, loads = (array[0] for array in plans(name, 1, seed=5))
    generator = np.random.default_rng(6)
    largest = np.abs(at(configurations, loads)).max(axis=0) + 1e-30
    seed = generator.normal(size=(*at(configurations, loads).shape,)) / largest
    arguments = [configurations, loads]
    for argument in (0, 1):
        states = independent(arguments[argument])
        found = at(*(states if place == argument else arguments[place] for place in (0, 1)))
        slopes = gradient(found, seed, arguments[argument])
        step = 1e-6 * generator.normal(size=arguments[argument].shape)
        sides = []
        for sign in (1.0, -1.0):
            moved = list(arguments)
            moved[argument] = arguments[argument] + sign * step
            sides.append(float((seed * at(*moved)).sum()))
        expected = (sides[0] - sides[1]) / 2.0
        assert float((slopes * step).sum()) == pytest.approx(expected, rel=1e-4, abs=1e-9 * np.abs(seed).sum())

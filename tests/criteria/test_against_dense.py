"""Every criterion against dense matrices and normal equations, for the whole table of set-ups."""

from itertools import product

import numpy as np
import pytest

from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.criteria.targets import Aggregate
from tests import oracle
from tests.cases import ALL_ERRORS, NOISES, ROBOTS, Setup, robot, setup
from tests.oracle import Array, Dense

MEASUREMENTS = 6
COUNT = 3


def by_hand(here: Setup, poses: Array, parameters: Array, series: Array) -> Dense:
    """One design of a set-up, from the poses and loads on, without the package's maps."""
    machine = robot(here.name)
    kind = here.loaded.load.kind
    turned = oracle.kinematics(machine, poses).rotation
    wrenches = oracle.load_wrench(kind, parameters, turned)
    errors = []
    for source in here.loaded.sources:
        per = [
            oracle.sensitivity(source.source, kind, p, r) * source.deviation
            for p, r in zip(parameters, turned, strict=True)
        ]
        errors.append((np.array(per), source.shared))
    return oracle.dense(
        oracle.observation(machine, poses, wrenches),
        oracle.compliance(machine, poses),
        here.noise.covariance,
        here.noise.axes,
        series,
        here.noise.shared_reference,
        errors,
        oracle.observation(machine, here.targets.configurations, here.target_wrenches),
    )


def compare(found: Array, expected: Array) -> None:
    np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-7 * np.abs(expected).max())


def check_pieces(found: Assessment, index: int, expected: Dense) -> None:
    """U, Z and the covariance of load errors at every target, singular values and rank of one design."""
    for target, (noise, sensitivity, force) in enumerate(
        zip(expected.noise, expected.sensitivity, expected.force, strict=True)
    ):
        root, shift = found.noise_root[index, target], found.force_root[index, target]
        scale = np.sqrt(np.diag(noise))
        compare(root @ root.T / np.outer(scale, scale), noise / np.outer(scale, scale))
        np.testing.assert_allclose(found.noise_variance[index, target], np.diag(noise), rtol=1e-6)
        z = found.force_sensitivity()[index, target]
        for row in range(len(z)):
            compare(z[row], sensitivity[row])
        if force.any():
            scale = np.sqrt(np.diag(force))
            compare(shift @ shift.T / np.outer(scale, scale), force / np.outer(scale, scale))
        np.testing.assert_allclose(found.force_variance[index, target], np.diag(force), rtol=1e-6)
    compare(found.singular_values[index], expected.singular_values)
    assert found.rank[index] == found.parameters
    assert found.condition[index] == pytest.approx(expected.singular_values[0] / expected.singular_values[-1], rel=1e-6)


EACH_ALONE = product(
    ["bipod-unequal", "irregular"], ["payload", "wrench"], ["shared-reference"],
    [((source, shared),) for source in ("com", "mass", "direction", "wrench") for shared in (True, False)],
)  # fmt: skip


@pytest.mark.parametrize(
    ("name", "kind", "noise", "errors"),
    [*product(ROBOTS, ["payload", "wrench"], NOISES, [ALL_ERRORS]), *EACH_ALONE],
)
def test_pieces_of_the_whole_table_and_of_each_source_alone(
    name: str, kind: str, noise: str, errors: tuple[tuple[str, bool], ...]
) -> None:
    here = setup(name, kind, noise, errors)
    poses, parameters, series = here.designs(np.random.default_rng(11), COUNT, MEASUREMENTS)
    found = here.assess(poses, parameters, series)
    assert found.identifies_targets.all()
    if not here.loaded.sources:
        np.testing.assert_array_equal(found.force_variance, 0.0)
    for index in range(COUNT):
        check_pieces(found, index, by_hand(here, poses[index], parameters[index], series[index]))


@pytest.mark.parametrize("aggregate", ["mean", "max"])
@pytest.mark.parametrize("name", ROBOTS)
def test_criteria_are_the_sums_of_the_interfaces(name: str, aggregate: Aggregate) -> None:
    here = setup(name, "payload", "covariance", ALL_ERRORS, aggregate)
    poses, parameters, series = here.designs(np.random.default_rng(13), COUNT, MEASUREMENTS)
    found = here.assess(poses, parameters, series)
    values = {key: criterion.values(found) for key, criterion in known_criteria().items()}
    importance, weights = here.targets.importance, here.targets.weights
    translations = robot(name).coordinates.translations
    for index in range(COUNT):
        expected = by_hand(here, poses[index], parameters[index], series[index])
        noise = np.array([np.trace(np.diag(w) @ u) for w, u in zip(importance, expected.noise, strict=True)])
        force = np.array([np.trace(np.diag(w) @ f) for w, f in zip(importance, expected.force, strict=True)])
        both = noise + force
        if aggregate == "max":
            duir, feir, total = np.sqrt(noise.max()), np.sqrt(force.max()), np.sqrt(both.max())
        else:
            duir, feir, total = (np.sqrt(np.average(part, weights=weights)) for part in (noise, force, both))
        mu = expected.singular_values
        traces = [np.trace(u[:translations, :translations]) for u in expected.noise]
        by_name = {
            "duir": duir,
            "feir": feir,
            "total": total,
            "o1": np.prod(mu) ** (1.0 / len(mu)) / np.sqrt(MEASUREMENTS),
            "o2": mu[-1] / mu[0],
            "o3": mu[-1],
            "o4": mu[-1] ** 2 / mu[0],
            "o5": 1.0 / np.sum(1.0 / mu),
            "o_tp": traces[0],
            "o_mv": np.mean(traces),
            "o_mv_max": np.max(traces),
        }
        for key, value in by_name.items():
            assert values[key][index] == pytest.approx(value, rel=1e-6), key


def test_directions_of_improvement() -> None:
    """O1 to O5 are maximised; errors and variances are minimised."""
    maximised = {name for name, criterion in known_criteria().items() if criterion.maximise}
    assert {f"o{i}" for i in range(1, 6)} <= maximised
    assert not maximised & {"duir", "feir", "total", "o_tp", "o_mv", "o_mv_max"}
    assert tuple(known_criteria())[:3] == ("duir", "feir", "total")


@pytest.mark.parametrize("name", ["bipod", "H1"])
def test_a_shared_reference_costs_accuracy_and_ignoring_it_costs_more(name: str) -> None:
    """Without the off-diagonal blocks the estimate is not the best one: Gauss and Markov (theory.md 3, C14)."""
    here = setup(name, "wrench", "shared-reference")
    poses, parameters, _ = here.designs(np.random.default_rng(14), 1, 6)
    poses[:] = poses[:, :1]
    found = here.assess(poses, parameters, np.ones((1, 6), dtype=np.int64))
    separate = here.assess(poses, parameters, np.arange(6)[None])
    covariance = oracle.noise_covariance(here.noise.covariance, np.ones(6), True)
    ignoring = separate.gain[0].swapaxes(0, 1).reshape(found.parameters, -1)
    knowing = found.gain[0].swapaxes(0, 1).reshape(found.parameters, -1)
    target = here.targets.observation[0]
    naive = np.diag(target @ ignoring @ covariance @ ignoring.T @ target.T)
    best = np.diag(target @ knowing @ covariance @ knowing.T @ target.T)
    np.testing.assert_allclose(best, found.noise_variance[0, 0], rtol=1e-8)
    assert np.all(best < naive)

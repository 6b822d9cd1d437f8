"""Simulated recordings have the noise and the load errors that the configuration states."""

from dataclasses import replace

import numpy as np
import pytest

from expdesign.planning.plan import Plan
from expdesign.planning.synthetic import load_errors
from tests.cases import ALL_ERRORS, Setup, robot, setup


def plan_for(case: Setup, rows: int, seed: int = 1) -> Plan:
    poses, loads, series = case.designs(np.random.default_rng(seed), 1, rows)
    return Plan(poses[0], loads[0], series[0])


@pytest.mark.parametrize("noise", ["covariance", "some-axes", "shared-reference"])
def test_noise_has_the_stated_covariance(noise: str) -> None:
    case = setup("H1", noise=noise)
    series = np.array([1, 1, 2])
    generator = np.random.default_rng(2)
    count = 20000
    pose_map = np.eye(case.loaded.robot.coordinates.n)[None].repeat(3, axis=0)  # this noise does not depend on it
    samples = case.noise.drawn(series, count, generator, pose_map).reshape(count, -1)
    same = series[:, None] == series[None, :]
    across = 0.5 * (np.eye(3) + same) if case.noise.shared_reference else np.eye(3)
    expected = np.kron(across, case.noise.covariance)
    scale = np.sqrt(np.diag(expected))
    found = samples.T @ samples / count
    np.testing.assert_allclose(
        found / np.outer(scale, scale), expected / np.outer(scale, scale), atol=5.0 * np.sqrt(2.0 / count)
    )


@pytest.mark.parametrize("kind", ["payload", "wrench"])
def test_load_errors_have_the_covariance_of_their_sources(kind: str) -> None:
    case = setup("H1", kind, errors=ALL_ERRORS)
    plan = plan_for(case, 3)
    rotation = robot("H1").jacobians(plan.configurations).rotation
    scaled = case.loaded.load_errors(rotation, plan.loads)
    expected = np.zeros((18, 18))
    for source, root in zip(case.loaded.sources, scaled, strict=True):
        if source.shared:
            stacked = root.reshape(18, -1)
            expected += stacked @ stacked.T
        else:
            for row in range(3):
                part = slice(6 * row, 6 * row + 6)
                expected[part, part] += root[row] @ root[row].T
    count = 4000
    samples = np.array([load_errors(case.loaded, plan, seed).ravel() for seed in range(count)])
    scale = np.sqrt(np.diag(expected))
    found = samples.T @ samples / count
    np.testing.assert_allclose(
        found / np.outer(scale, scale), expected / np.outer(scale, scale), atol=5.0 * np.sqrt(2.0 / count)
    )


def test_an_unloaded_row_has_no_load_error() -> None:
    case = setup("H1", errors=ALL_ERRORS)
    plan = plan_for(case, 4)
    loads = plan.loads.copy()
    loads[1, 0] = 0.0
    errors = load_errors(case.loaded, replace(plan, loads=loads), 3)
    assert not errors[1].any()
    assert errors[[0, 2, 3]].any(axis=1).all()

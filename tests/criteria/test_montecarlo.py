"""DUIR and FEIR against Monte-Carlo of the whole method with the exact non-linear compensation (theory.md 8).

Plant P1: X_loaded = X_cmd + A(X_cmd, ΔF)·c. Each sample measures, identifies, solves X̂_C + A(X̂_C, ΔF_D)·ĉ = X_D by
its fixed point, and looks where the plant goes. Nothing here but the numbers compared comes from the package.
"""

import numpy as np
import pytest
from tests import oracle
from tests.cases import ALL_ERRORS, ROBOTS, Setup, robot, setup
from tests.oracle import Array

from expdesign.criteria.criterion import known_criteria

SAMPLES = 100_000
BATCH = 20_000
MEASUREMENTS = 4


def estimated(here: Setup, poses: Array, assumed: Array, deflections: Array) -> Array:
    """ĉ (s, n_p) by generalised least squares from deflections (s, m, n), assuming the nominal wrenches."""
    machine = robot(here.name)
    a = oracle.observation(machine, poses, assumed)
    weight = np.linalg.inv(here.noise.covariance)
    information = np.einsum("mip,ij,mjq->pq", a, weight, a)
    scale = 1.0 / np.sqrt(np.diag(information))
    right = np.einsum("mip,ij,smj->sp", a, weight, deflections) * scale
    return np.linalg.solve(information * np.outer(scale, scale), right.T).T * scale


def attained_errors(here: Setup, target: int, estimates: Array) -> Array:
    """X̂_A − X_D (s, n) with the exact compensation for each estimate."""
    machine, wanted = robot(here.name), here.targets.configurations[target]
    load = here.target_wrenches[target]
    command = np.broadcast_to(wanted, (len(estimates), len(wanted)))
    for _ in range(3):
        predicted = np.einsum("sij,sj->si", oracle.observation(machine, command, load), estimates)
        command = wanted - predicted
    return command + oracle.observation(machine, command, load) @ machine.compliance - wanted


def squared_errors(here: Setup, poses: Array, parameters: Array, *, noise: bool, seed: int) -> Array:
    """Per sample, the weighted mean over targets of Σ_i (e_i/tol_i)²."""
    machine, kind = robot(here.name), here.loaded.load.kind
    generator = np.random.default_rng(seed)
    turned = oracle.kinematics(machine, poses).rotation
    assumed = oracle.load_wrench(kind, parameters, turned)
    true_maps = oracle.compliance(machine, poses)
    root = np.linalg.cholesky(here.noise.covariance)
    squares = []
    for _ in range(SAMPLES // BATCH):
        wrenches = np.broadcast_to(assumed, (BATCH, *assumed.shape)).copy()
        for source in here.loaded.sources:
            count = 1 if source.shared else MEASUREMENTS
            delta = generator.normal(size=(BATCH, count, len(source.deviation))) * source.deviation
            delta = np.broadcast_to(delta, (BATCH, MEASUREMENTS, len(source.deviation)))
            wrenches += oracle.disturbed_wrench(source.source, kind, parameters, turned, delta) - assumed
        deflections = np.einsum("mij,smj->smi", true_maps, wrenches)
        if noise:
            deflections += generator.normal(size=deflections.shape) @ root.T
        estimates = estimated(here, poses, assumed, deflections)
        total = np.zeros(BATCH)
        for target, weight in enumerate(here.targets.weights):
            errors = attained_errors(here, target, estimates)
            total += weight * (errors**2 * here.targets.importance[target]).sum(axis=1)
        squares.append(total / here.targets.weights.sum())
    return np.concatenate(squares)


def check(name: str, kind: str, criterion: str, errors: tuple[tuple[str, bool], ...], noise: bool, seed: int) -> None:
    here = setup(name, kind, "covariance", errors)
    poses, parameters, series = here.designs(np.random.default_rng(21), 1, MEASUREMENTS)
    predicted = float(known_criteria()[criterion].values(here.assess(poses, parameters, series))[0]) ** 2
    squares = squared_errors(here, poses[0], parameters[0], noise=noise, seed=seed)
    standard_error = squares.std(ddof=1) / np.sqrt(SAMPLES)
    assert standard_error < 0.01 * predicted
    assert abs(squares.mean() - predicted) < 3.0 * standard_error


@pytest.mark.parametrize("name", ["bipod", "irregular"])
def test_duir(name: str) -> None:
    check(name, "wrench", "duir", (), True, 1)


@pytest.mark.parametrize("shared", [True, False], ids=["shared", "independent"])
@pytest.mark.parametrize("source", ["com", "mass", "direction", "wrench"])
@pytest.mark.parametrize("name", ["bipod", "irregular"])
def test_feir(name: str, source: str, shared: bool) -> None:
    if source == "com" and name == "bipod":
        assert setup(name, "payload", errors=((source, shared),)).loaded.sources == ()
        return
    check(name, "payload", "feir", ((source, shared),), False, 2)


@pytest.mark.parametrize("name", [name for name in ROBOTS if name in {"bipod-unequal", "moving-xyz"}])
def test_total(name: str) -> None:
    """Noise and all four load errors at once."""
    check(name, "payload", "total", ALL_ERRORS, True, 3)

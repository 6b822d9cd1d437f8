"""Errors drawn at random have the covariances that the criteria assume (theory.md 3 and 5.3)."""

from itertools import product
from typing import Any

import numpy as np
import pytest

from tests.cases import SOURCES, Setup, setup
from tests.oracle import Array

COUNT = 40_000


def drawn(here: Setup, distribution: Any = "normal") -> tuple[Array, Array]:
    """Errors (s, 3, n) of a plan whose second measurement is unloaded, and the sensitivities of its one source."""
    poses, loads, _ = here.designs(np.random.default_rng(1), 1, 3)
    loads[0, 1] = 0.0
    where = (poses[0], loads[0])
    errors = here.loaded.drawn_errors(*where, COUNT, np.random.default_rng(2), distribution)
    rotation = here.loaded.robot.jacobians(poses[0]).rotation
    return errors, here.loaded.load_errors(rotation, loads[0])[0]


@pytest.mark.parametrize("shared", [True, False], ids=["shared", "independent"])
@pytest.mark.parametrize(("load", "source"), [*product(["payload"], SOURCES), ("wrench", "direction")])
def test_covariance_across_measurements(load: str, source: str, shared: bool) -> None:
    here = setup("irregular", load, errors=((source, shared),))
    errors, sensitivity = drawn(here)
    assert not errors[:, 1].any()  # an unloaded measurement has no load error
    found = np.einsum("sin,sjm->injm", errors, errors) / COUNT
    same = np.ones((3, 3)) if shared else np.eye(3)
    expected = np.einsum("inp,jmp,ij->injm", sensitivity, sensitivity, same)
    expected[1] = expected[:, :, 1] = 0.0
    variance = np.einsum("inin->in", expected)
    scale = np.sqrt(np.maximum(np.einsum("in,jm->injm", variance, variance), 1e-300))
    assert np.abs((found - expected) / np.where(scale > 1e-20, scale, np.inf)).max() < 5.0 * np.sqrt(2.0 / COUNT)


def test_uniform_errors_have_the_same_deviation_and_are_bounded() -> None:
    here = setup("bipod", "payload", errors=(("mass", True),))
    normal, sensitivity = drawn(here)
    uniform, _ = drawn(here, "uniform")
    bound = np.sqrt(3.0) * np.abs(sensitivity[..., 0])
    assert (np.abs(uniform) <= bound + 1e-12).all()
    assert (np.abs(uniform[:, 0]).max(axis=0) > 0.999 * bound[0]).all()
    assert (np.abs(normal[:, 0]).max(axis=0) > 2.0 * bound[0]).all()
    assert uniform[:, 0].std(axis=0) == pytest.approx(normal[:, 0].std(axis=0), rel=0.02)


@pytest.mark.parametrize("noise", ["covariance", "some-axes", "shared-reference"])
def test_noise_is_white_after_scaling(noise: str) -> None:
    here = setup("irregular", "payload", noise)
    series = np.array([1, 1, 2])
    pose_map = np.broadcast_to(np.eye(6), (3, 6, 6))
    readings = here.noise.drawn(series, COUNT, np.random.default_rng(3), pose_map)
    scaled = readings @ here.noise.whitener.T
    across = 0.5 * (np.eye(3) + (series[:, None] == series)) if here.noise.shared_reference else np.eye(3)
    found = np.einsum("sik,sjl->ikjl", scaled, scaled) / COUNT
    expected = np.einsum("ij,kl->ikjl", across, np.eye(scaled.shape[-1]))
    assert np.abs(found - expected).max() < 5.0 * np.sqrt(2.0 / COUNT)
